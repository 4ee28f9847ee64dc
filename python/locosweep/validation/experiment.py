"""Runs of a rig through the reality, as vectors that can be compared."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.validation.rigs import Rig, Sensors

    Floats = NDArray[np.float64]
    Effect = tuple[str, str, dict[str, float]]

FINE = 1e-5
"""Step of the measured runs, s."""
COARSE = 5e-4
"""Step where many realities are only compared with one another, s."""

Readings = dict[str, "Floats"]


@dataclass(frozen=True)
class Drive:
    """Command of one run, and how it begins."""

    t: Floats
    command: Floats
    slope_deg: float
    start: tuple[float, float]
    seed: int
    slope_given: bool = False


@dataclass(frozen=True)
class World:
    """One reality: shifts of uncertain nominal values, effects, and a common start speed.

    `shifts` are in standard deviations; an effect has name, form and parameters; `nudge`
    is added to the start velocity of all runs.
    """

    shifts: dict[str, float] = field(default_factory=dict)
    effects: tuple[Effect, ...] = ()
    nudge: float = 0.0


@dataclass(frozen=True)
class Experiment:
    """A rig, its sensors and its drives."""

    rig: Rig
    drives: tuple[Drive, ...]
    sensors: Sensors

    def read(self, worlds: Sequence[World], step: float, threads: int) -> list[list[Readings]]:
        """Run all drives in all worlds: what the sensors would read without noise."""
        runs = [(drive.t, drive.command, drive.slope_deg) for drive in self.drives]
        jobs: list[Any] = []
        for world in worlds:
            true = self.rig.true(world.shifts)
            for i, drive in enumerate(self.drives):
                start = (drive.start[0], drive.start[1] + world.nudge)
                jobs.append((i, true, list(world.effects), start, step, drive.seed))
        found = iter(_core.reality_run(runs, jobs, threads))
        return [[self._channels(*next(found)) for _ in self.drives] for _ in worlds]

    def _channels(self, x: Floats, v: Floats, rear: Floats, force: Floats) -> Readings:
        motor = self.rig.motor
        power = np.zeros_like(x)
        if motor:
            current = force / motor["force_constant"]
            power = motor["resistance"] * current**2 + force * v
        return {"x": x, "v": v, "x_rear": rear, "force": force, "power": power}

    def whitened(self, readings: list[Readings]) -> Floats:
        """All measured channels of all runs in standard deviations, run by run."""
        channels = ("x", *self.sensors.channels)
        parts = [run[c] / self.sensors.deviation(c) for run in readings for c in channels]
        whole: Floats = np.concatenate(parts)
        return whole
