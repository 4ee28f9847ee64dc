"""Friction characteristic: laws fitted to measured velocity and friction force."""

from locosweep.characteristic.data import FrictionRun, read_friction
from locosweep.characteristic.fit import fit_friction
from locosweep.characteristic.result import FittedLaw, FittedParameter, FrictionFit

__all__ = [
    "FittedLaw",
    "FittedParameter",
    "FrictionFit",
    "FrictionRun",
    "fit_friction",
    "read_friction",
]
