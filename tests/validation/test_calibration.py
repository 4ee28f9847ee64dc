"""Calibration of a raw model to a rig: the values that made the runs come back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs
from locosweep.validation.calibration import calibrate
from locosweep.validation.planting import Rig
from locosweep.validation.rig_problem import see

T = np.arange(0.0, 15.0, 0.02)


def robot(coulomb: float, viscous: float, mass: float) -> Robot:
    """A linear bench."""
    return Robot(
        {"mass": mass, "segments": 1.0, "viscous": viscous, "gain": 1.0},
        {
            "surface.coulomb_force": coulomb, "bench.kind": "linear",
            "sensor.position_noise": 1e-4, "uncertainty.mass": 0.1,
        },
    )  # fmt: skip


TRUE = robot(1.0, 0.5, 0.8)


@pytest.fixture(scope="module")
def runs() -> list[Run]:
    """Long runs that turn at other places each time."""
    drives = [4.0 * np.sin(2.0 * T + phase) + 1.5 * np.sin(5.3 * T) for phase in (0.0, 2.0)]
    rest = [Run(str(i), T, drive, {"x": np.zeros(T.size)}) for i, drive in enumerate(drives)]
    read = replay_runs(TRUE, rest)["x"].to_numpy().reshape(len(rest), -1)
    noise = np.random.default_rng(5).normal(0.0, 1e-4, read.shape)
    return [replace(r, channels={"x": x}) for r, x in zip(rest, read + noise, strict=True)]


def test_windows_grow_with_the_model(runs: list[Run]) -> None:
    """A raw model that errs much is fitted in short windows first, then over whole runs."""
    raw = robot(2.4, 0.1, 0.8)
    assert see(Rig(raw, tuple(runs))).plan is not None
    model, found = calibrate(runs, raw)
    assert see(Rig(model, tuple(runs))).plan is None
    assert found["mass"] / found["gain"] == pytest.approx(0.8, rel=2e-3)
    assert found["coulomb_force"] / found["gain"] == pytest.approx(1.0, rel=2e-3)
    assert found["viscous"] / found["gain"] == pytest.approx(0.5, rel=2e-3)
    # Before and after are errors over the same stretches.
    assert found["rms_x_after"] < 2e-4
    assert found["rms_x_before"] > 100.0 * found["rms_x_after"]
    assert "uncertainty.mass" not in model.other


def test_friction_that_the_rig_lacks_ends_at_zero(runs: list[Run]) -> None:
    """Where less than none would fit better still, as under a sensor that reads too much."""
    slippery = robot(0.0, 0.5, 0.8)
    read = replay_runs(slippery, runs)["x"].to_numpy().reshape(len(runs), -1)
    slid = [replace(r, channels={"x": 1.01 * x}) for r, x in zip(runs, read, strict=True)]
    raw = robot(1e-5, 0.5, 0.8)
    model, found = calibrate(slid, raw)
    assert model.other["surface.coulomb_force"] == found["coulomb_force"]
    assert 0.0 <= found["coulomb_force"] < 1e-5


def test_commands_beyond_the_limit_of_the_drive_are_calibrated_too(runs: list[Run]) -> None:
    """A log may hold what was asked for: only planting into it minds the limit."""
    strongest = max(float(np.abs(run.drive).max()) for run in runs)
    raw = robot(1.2, 0.4, 0.8)
    limited = replace(raw, parameters={**raw.parameters, "drive_limit": 0.999 * strongest})
    _, found = calibrate(runs, limited)
    assert found["coulomb_force"] / found["gain"] == pytest.approx(1.0, rel=0.01)
