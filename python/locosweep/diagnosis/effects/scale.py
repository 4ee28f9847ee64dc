"""Sizes of a rig and of its runs, which starts, ranges and magnitudes of effects follow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.simulation.replay import nominal_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run

_DOUBT = 3.0
"""Standard deviations that an uncertain value may be off."""


@dataclass(frozen=True)
class Scale:
    """Sizes of a rig and of its runs, none negative, SI; formulas of effects know their names."""

    mass: float
    nominal_level: float
    """Coulomb level at the nominal slope."""
    level: float
    """The same, but at least a thousandth of the forces: a size of friction is never 0."""
    least_level: float
    """Least Coulomb level that the uncertainty of the nominal file allows."""
    force: float
    """A large drive force."""
    peak: float
    """The largest one, which a single run may hold."""
    speed: float
    travel: float
    duration: float
    interval: float
    weight: float
    grip: float
    """Weight of the anchored body on the ground."""
    viscous: float
    has_force_level: bool
    """True if the nominal file gives its Coulomb level as a force."""
    rotary: bool
    replayed: float
    """Length of a free replay, s: that of a run, or of a window of one."""


def level_of(nominal: Mapping[str, float]) -> float:
    """Coulomb level at the nominal slope, N: what levels of effects are given beside."""
    cosine = float(np.cos(np.radians(nominal["slope_deg"])))
    weight = nominal["mass"] * nominal["gravity"]
    return nominal.get("coulomb_force", nominal.get("mu_coulomb", 0.0) * weight * cosine)


def scale_of(robot: Robot, runs: Sequence[Run]) -> Scale:
    """Measure the rig's scale from its model and its runs."""
    nominal = nominal_of(robot)
    rotary = "gravity_torque" in nominal
    mass = nominal["mass"]
    weight = mass * nominal["gravity"]
    cosine = float(np.cos(np.radians(nominal["slope_deg"])))
    level = level_of(nominal)
    doubts = [robot.other.get(f"uncertainty.{key}", 0.0) for key in ("mass", "mu_coulomb")]
    drives = np.concatenate([run.drive for run in runs]) * nominal["gain"]
    peak = float(np.abs(drives).max()) or weight
    force = float(np.quantile(np.abs(drives), 0.98)) or peak
    travel, speed = [], []
    for run in runs:
        x = run.channels["x"]
        ok = np.isfinite(x)
        if ok.sum() < 8:
            continue
        t, x = run.t[ok], x[ok]
        travel.append(float(np.ptp(x)))
        # Slopes over twentieths of a run: insensitive to noise of single samples.
        stride = max(1, x.size // 40)
        slopes = np.abs(np.diff(x[::stride]) / np.diff(t[::stride]))
        speed.append(float(slopes.max(initial=0.0)))
    duration = float(np.median([run.t[-1] - run.t[0] for run in runs]))
    far = float(np.median(travel)) if travel else 1e-3
    fast = float(np.median(speed)) if speed else 1e-3
    return Scale(
        mass=mass,
        nominal_level=level,
        level=max(level, 1e-3 * force),
        least_level=max(level, 1e-3 * force) * max(0.0, 1.0 - _DOUBT * sum(map(float, doubts))),
        force=force,
        peak=peak,
        speed=max(fast, 1e-6),
        travel=max(far, 1e-7),
        duration=duration,
        interval=float(np.median([np.median(np.diff(run.t)) for run in runs])),
        weight=weight,
        grip=max((nominal["segments"] - 1.0) * weight * cosine, 1e-9),
        viscous=nominal["viscous"],
        has_force_level="coulomb_force" in nominal,
        rotary=rotary,
        replayed=duration,
    )
