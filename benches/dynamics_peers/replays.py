"""The works of a diagnosis: measured runs replayed through candidate models.

The rig is a head on a slope, driven by commands that are held between samples; friction is
Coulomb's with true sticking and viscous. It is that of ``dynamics.rs``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from dynamics_peers.work import (
    BRISTLES,
    GRAVITY,
    LUGRE,
    PULSES,
    REPLAY,
    ROBOT,
    SEGMENT_MASS,
    STRIBECK,
    LuGre,
    Points,
    Pulses,
    Robot,
    Stribeck,
    product,
)
from peers.work import Array

RUNS, SAMPLES, INTERVAL = 6, 2000, 2e-3
SLOPE_DEG = 3.0
MU, VISCOUS, GAIN, LIMIT = 0.15, 0.05, 1.1, 0.85
NOMINAL = {
    "segments": 4.0,
    "mass": SEGMENT_MASS,
    "gravity": GRAVITY,
    "mu_coulomb": MU,
    "viscous": VISCOUS,
    "slope_deg": SLOPE_DEG,
    "gain": GAIN,
    "limit": LIMIT,
}
COULOMB = MU * SEGMENT_MASS * GRAVITY * np.cos(np.radians(SLOPE_DEG))
WEIGHT = SEGMENT_MASS * GRAVITY * np.sin(np.radians(SLOPE_DEG))


def times() -> Array:
    """Return the instants of the samples, the same in every run."""
    return np.arange(SAMPLES) * INTERVAL


def drives() -> Array:
    """Return the commands, one row a run: two sines, rounded as a command is."""
    run, t = np.arange(RUNS)[:, None], times()
    slow = np.sin(2 * np.pi * (0.5 + 0.1 * run) * t)
    fast = np.sin(2 * np.pi * 2.3 * t + 0.4 * run)
    return np.ascontiguousarray(np.round((0.55 * slow + 0.4 * fast) * 50) / 50)


@dataclass(frozen=True)
class Replays(Points):
    """A viscous coefficient beside the nominal one, and a gain that is off."""

    run: Array
    viscous: Array
    gain_error: Array

    @classmethod
    def draw(cls, count: int) -> Self:
        """Return candidates: some for each run."""
        each = np.arange(max(2, round(count / RUNS)))
        run, i = product(np.arange(float(RUNS)), each.astype(float))
        return cls(run, 0.3 + 0.05 * i, -0.15 + 0.01 * i)

    def force(self) -> Array:
        """Return the drive force after each sample, one row a candidate."""
        told = drives()[self.run.astype(np.intp)]
        limited: Array = np.clip(GAIN * (1 + self.gain_error)[:, None] * told, -LIMIT, LIMIT)
        return limited


@dataclass(frozen=True)
class Bristles(Points):
    """Bristles in place of true sticking."""

    run: Array
    stiffness: Array
    damping: Array

    @classmethod
    def draw(cls, count: int) -> Self:
        """Return candidates: some for each run."""
        each = np.arange(max(2, round(count / RUNS)))
        run, i = product(np.arange(float(RUNS)), each.astype(float))
        return cls(run, 2e4 * (1 + 0.02 * i), 30.0 * (1 + 0.02 * i))

    def force(self) -> Array:
        """Return the drive force after each sample, one row a candidate."""
        told = drives()[self.run.astype(np.intp)]
        limited: Array = np.clip(GAIN * told, -LIMIT, LIMIT)
        return limited


Kind = type[Stribeck] | type[LuGre] | type[Pulses] | type[Robot] | type[Replays] | type[Bristles]
KINDS: dict[str, Kind] = {
    STRIBECK: Stribeck,
    LUGRE: LuGre,
    PULSES: Pulses,
    ROBOT: Robot,
    REPLAY: Replays,
    BRISTLES: Bristles,
}
