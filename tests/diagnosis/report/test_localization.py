"""Shares of a gap by window, kind of motion and variable, on gaps of known place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_small import ROBOT, driven, measured, problem
from locosweep.diagnosis.data.regimes import REGIMES
from locosweep.diagnosis.report import localization as where
from locosweep.diagnosis.report.comparison import compare_whole_runs


def test_shares() -> None:
    assert where.shares({"a": 3.0, "b": 1.0}) == {"a": 0.75, "b": 0.25}
    assert where.shares({"a": 0.0}) == {"a": 0.0}


class TestWindows:
    def test_the_largest_come_first_with_their_times(self) -> None:
        own = problem(measured({}))
        squares = [np.zeros(run.t.size) for run in own.runs]
        # Runs of 200 samples in steps of 10 ms are cut into 20 windows of 0.1 s.
        squares[1][50:60] = 3.0
        squares[2][190:] = 1.0
        first, second = where.windows(own, squares)
        assert (first["run"], second["run"]) == ("1", "2")
        assert (first["t0"], first["t1"]) == pytest.approx((0.5, 0.6))
        assert (second["t0"], second["t1"]) == pytest.approx((1.9, 1.99))
        assert (first["share"], second["share"]) == pytest.approx((0.75, 0.25))

    def test_ten_at_most_and_none_without_a_gap(self) -> None:
        own = problem(measured({}))
        ones = [np.ones(run.t.size) for run in own.runs]
        rows = where.windows(own, ones)
        assert len(rows) == 10
        assert sum(row["share"] for row in rows) == pytest.approx(10 / 60)
        assert where.windows(own, [0.0 * s for s in ones]) == []


def test_tables_of_channels_and_runs() -> None:
    own = problem(measured({"payload_mass": {"dm": 0.02}}), held=(1,))
    comparison = compare_whole_runs(own, own.plain(), own.plain())
    found = where.where_of(comparison, "x", explained=False)
    (channel,) = found["channels"]
    assert (channel["channel"], channel["unit"], channel["share"]) == ("x", "m", 1.0)
    assert [row["run"] for row in found["runs"]] == ["0", "1", "2"]
    assert found["runs"][1]["before"] == comparison.validation_rms["x"][0]
    assert set(found) == {"channels", "runs", "windows", "origin", "regimes"}


def test_the_error_of_a_run_without_readings_is_not_known() -> None:
    assert where.rms([np.array([np.nan]), np.array([])]) is None
    assert where.rms([np.array([np.nan, 4.0]), np.array([16.0])]) == pytest.approx(np.sqrt(10.0))


def test_kinds_of_motion_share_the_squares() -> None:
    kinds = np.array([REGIMES.index("at_rest"), REGIMES.index("reversal")] * 2)
    rows = where.regime_shares([np.array([1.0, 2.0, 0.0, 5.0])], [kinds])
    assert rows == [
        {"regime": "reversal", "share": 7.0 / 8.0},
        {"regime": "at_rest", "share": 1.0 / 8.0},
    ]


def test_a_gap_arises_where_its_cause_acts() -> None:
    """A drive that fails for 0.2 s moves the whole rest of the run, but arises there."""
    runs = driven(seconds=4.0)
    pushed = [replace(run, drive=np.where((run.t >= 2.0) & (run.t < 2.2), 0.0, run.drive))
              for run in runs]  # fmt: skip
    read = measured({}, pushed)
    own = problem([replace(r, drive=run.drive) for r, run in zip(read, runs, strict=True)])
    rows = where.origin(own, own.plain())
    near = sum(row["share"] for row in rows if row["t0"] >= 1.7 and row["t1"] <= 2.7)
    assert near > 0.8


class TestHorizons:
    def test_short_free_runs_err_less(self) -> None:
        own = problem(measured({"payload_mass": {"dm": 0.02}}))
        true = replace(own.plain(), names=("payload_mass",), values=own.plain().values.copy())
        true.values[own.parameter_index("payload_mass", "dm")] = 0.02
        rows = where.horizons(own, own.plain(), true, [0, 1, 2], (0.2, 1.0, 5.0))
        # Runs last 2 s: nothing is known of 5.
        assert [row["seconds"] for row in rows] == [0.2, 1.0]
        assert rows[0]["before"] < rows[1]["before"]
        assert rows[1]["after"] < 0.2 * rows[1]["before"]


class TestForceView:
    def test_missing_viscosity_is_a_line_over_the_speed(self) -> None:
        runs = measured({"viscous_friction": {"c": 0.3}}, driven(3, 4.0, 0.002))
        own = problem(runs)
        view = where.force_view(own, own.plain(), 0.25)
        assert set(view) == {"v", "x", "t", "drive", "distance"}
        speed, force, half = view["v"]
        slope = np.polyfit(speed, force, 1)[0]
        assert slope == pytest.approx(-0.3, rel=0.15)
        assert (half > 0.0).all()

    def test_too_short_runs_have_none(self) -> None:
        own = problem(measured({}, driven(2, 0.2)))
        assert where.force_view(own, own.plain(), ROBOT.parameters["mass"]) == {}
