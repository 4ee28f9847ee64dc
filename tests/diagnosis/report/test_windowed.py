"""What the report says of runs that are replayed in windows of 0.4 s."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_small import NOISE, ROBOT, driven, measured, problem
from locosweep.diagnosis.estimate.window_plan import WindowPlan
from locosweep.diagnosis.report import sentences
from locosweep.diagnosis.report.improvement import gap_of
from locosweep.diagnosis.report.localization import where_of
from locosweep.diagnosis.report.windowed import _sums, report_windows

MASS = 0.05
LOUD = replace(ROBOT, other={"sensor.position_noise": 1e-4})
"""A sensor beside whose noise errors of the states at windows' starts are small."""


def comparison_of(runs, robot=ROBOT, **changes):
    """The nominal model and one with more mass, compared on runs in windows."""
    whole = problem(runs, robot, **changes)
    nominal = whole.plain()
    true = replace(nominal, names=("payload_mass",), values=nominal.values.copy())
    true.values[whole.parameter_index("payload_mass", "dm")] = MASS
    return report_windows(whole, WindowPlan(0.4, "asked for", whole.noise)).compare(nominal, true)


def of_nominal(comparison):
    """The nominal model beside itself."""
    return replace(comparison, after=comparison.before)


@pytest.fixture(scope="module")
def heavier():
    runs = measured({"payload_mass": {"dm": MASS}}, driven(3, 4.0))
    return comparison_of(runs, held=(1,))


class TestGap:
    def test_numbers_of_the_runs_kept_from_the_fit(self, heavier):
        gap = gap_of(heavier, 0)
        squares = np.concatenate([of_model["x"][1] for of_model in heavier.squares])
        before, after = np.sqrt(np.nanmean(squares.reshape(2, -1), axis=1))
        assert gap["before"] == pytest.approx(before)
        assert gap["after"] == pytest.approx(after)
        assert gap["shrink"] == pytest.approx(1.0 - after / before)
        low, high = gap["shrink_ci"]
        assert low <= gap["shrink"] <= high < 1.0
        assert (gap["held_out"], gap["used_for_fit"]) == (["1"], ["0", "2"])
        assert "over 0.4 s from the measured state, held-out runs" in gap["metric"]

    def test_the_nominal_model_itself_improves_nothing(self, heavier):
        gap = gap_of(of_nominal(heavier), 0)
        assert (gap["shrink"], gap["shrink_ci"], gap["explained"]) == (0.0, [0.0, 0.0], 0.0)

    def test_without_a_gap_the_improvement_is_not_known(self):
        runs = measured({}, driven(2, 4.0), noise=1e-4)
        found = comparison_of(runs, LOUD, held=(1,))
        found = replace(found, after=replace(found.after, values=found.before.values))
        assert gap_of(found, 0)["shrink"] is None

    def test_one_run_is_judged_by_its_last_part(self):
        found = comparison_of(measured({}, driven(1, 4.0)), train_fraction=0.7).windows
        begins = [found.problem.windows[i].span[1] for i in found.validation]
        assert min(begins) > 0.7 * 400
        assert len(begins) < 0.5 * len(found.problem.windows)


class TestWhere:
    def test_tables_of_channels_runs_and_windows(self, heavier):
        where = where_of(heavier, "x", explained=True)
        (channel,) = where["channels"]
        assert (channel["channel"], channel["unit"], channel["share"]) == ("x", "m", 1.0)
        assert channel["after"] < 2.0 * NOISE < channel["before"]
        assert [row["run"] for row in where["runs"]] == ["0", "1", "2"]
        assert where["origin"] == where["windows"]
        assert sum(row["share"] for row in where["regimes"]) == pytest.approx(1.0)

    def test_curves_have_the_samples_of_their_runs(self, heavier):
        _, augmented = heavier.readings
        assert [read.size for read in augmented["x"]] == [400] * 3
        left = heavier.problem.runs[0].channels["x"] - augmented["x"][0]
        assert np.nanmax(np.abs(left)) < 10.0 * NOISE


class TestOddWindows:
    def test_a_run_that_hardly_moves(self):
        runs = driven(3, 4.0)
        runs[2] = replace(runs[2], drive=0.1 * runs[2].drive)
        (said,) = sentences.odd_windows(of_nominal(comparison_of(measured({}, runs))), "x", 20)
        assert said.startswith("run 2: the head hardly ever moves")

    def test_a_run_that_no_effect_helps(self, heavier, monkeypatch):
        rows = [{"run": label, "before": 1e-3, "after": 1e-4} for label in "012"]
        monkeypatch.setattr(sentences, "by_run", lambda *_: rows)
        assert sentences.odd_windows(heavier, "x", 20) == []
        rows[1]["after"] = 9.6e-4
        (said,) = sentences.odd_windows(heavier, "x", 20)
        assert said.startswith("run 1: no effect makes its error smaller than 0.00096 m, 9.6 times")
        # Helped by more than a twentieth, however large it stays.
        rows[1]["after"] = 9.4e-4
        assert sentences.odd_windows(heavier, "x", 20) == []

    def test_a_window_that_holds_most_of_what_is_left(self):
        runs = measured({}, driven(3, 4.0), noise=1e-4)
        assert sentences.odd_windows(of_nominal(comparison_of(runs, LOUD)), "x", 20) == []
        runs[1].channels["x"][203:217] += 0.01
        said = sentences.odd_windows(of_nominal(comparison_of(runs, LOUD)), "x", 20)[-1]
        assert said.startswith(("run 1, 2 to 2.2 s holds", "run 1, 2.2 to 2.4 s holds"))


def test_sums_leave_out_what_is_missing():
    squares = np.array([[1.0, np.nan, 2.0, 5.0, np.nan]])
    np.testing.assert_array_equal(_sums(squares, np.array([3, 2])), [[[3.0, 2.0], [5.0, 1.0]]])
