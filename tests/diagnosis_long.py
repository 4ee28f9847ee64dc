"""Long runs of a sled, and a pendulum that falls over: what is replayed in windows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl

from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.estimate.shooting import WindowProblem
from locosweep.diagnosis.estimate.window_plan import WindowPlan, problem_of
from locosweep.files.robot import Robot
from locosweep.files.runs import Run, runs_from_frame
from locosweep.simulation.replay import replay_runs

SLED = Robot(
    {"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {"sensor.position_noise": 5e-5},
)
PENDULUM = Robot(
    {"mass": 0.05, "gravity": 9.81, "segments": 1.0},
    {
        "sensor.position_noise": 1e-3,
        "surface.coulomb_force": 0.05,
        "bench.kind": "rotary",
        "bench.gravity_torque": 1.0,
    },
)
SECONDS = {id(SLED): 0.4, id(PENDULUM): 0.45}


def drives(robot: Robot, count: int = 3, seconds: float = 8.0, step: float = 0.005) -> list[Run]:
    """Runs of two sines; those of the pendulum take it over the top."""
    runs = []
    for k in range(count):
        t = np.arange(0.0, seconds, step)
        slow, fast = (0.9, 0.25) if robot is PENDULUM else (1.0, 0.35)
        drive = (slow + 0.15 * k) * np.sin(2.0 * np.pi * (0.55 + 0.1 * k) * t)
        drive += fast * np.sin(2.0 * np.pi * 1.7 * t + k)
        runs.append(Run(str(k), t, drive, {"x": np.zeros(t.size)}))
    return runs


def measured(
    robot: Robot, effects: dict[str, dict[str, float]], runs: list[Run], seed: int = 1
) -> pl.DataFrame:
    """What the sensors read where reality has `effects`."""
    frame = replay_runs(replace(robot, effects=effects), runs)
    noise = np.random.default_rng(seed).normal(
        0.0, float(robot.other["sensor.position_noise"]), len(frame)
    )
    drive = np.concatenate([run.drive for run in runs])
    return frame.select("run", "t").with_columns(
        drive=pl.Series(drive), x=pl.Series(frame["x"].to_numpy() + noise)
    )


def whole(robot: Robot, frame: pl.DataFrame, **changes: object) -> Problem:
    return Problem(robot, runs_from_frame(frame), 1, **changes)  # type: ignore[arg-type]


def in_windows(problem: Problem) -> WindowProblem:
    plan = WindowPlan(SECONDS[id(problem.robot)], "asked for", problem.noise)
    return problem_of(problem, plan)[0]
