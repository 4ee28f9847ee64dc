"""Readings that are early or late, and noise and motion that only look alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep.diagnosis.data.noise import noise_of, noise_warnings
from locosweep.diagnosis.data.readings.find import check_readings
from locosweep.diagnosis.data.stamp_jitter import stamp_jitter
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import nominal_of

T = np.arange(600) * 0.01
STEP = 0.0015


def swing(t: np.ndarray, k: int) -> np.ndarray:
    """Return the angle of an arm that swings ever faster, and rests for the last second."""
    x: np.ndarray = np.sin(2.0 * np.pi * (0.1 + 0.03 * k) * np.minimum(t, 5.0) ** 2)
    return x


def runs(late: float, sd: float = 0.0) -> list[Run]:
    rng = np.random.default_rng(3)
    found = []
    for k in range(4):
        x = swing(T + rng.normal(0.0, late, T.size) * (T < 5.0), k) + rng.normal(0.0, sd, T.size)
        found.append(Run(str(k), T, np.cos(T), {"x": STEP * np.round(x / STEP)}))
    return found


@pytest.mark.parametrize("late", [1e-3, 3e-3])
def test_readings_that_are_early_or_late_tell_by_how_much(late: float) -> None:
    assert stamp_jitter("x", runs(late)) == pytest.approx(late, rel=0.2)


@pytest.mark.parametrize("sd", [0.0, 1e-3, 1e-2])
def test_noise_of_all_readings_is_no_such_thing(sd: float) -> None:
    assert stamp_jitter("x", runs(0.0, sd)) == 0.0


def test_motion_that_bends_is_none_either() -> None:
    steps = [replace(run, channels={"x": np.sin(3.0 * T + k) + 0.1 * np.abs(np.sin(25.0 * T))})
             for k, run in enumerate(runs(0.0))]  # fmt: skip
    assert stamp_jitter("x", steps) == 0.0
    assert stamp_jitter("x", [replace(runs(3e-3)[0], t=T[:60], channels={"x": T[:60]})]) == 0.0


ROTARY = Robot(
    {"mass": 0.05, "gravity": 9.81, "segments": 1.0},
    {"bench.kind": "rotary", "bench.gravity_torque": 1.4, "surface.coulomb_force": 0.05,
     "sensor.position_noise": 1e-3},
)  # fmt: skip


def test_fast_readings_are_neither_slips_nor_spikes_and_rest_is_no_frozen_encoder() -> None:
    checked = check_readings(runs(4e-3), nominal_of(ROTARY), {"position_noise": 1e-3})
    # Without them, the same readings had 13 findings, slips of half a run among them.
    assert [f for f in checked.findings if f.kind != "dropout"] == []


def test_fast_readings_count_for_less() -> None:
    late = runs(3e-3)
    noise = noise_of("x", late, {"position_noise": 1e-3})
    assert noise.late == pytest.approx(3e-3, rel=0.2)
    assert noise.sd < 1.2e-3
    weights = Problem(ROTARY, late, 1, known={"x": noise}).weights["x"][: T.size]
    speed = np.abs(np.gradient(swing(T, 0), T))
    fast, slow = weights[speed > 2.0], weights[(speed < 0.05) & (T < 5.0)]
    assert fast.max() < 0.3 / noise.sd < slow.min()
    said = noise_warnings(late, {"position_noise": 1e-3})
    assert any("grows with the speed" in one for one in said)
