"""The validation error reduction: its numbers, and an interval that holds fresh runs'."""

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_small import NOISE, ROBOT, driven, measured, problem
from locosweep.diagnosis.report import improvement
from locosweep.diagnosis.report.comparison import compare_whole_runs
from locosweep.diagnosis.report.improvement import (
    draws_of_runs,
    draws_of_windows,
    gap_of,
    interval_of,
)


def world(generator, runs):
    """Mean squares of runs before and after, of one population that the generator draws."""
    floor, fall = generator.normal(-14.0, 1.0), generator.normal(0.5, 0.7)
    after = np.exp(floor + 0.3 * generator.normal(size=runs))
    before = after * np.exp(np.exp(fall + 0.6 * generator.normal(size=runs)))
    return before, after


def interval(before, after, stated):
    """The interval where one run was kept from the fit."""
    return interval_of(draws_of_runs(before, after, 1, np.random.default_rng(1)), stated)


def inside(runs, worlds=400):
    """Share of populations whose next run falls into the interval of the runs before it."""
    generator = np.random.default_rng(7)
    hits = []
    for _ in range(worlds):
        before, after = world(generator, runs + 1)
        errors = [np.full(64, b) for b in before[:-1]], [np.full(64, a) for a in after[:-1]]
        stated = 1.0 - np.sqrt(after[-2] / before[-2])
        low, high = interval(*errors, stated)
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
    low, high = interval([before], [after], 0.5)
    assert 0.4 < low <= 0.5 <= high < 0.6
    assert high - low > 0.001


def test_runs_that_show_nothing_keep_zero_inside():
    generator = np.random.default_rng(5)
    before, after = world(generator, 6)
    before[:2] = after[:2]
    errors = [np.full(64, b) for b in before], [np.full(64, a) for a in after]
    low, _ = interval(*errors, 1.0 - np.sqrt(after[5] / before[5]))
    assert low == 0.0


class TestGap:
    """The report's `gap` of runs whose mass is known to be 20 g off."""

    def gap(self, own):
        return gap_of(compare_whole_runs(own, own.plain(), self.truth(own)), 0)

    def truth(self, own):
        true = replace(own.plain(), names=("payload_mass",), values=own.plain().values.copy())
        true.values[own.parameter_index("payload_mass", "dm")] = 0.02
        return true

    def test_numbers_of_the_runs_kept_from_the_fit(self):
        own = problem(measured({"payload_mass": {"dm": 0.02}}), held=(1,))
        gap = self.gap(own)
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

    def test_runs_that_were_all_fitted_show_no_improvement(self):
        own = problem(measured({"payload_mass": {"dm": 0.02}}))
        gap = self.gap(own)
        assert gap["shrink"] is None
        assert "fitted runs" in gap["metric"]

    def test_a_kept_run_without_a_gap_says_nothing_of_its_fall(self):
        runs = measured({"payload_mass": {"dm": 0.02}})
        still = replace(runs[1], drive=np.zeros(200), channels=measured({}, [
            replace(driven()[1], drive=np.zeros(200))])[0].channels)  # fmt: skip
        own = problem([runs[0], still, runs[2]], held=(1,))
        gap = self.gap(own)
        assert (gap["shrink"], gap["shrink_ci"], gap["explained"]) == (None, None, None)
        assert gap["before"] == pytest.approx(NOISE, rel=0.15)

    def test_one_run_is_judged_by_its_last_part(self):
        runs = measured({"payload_mass": {"dm": 0.02}}, driven(1))
        own = problem(runs, train_fraction=0.7)
        gap = self.gap(own)
        errors = runs[0].channels["x"] - own.replay([own.plain()])["x"][0]
        assert gap["before"] == pytest.approx(np.sqrt(np.mean(errors[140:] ** 2)), rel=0.01)
        assert "last part of the run" in gap["metric"]

    def test_the_channel_that_stands_highest_above_its_noise(self):
        runs = measured({"drive_gain_error": {"e": 0.05}}, channels=("x", "force"))
        quiet = problem(runs, replace(ROBOT, other=ROBOT.other | {"sensor.force_noise": 1e-6}))
        same = quiet.plain()
        assert gap_of(compare_whole_runs(quiet, same, same), 0)["channel"] == "force"
        loud = problem(runs, replace(ROBOT, other=ROBOT.other | {"sensor.force_noise": 1.0}))
        assert gap_of(compare_whole_runs(loud, same, same), 0)["channel"] == "x"


def test_the_interval_of_windows_is_that_of_a_mean_over_them():
    # Squares after are a quarter of 100 windows' own: 1 - sqrt(1/4), with a known spread.
    random = np.random.default_rng(1)
    before = np.ones(100)
    after = 0.25 + 0.05 * random.standard_normal(100)
    drawn = draws_of_windows(np.stack([before, after]), np.random.default_rng(3))
    low, high = interval_of(drawn, 0.5)
    # d(1 - sqrt(s)) = ds / (2 sqrt(s)), and 1.645 deviations of a mean of 100.
    half = 1.645 * after.std() / 10.0 / (2.0 * np.sqrt(after.mean()))
    assert high - low == pytest.approx(2.0 * half, rel=0.2)
    assert low <= 0.5 <= high
