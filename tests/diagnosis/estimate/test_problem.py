"""Residuals of a problem against generalised least squares, and that it does not change."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from diagnosis_small import NOISE, ROBOT, driven, measured, problem
from locosweep.diagnosis.estimate.problem import InitialStates
from locosweep.simulation.replay import replay_runs


def test_a_start_offset_is_marginalised() -> None:
    """Chi2 is that of noise with a common offset of each run, its covariance written out."""
    runs = measured({"viscous_friction": {"c": 0.02}})
    own = problem(runs)
    e = own.residuals([own.plain()])[0]
    read = replay_runs(ROBOT, runs)["x"].to_numpy()
    expected = 0.0
    for r, run in enumerate(runs):
        a, b = own.starts_at[r], own.starts_at[r + 1]
        left = run.channels["x"] - read[a:b]
        covariance = NOISE**2 * np.eye(run.t.size) + own.priors["x"][r] ** 2
        expected += left @ np.linalg.solve(covariance, left)
    assert e @ e == pytest.approx(expected, rel=1e-9)


def test_a_problem_cannot_be_changed() -> None:
    own = problem(measured({}))
    with pytest.raises(FrozenInstanceError):
        own.held = (1,)  # type: ignore[misc]
    kept = replace(own, held=(1,))
    assert (own.fitted, kept.fitted) == ([0, 1, 2], [0, 2])


def test_the_residuals_of_a_run_are_where_it_says() -> None:
    own = problem(measured({"coulomb_error": {"d_mu": 0.02}}, channels=("x", "force")))
    every = own.residuals([own.plain()], [0, 1, 2])[0]
    for r in range(3):
        alone = own.residuals([own.plain()], [r])[0]
        np.testing.assert_array_equal(every[own.of_run(r, [0, 1, 2])], alone)


def test_initial_states_are_those_given() -> None:
    own = problem(measured({}))
    moved = InitialStates(own.starts.position, np.array([0.0, 0.05, 0.0]), (1,))
    read = replace(own, initial=moved).replay([replace(own, initial=moved).plain()])
    assert read["v"][0, own.starts_at[1]] == pytest.approx(0.05)
    assert own.plain().speeds[1] == 0.0


def test_a_robot_that_is_turned_round_has_the_other_slope_error() -> None:
    runs = measured({}, driven(2))
    runs[1] = replace(runs[0], label="1")
    own = problem(runs, reversed_runs=frozenset({1}))
    plain = own.plain()
    values = plain.values.copy()
    values[own.parameter_index("slope_error", "d_alpha_deg")] = 1.0
    point = replace(plain, names=("slope_error",), values=values)
    both = own.replay([point, replace(point, values=-values)])["x"]
    half = own.count // 2
    np.testing.assert_array_equal(both[0, half:], both[1, :half])
    assert not np.array_equal(both[0, half:], both[0, :half])


def test_replays_are_counted() -> None:
    own = problem(measured({}))
    before = own.meter.samples
    own.residuals([own.plain()] * 3, [1])
    assert own.meter.samples - before == 3 * 200
