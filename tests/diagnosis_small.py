"""A rig and runs of a few hundred samples, for unit tests of one module."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.problem import Problem
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

NOISE = 1e-5
ROBOT = Robot(
    {"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {"sensor.position_noise": NOISE, "sensor.force_noise": 0.01},
)


def driven(count: int = 3, seconds: float = 2.0, step: float = 0.01) -> list[Run]:
    """Runs of sines that push both ways, without readings."""
    t = np.arange(0.0, seconds, step)
    return [
        Run(str(k), t, np.where(t < 0.1, 0.0, (1.0 + 0.1 * k) * np.sin((5.0 + k) * (t - 0.1))))
        for k in range(count)
    ]


def measured(
    effects: dict[str, dict[str, float]],
    runs: Sequence[Run] | None = None,
    channels: Sequence[str] = ("x",),
    *,
    robot: Robot = ROBOT,
    noise: float = NOISE,
) -> list[Run]:
    """Return the runs as read where reality has `effects`; noise is on the positions."""
    runs = driven() if runs is None else runs
    read = replay_runs(replace(robot, effects=effects), runs)
    random = np.random.default_rng(5)
    found, at = [], 0
    for run in runs:
        own = {c: read[c].to_numpy()[at : at + run.t.size].copy() for c in channels}
        at += run.t.size
        for c in own:
            own[c] += (noise if c.startswith("x") else 0.0) * random.standard_normal(run.t.size)
        found.append(replace(run, channels=own))
    return found


STIFFNESS = 0.002
"""Of the spring in `tethered`, N/m."""


def tethered(count: int = 4, stiffness: float = STIFFNESS, rounds: int = 4) -> list[Run]:
    """Return runs that a spring pulls back to their start, told without it."""
    return pulled(lambda x: -stiffness * x, count, rounds)


def uneven(count: int = 4, force: float = 5e-4, length: float = 0.05) -> list[Run]:
    """Return runs on a track that is steeper than stated, here more and there less."""
    return pulled(lambda x: force * (1.0 + 0.3 * np.sin(2.0 * np.pi * x / length)), count)


def pulled(by_place: Callable[[Floats], Floats], count: int = 4, rounds: int = 4) -> list[Run]:
    """Return runs under a force by place, told without it."""
    runs, real = driven(count), driven(count)
    for _ in range(rounds):
        # The force of the way that the head goes, found by a few rounds.
        there = measured({}, real, noise=0.0)
        real = [
            replace(told, drive=told.drive + by_place(run.channels["x"]))
            for told, run in zip(runs, there, strict=True)
        ]
    read = measured({}, real)
    return [replace(run, drive=told.drive) for run, told in zip(read, runs, strict=True)]


def problem(runs: Sequence[Run], robot: Robot = ROBOT, **changes: object) -> Problem:
    """Return the runs against the robot's model."""
    return Problem(robot, list(runs), 1, **changes)  # type: ignore[arg-type]
