"""What the report says of runs that are replayed in windows of 0.4 s."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_small import NOISE, ROBOT, driven, measured, problem
from locosweep.diagnosis.estimate.window_plan import Plan
from locosweep.diagnosis.report.windowed import ShotReport, _interval, _sums

MASS = 0.05
LOUD = replace(ROBOT, other={"sensor.position_noise": 1e-4})
"""A sensor beside whose noise errors of the states at windows' starts are small."""


def report_of(runs, robot=ROBOT, **changes):
    """The report of runs in windows, the nominal model, and one with more mass."""
    whole = problem(runs, robot, **changes)
    nominal = whole.plain()
    true = replace(nominal, names=("payload_mass",), values=nominal.values.copy())
    true.values[whole.parameter_index("payload_mass", "dm")] = MASS
    return ShotReport(whole, Plan(0.4, "asked for", whole.noise)), nominal, true


@pytest.fixture(scope="module")
def heavier():
    runs = measured({"payload_mass": {"dm": MASS}}, driven(3, 4.0))
    return report_of(runs, held=(1,))


class TestGap:
    def test_numbers_of_the_runs_kept_from_the_fit(self, heavier):
        report, nominal, true = heavier
        gap = report.gap(nominal, true, 0, [])
        squares = np.concatenate([report.squares(p)["x"][1] for p in (nominal, true)])
        before, after = np.sqrt(np.nanmean(squares.reshape(2, -1), axis=1))
        assert gap["before"] == pytest.approx(before)
        assert gap["after"] == pytest.approx(after)
        assert gap["shrink"] == pytest.approx(1.0 - after / before)
        low, high = gap["shrink_ci"]
        assert low <= gap["shrink"] <= high < 1.0
        assert (gap["held_out"], gap["used_for_fit"]) == (["1"], ["0", "2"])
        assert "over 0.4 s from the measured state, held-out runs" in gap["metric"]

    def test_the_nominal_model_itself_improves_nothing(self, heavier):
        report, nominal, _ = heavier
        gap = report.gap(nominal, nominal, 0, [])
        assert (gap["shrink"], gap["shrink_ci"], gap["explained"]) == (0.0, [0.0, 0.0], 0.0)

    def test_without_a_gap_the_improvement_is_not_known(self):
        runs = measured({}, driven(2, 4.0), noise=1e-4)
        report, nominal, true = report_of(runs, LOUD, held=(1,))
        warnings = []
        gap = report.gap(nominal, replace(true, values=nominal.values), 0, warnings)
        assert gap["shrink"] is None
        assert "show no gap beyond the noise" in warnings[0]

    def test_one_run_is_judged_by_its_last_part(self):
        report, *_ = report_of(measured({}, driven(1, 4.0)), train_fraction=0.7)
        begins = [report.tiles.windows[i].span[1] for i in report.judged]
        assert min(begins) > 0.7 * 400
        assert len(begins) < 0.5 * len(report.tiles.windows)

    def test_the_worst_tenth_of_windows_does_not_decide(self):
        runs = measured({"payload_mass": {"dm": MASS}}, driven(3, 4.0))
        runs[1].channels["x"][200:230] += 0.05
        report, nominal, true = report_of(runs, held=(1,))
        gap = report.gap(nominal, true, 0, [])
        assert report.without_worst(nominal, true, "x") > gap["shrink"] + 0.2


class TestPlaces:
    def test_tables_of_channels_runs_and_windows(self, heavier):
        report, nominal, true = heavier
        places = report.places(nominal, true, "x")
        (channel,) = places["channels"]
        assert (channel["channel"], channel["unit"], channel["share"]) == ("x", "m", 1.0)
        assert channel["after"] < 2.0 * NOISE < channel["before"]
        assert [row["run"] for row in places["runs"]] == ["0", "1", "2"]
        assert places["origin"] == places["windows"]
        assert sum(row["share"] for row in places["regimes"]) == pytest.approx(1.0)

    def test_curves_have_the_samples_of_their_runs(self, heavier):
        report, nominal, true = heavier
        traces = report.traces(nominal, true)
        assert [trace.t.size for trace in traces] == [400] * 3
        assert [trace.held_out for trace in traces] == [False, True, False]
        left = traces[0].measured["x"] - traces[0].augmented["x"]
        assert np.nanmax(np.abs(left)) < 10.0 * NOISE


class TestSaid:
    def test_a_run_that_hardly_moves(self):
        runs = driven(3, 4.0)
        runs[2] = replace(runs[2], drive=0.1 * runs[2].drive)
        report, *_ = report_of(measured({}, runs))
        rows = [{"run": label, "before": 1.0, "after": 1.0} for label in "012"]
        (said,) = report.said_of_runs(rows, "x")
        assert said.startswith("run 2: the head hardly ever moves")

    def test_a_run_that_no_effect_helps(self, heavier):
        report, *_ = heavier
        rows = [{"run": label, "before": 1e-3, "after": 1e-4} for label in "012"]
        assert report.said_of_runs(rows, "x") == []
        rows[1]["after"] = 9.6e-4
        (said,) = report.said_of_runs(rows, "x")
        assert said.startswith("run 1: no effect makes its error smaller than 0.00096 m, 9.6 times")
        # Helped by more than a twentieth, however large it stays.
        rows[1]["after"] = 9.4e-4
        assert report.said_of_runs(rows, "x") == []

    def test_a_window_that_holds_most_of_what_is_left(self):
        runs = measured({}, driven(3, 4.0), noise=1e-4)
        report, nominal, _ = report_of(runs, LOUD)
        assert report.said_of_windows(nominal, "x") == []
        runs[1].channels["x"][203:217] += 0.01
        report, nominal, _ = report_of(runs, LOUD)
        (said,) = report.said_of_windows(nominal, "x")
        assert said.startswith(("run 1, 2 to 2.2 s holds", "run 1, 2.2 to 2.4 s holds"))


def test_sums_leave_out_what_is_missing():
    squares = np.array([[1.0, np.nan, 2.0, 5.0, np.nan]])
    np.testing.assert_array_equal(_sums(squares, np.array([3, 2])), [[[3.0, 2.0], [5.0, 1.0]]])


def test_the_interval_is_that_of_a_mean_over_windows():
    # Squares after are a quarter of 100 windows' own: 1 - sqrt(1/4), with a known spread.
    random = np.random.default_rng(1)
    before = np.ones(100)
    after = 0.25 + 0.05 * random.standard_normal(100)
    low, high = _interval(np.stack([before, after]), 0.5, 3)
    # d(1 - sqrt(s)) = ds / (2 sqrt(s)), and 1.645 deviations of a mean of 100.
    half = 1.645 * after.std() / 10.0 / (2.0 * np.sqrt(after.mean()))
    assert high - low == pytest.approx(2.0 * half, rel=0.2)
    assert low <= 0.5 <= high
