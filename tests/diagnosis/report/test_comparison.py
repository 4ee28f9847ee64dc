"""Two models on whole runs: their errors, and the squares of the gap between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_small import NOISE, driven, measured, problem
from locosweep.diagnosis.report.comparison import compare_whole_runs, started
from locosweep.files.robot import Robot

HEAVIER = {"payload_mass": {"dm": 0.02}}


def heavier(own):
    """The nominal model with the mass that the runs had."""
    true = replace(own.plain(), names=("payload_mass",), values=own.plain().values.copy())
    true.values[own.parameter_index("payload_mass", "dm")] = 0.02
    return true


def test_squares_of_the_true_model_are_those_of_the_noise():
    own = problem(measured(HEAVIER), held=(1,))
    comparison = compare_whole_runs(own, own.plain(), heavier(own))
    before, after = comparison.squares
    assert [s.size for s in after["x"]] == [200] * 3
    assert np.sqrt(np.mean(np.concatenate(after["x"]))) == pytest.approx(NOISE, rel=0.15)
    assert np.mean(before["x"][1]) > 100.0 * NOISE**2
    kept = comparison.validation_rms["x"]
    assert kept == pytest.approx([np.sqrt(s["x"][1].mean()) for s in comparison.squares])


def test_a_part_of_the_runs_is_kept_or_none():
    runs = measured({})
    for changes, validates in (
        ({}, False),
        ({"held": (1,)}, True),
        ({"train_fraction": 0.7}, True),
    ):
        own = problem(runs, **changes)
        assert compare_whole_runs(own, own.plain(), own.plain()).validates is validates


class TestGapSquares:
    def test_an_explanation_is_what_it_changes(self):
        own = problem(measured(HEAVIER))
        comparison = compare_whole_runs(own, own.plain(), heavier(own))
        old, new = (own.replay([point])["x"][0] for point in (own.plain(), heavier(own)))
        squares = np.concatenate(comparison.gap_squares("x", explained=True))
        np.testing.assert_array_equal(squares, (new - old) ** 2)

    def test_without_one_noise_is_smoothed_away(self):
        runs = measured({})
        runs[1].channels["x"][120:140] += 20.0 * NOISE
        own = problem(runs)
        comparison = compare_whole_runs(own, own.plain(), own.plain())
        squares = comparison.gap_squares("x", explained=False)
        total = sum(s.sum() for s in squares)
        assert squares[1][118:142].sum() > 0.9 * total
        assert squares[1][125:135].mean() == pytest.approx((20.0 * NOISE) ** 2, rel=0.2)


def test_both_models_start_where_the_second_one_says():
    own = problem(measured({}), held=(1,))
    moved = replace(heavier(own), speeds=np.array([0.1, 0.2, 0.3]))
    comparison = compare_whole_runs(own, own.plain(), moved)
    np.testing.assert_array_equal(comparison.before.speeds, moved.speeds)
    # Where no run begins in motion there is nothing to fit.
    assert started(own, moved).speeds.tolist() == moved.speeds.tolist()


def test_units_of_a_rotary_bench():
    own = problem(measured({}))
    assert compare_whole_runs(own, own.plain(), own.plain()).unit("x") == "m"
    bench = Robot({"mass": 0.05, "gravity": 9.81, "segments": 1.0},
                  {"surface.coulomb_force": 0.05, "bench.kind": "rotary",
                   "bench.gravity_torque": 1.0, "sensor.position_noise": 1e-3})  # fmt: skip
    own = problem([replace(run, channels={"x": 0.0 * run.t}) for run in driven()], bench)
    comparison = compare_whole_runs(own, own.plain(), own.plain())
    assert [comparison.unit(c) for c in ("x", "v", "force")] == ["rad", "rad/s", "N m"]
