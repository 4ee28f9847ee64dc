"""Runs in some forty steps each: motion and drive, with single readings averaged out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

_STEPS = 40
"""Steps that a run is looked at in: medians over each, so that bad readings do not matter."""
_FEWEST = 6
"""Steps from which on a run says something."""


@dataclass(frozen=True)
class Coarse:
    """Motion of a run in steps, and the mean drive force over each of them."""

    t: Floats
    x: Floats
    force: Floats
    """Drive and weight, in N or N m; one fewer than positions."""

    @property
    def span(self) -> float:
        """Range of the positions."""
        return float(np.ptp(self.x))

    @property
    def accelerations(self) -> Floats:
        """Changes of the mean speed from step to step, over their time."""
        speed = np.diff(self.x) / np.diff(self.t)
        found: Floats = np.diff(speed) / (0.5 * (self.t[2:] - self.t[:-2]))
        return found

    @property
    def work(self) -> tuple[float, float]:
        """Work of drive and weight on the head, and the sum of its parts without their signs."""
        parts = self.force * np.diff(self.x)
        return float(parts.sum()), float(np.abs(parts).sum())


def coarse(run: Run, x: Floats, nominal: Mapping[str, float]) -> Coarse | None:
    """Look at a run, with `x` as its positions, in steps; None where too little is known."""
    known = np.flatnonzero(np.isfinite(x))
    width = max(1, known.size // _STEPS)
    count = known.size // width
    if count < _FEWEST:
        return None
    t = run.since_start
    steps = known[: count * width].reshape(count, width)
    middle, position = t[steps].mean(axis=1), np.median(x[steps], axis=1)
    impulse = np.concatenate([[0.0], np.cumsum(run.drive[:-1] * np.diff(t))]) * nominal["gain"]
    force = np.diff(np.interp(middle, t, impulse)) / np.diff(middle)
    slope = np.radians(nominal["slope_deg"] if run.slope_deg is None else run.slope_deg)
    if "gravity_torque" in nominal:
        force = force - nominal["gravity_torque"] * np.sin(0.5 * (position[1:] + position[:-1]))
    else:
        force = force - nominal["mass"] * nominal["gravity"] * np.sin(slope)
    return Coarse(middle, position, force)
