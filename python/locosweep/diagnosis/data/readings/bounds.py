"""What a rig could do at most: bounds on its motion that no listed cause exceeds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from locosweep.files.runs import Run


def largest_force(run: Run, nominal: Mapping[str, float]) -> float:
    """Return the sum of all forces on the head, in N or N m: drive, friction and weight."""
    drive = float(np.abs(run.drive).max(initial=0.0)) * nominal["gain"]
    return drive + resistance(run, nominal) + nominal.get("gravity_torque", 0.0)


def resistance(run: Run, nominal: Mapping[str, float]) -> float:
    """Return the force that holds the head at rest: nominal friction, and weight on a slope."""
    return friction_level(run, nominal) + abs(_weight_along(run, nominal))


def friction_level(run: Run, nominal: Mapping[str, float]) -> float:
    """Return the nominal Coulomb friction in a run, in N or N m."""
    weight = nominal["mass"] * nominal["gravity"] * np.cos(_slope(run, nominal))
    return abs(float(nominal.get("coulomb_force", nominal.get("mu_coulomb", 0.0) * weight)))


def pull_back(
    run: Run, nominal: Mapping[str, float], x: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the weight against the drive at some positions: down a slope, and of a pendulum."""
    swing: NDArray[np.float64] = nominal.get("gravity_torque", 0.0) * np.sin(x)
    return swing + _weight_along(run, nominal)


def _slope(run: Run, nominal: Mapping[str, float]) -> float:
    return float(np.radians(nominal["slope_deg"] if run.slope_deg is None else run.slope_deg))


def _weight_along(run: Run, nominal: Mapping[str, float]) -> float:
    return float(nominal["mass"] * nominal["gravity"] * np.sin(_slope(run, nominal)))


def largest_acceleration(run: Run, nominal: Mapping[str, float]) -> float:
    """Return the acceleration of all forces on the nominal mass, in m/s^2 or rad/s^2."""
    return max(largest_force(run, nominal) / nominal["mass"], 1e-300)
