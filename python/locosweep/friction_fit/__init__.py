"""Friction characteristic: laws fitted to measured velocity and friction force."""

from locosweep.friction_fit.data import FrictionRun, read_friction
from locosweep.friction_fit.fit import fit_friction
from locosweep.friction_fit.result import FittedLaw, FittedParameter, FrictionFit

__all__ = [
    "FittedLaw",
    "FittedParameter",
    "FrictionFit",
    "FrictionRun",
    "fit_friction",
    "read_friction",
]
