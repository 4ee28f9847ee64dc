"""The validation error reduction: its numbers, and an interval that holds fresh runs'."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from diagnosis_small import NOISE, ROBOT, driven, measured, problem
from locosweep.diagnosis.report import improvement
from locosweep.diagnosis.report.improvement import _interval, gap_of, units_of
from locosweep.files.robot import Robot


def world(generator, runs):
    """Mean squares of runs before and after, of one population that the generator draws."""
    floor, fall = generator.normal(-14.0, 1.0), generator.normal(0.5, 0.7)
    after = np.exp(floor + 0.3 * generator.normal(size=runs))
    before = after * np.exp(np.exp(fall + 0.6 * generator.normal(size=runs)))
    return before, after


def inside(runs, worlds=400):
    """Share of populations whose next run falls into the interval of the runs before it."""
    generator = np.random.default_rng(7)
    hits = []
    for _ in range(worlds):
        before, after = world(generator, runs + 1)
        errors = [np.full(64, b) for b in before[:-1]], [np.full(64, a) for a in after[:-1]]
        problem = SimpleNamespace(runs=[None] * runs, held=[runs - 1])
        stated = 1.0 - np.sqrt(after[-2] / before[-2])
        low, high = _interval(problem, errors, stated, seed=1)
        assert low <= stated <= high <= 1.0
        hits.append(low <= 1.0 - np.sqrt(after[-1] / before[-1]) <= high)
    return np.mean(hits)


@pytest.mark.parametrize("runs", [4, 6, 8])
def test_the_interval_holds_the_next_run_in_nine_of_ten_cases(runs):
    assert 0.86 <= inside(runs) <= 0.95


def test_runs_as_they_are_hold_it_less_often(monkeypatch):
    monkeypatch.setattr(improvement, "_like", lambda runs, *_: runs[:1])
    assert inside(4) < 0.75


def test_one_run_is_cut_into_blocks():
    generator = np.random.default_rng(3)
    before, after = generator.random(400) + 1.0, 0.25 * (generator.random(400) + 1.0)
    problem = SimpleNamespace(runs=[None], held=[])
    low, high = _interval(problem, ([before], [after]), 0.5, seed=1)
    assert 0.4 < low <= 0.5 <= high < 0.6
    assert high - low > 0.001


def test_runs_that_show_nothing_keep_zero_inside():
    generator = np.random.default_rng(5)
    before, after = world(generator, 6)
    before[:2] = after[:2]
    errors = [np.full(64, b) for b in before], [np.full(64, a) for a in after]
    problem = SimpleNamespace(runs=[None] * 6, held=[5])
    low, _ = _interval(problem, errors, 1.0 - np.sqrt(after[5] / before[5]), seed=1)
    assert low == 0.0


class TestGap:
    """The report's `gap` of runs whose mass is known to be 20 g off."""

    def truth(self, own):
        true = replace(own.plain(), names=("payload_mass",), values=own.plain().values.copy())
        true.values[own.parameter_index("payload_mass", "dm")] = 0.02
        return true

    def test_numbers_of_the_runs_kept_from_the_fit(self):
        own = problem(measured({"payload_mass": {"dm": 0.02}}), held=(1,))
        gap, tables = gap_of(own, own.plain(), self.truth(own), 0, [])
        x = own.runs[1].channels["x"]
        read = own.replay([own.plain(), self.truth(own)], [1])["x"]
        expected = np.sqrt(np.mean((x - read) ** 2, axis=1))
        assert (gap["channel"], gap["unit"]) == ("x", "m")
        # Up to the start's offset, which is of the size of the noise.
        assert gap["before"] == pytest.approx(expected[0], rel=0.01)
        assert gap["after"] == pytest.approx(NOISE, rel=0.15)
        assert gap["noise_floor"] == NOISE
        assert gap["shrink"] == pytest.approx(1.0 - gap["after"] / gap["before"])
        floor = gap["noise_floor"] ** 2
        left = (gap["after"] ** 2 - floor) / (gap["before"] ** 2 - floor)
        assert gap["explained"] == pytest.approx(1.0 - left)
        assert (gap["held_out"], gap["used_for_fit"]) == (["1"], ["0", "2"])
        assert [row["run"] for row in tables["runs"]] == ["0", "1", "2"]
        assert tables["runs"][1]["before"] == gap["before"]
        assert [row["share"] for row in tables["channels"]] == [1.0]

    def test_runs_that_were_all_fitted_show_no_improvement(self):
        own = problem(measured({"payload_mass": {"dm": 0.02}}))
        gap, _ = gap_of(own, own.plain(), self.truth(own), 0, [])
        assert gap["shrink"] is None
        assert "fitted runs" in gap["metric"]

    def test_a_kept_run_without_a_gap_is_said(self):
        runs = measured({"payload_mass": {"dm": 0.02}})
        still = replace(runs[1], drive=np.zeros(200), channels=measured({}, [
            replace(driven()[1], drive=np.zeros(200))])[0].channels)  # fmt: skip
        own = problem([runs[0], still, runs[2]], held=(1,))
        warnings = []
        gap, _ = gap_of(own, own.plain(), self.truth(own), 0, warnings)
        assert gap["shrink"] is None
        assert "no gap beyond the noise" in warnings[0]

    def test_one_run_is_judged_by_its_last_part(self):
        runs = measured({"payload_mass": {"dm": 0.02}}, driven(1))
        own = problem(runs, train_fraction=0.7)
        gap, _ = gap_of(own, own.plain(), self.truth(own), 0, [])
        errors = runs[0].channels["x"] - own.replay([own.plain()])["x"][0]
        assert gap["before"] == pytest.approx(np.sqrt(np.mean(errors[140:] ** 2)), rel=0.01)
        assert "last part of the run" in gap["metric"]

    def test_the_channel_that_stands_highest_above_its_noise(self):
        runs = measured({"drive_gain_error": {"e": 0.05}}, channels=("x", "force"))
        quiet = problem(runs, replace(ROBOT, other=ROBOT.other | {"sensor.force_noise": 1e-6}))
        same = quiet.plain()
        assert gap_of(quiet, same, same, 0, [])[0]["channel"] == "force"
        loud = problem(runs, replace(ROBOT, other=ROBOT.other | {"sensor.force_noise": 1.0}))
        assert gap_of(loud, same, same, 0, [])[0]["channel"] == "x"


def test_units_of_a_rotary_bench():
    assert units_of(problem(measured({})))["x"] == "m"
    bench = Robot({"mass": 0.05, "gravity": 9.81, "segments": 1.0},
                  {"surface.coulomb_force": 0.05, "bench.kind": "rotary",
                   "bench.gravity_torque": 1.0, "sensor.position_noise": 1e-3})  # fmt: skip
    units = units_of(
        problem([replace(run, channels={"x": 0.0 * run.t}) for run in driven()], bench)
    )
    assert (units["x"], units["v"], units["force"]) == ("rad", "rad/s", "N m")
