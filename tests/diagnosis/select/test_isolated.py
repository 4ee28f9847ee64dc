"""Single readings that only a fit shows to be bad."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep.diagnosis.estimate.least_squares import Model, Nuisances, evaluate, start_fits
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.select.isolated import isolated_readings
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs

NOISE = 2e-5
ROBOT = Robot(
    {"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {"sensor.position_noise": NOISE},
)
T = np.arange(300) * 0.01


def measured(**effects: dict[str, float]) -> list[Run]:
    runs = []
    for k in range(2):
        drive = np.where(T > 0.1, (1.0 + 0.2 * k) * np.sin(6.0 * T), 0.0)
        runs.append(Run(str(k), T, drive, {"x": np.zeros(T.size)}))
    x = replay_runs(replace(ROBOT, effects=effects), runs)["x"].to_numpy().reshape(2, -1)
    x = x + np.random.default_rng(3).normal(0.0, NOISE, x.shape)
    return [replace(run, channels={"x": own}) for run, own in zip(runs, x, strict=True)]


def found(runs: list[Run]) -> tuple[list[tuple[str, float, str]], list[int]]:
    problem = Problem(ROBOT, runs, 1)
    (fit,) = evaluate(problem, start_fits(Nuisances(), Model((), ()), np.zeros((1, 0))))
    flags, findings = isolated_readings(problem, fit)
    assert all(one.masked and one.samples == 1 and one.t0 == one.t1 for one in findings)
    return [(one.run, one.t0, one.kind) for one in findings], np.flatnonzero(flags[1]).tolist()


def with_x(at: int, value: float) -> list[Run]:
    runs = measured()
    x = runs[1].channels["x"].copy()
    x[at] = value
    return [runs[0], replace(runs[1], channels={"x": x})]


def test_noise_has_none() -> None:
    assert found(measured()) == ([], [])


def test_a_small_spike() -> None:
    x = measured()[1].channels["x"][150]
    assert found(with_x(150, x + 11.0 * NOISE)) == ([("1", T[150], "spike")], [150])
    assert found(with_x(150, x + 5.0 * NOISE)) == ([], [])


def test_a_few_in_a_row() -> None:
    runs = measured()
    x = runs[1].channels["x"].copy()
    x[150:153] += np.array([11.0, -9.0, 10.0]) * NOISE
    assert found([runs[0], replace(runs[1], channels={"x": x})])[1] == [150, 151, 152]


def test_a_repeat_of_the_reading_before() -> None:
    # A change of 6 deviations from one reading to the next: too small for a spike.
    x = measured()[1].channels["x"]
    at = int(np.argmin(np.abs(np.abs(np.diff(x)) - 6.0 * NOISE))) + 1
    assert found(with_x(at, x[at - 1])) == ([("1", T[at], "dropout")], [at])


@pytest.mark.parametrize(
    "effects",
    [{"coulomb_error": {"d_mu": 0.1}}, {"drive_delay": {"T": 0.05}},
     {"transmission_backlash": {"b": 0.005, "m_d": 0.05}}],
)  # fmt: skip
def test_what_a_model_lacks_is_none(effects: dict[str, dict[str, float]]) -> None:
    assert found(measured(**effects)) == ([], [])


def test_many_at_once_are_no_single_ones() -> None:
    runs = measured()
    x = runs[1].channels["x"].copy()
    x[5::8] += 12.0 * NOISE
    assert found([runs[0], replace(runs[1], channels={"x": x})]) == ([], [])


def test_where_far_more_is_left_than_single_readings_hold_they_are_none() -> None:
    """Readings off their neighbours are found in vain where the model errs everywhere."""
    runs = [
        replace(run, channels={"x": run.channels["x"] + 40.0 * NOISE * T}) for run in measured()
    ]
    x = runs[1].channels["x"].copy()
    x[150] += 15.0 * NOISE
    assert found([runs[0], replace(runs[1], channels={"x": x})]) == ([], [])
    x[150] += 3000.0 * NOISE
    assert [kind for _, _, kind in found([runs[0], replace(runs[1], channels={"x": x})])[0]] == [
        "spike"
    ]
