"""When runs are replayed in windows, and which windows cover them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import polars as pl
import pytest

from diagnosis_long import PENDULUM, SLED, drives, measured, whole
from locosweep.diagnosis.estimate.window_plan import (
    FITTED_SAMPLES,
    HELD_SAMPLES,
    WindowPlan,
    adjoining_windows,
    decimated,
    for_planning,
    plan_of,
    problem_of,
)


def test_short_runs_stay_whole():
    frame = measured(SLED, {"payload_mass": {"dm": 0.05}}, drives(SLED))
    assert plan_of(whole(SLED, frame)) is None


def test_a_pendulum_that_hangs_stays_whole():
    runs = [replace(run, drive=0.08 * run.drive) for run in drives(PENDULUM)]
    assert plan_of(whole(PENDULUM, measured(PENDULUM, {}, runs))) is None


def test_a_pendulum_over_the_top_is_cut_by_its_rate():
    plan = plan_of(whole(PENDULUM, measured(PENDULUM, {}, drives(PENDULUM))))
    assert plan is not None
    # Twice the time in which an error grows by e: sqrt(J / torque).
    assert plan.seconds == pytest.approx(2.0 * np.sqrt(0.05), rel=0.01)
    assert "grow" in plan.why


def test_a_long_run_is_cut_where_its_model_loses_it():
    runs = drives(SLED, 1, 40.0, 0.02)
    near = measured(SLED, {}, runs)
    far = measured(SLED, {"direction_dependent_friction":
        {"F_c_forward": 0.7, "F_c_backward": 0.75}}, runs)  # fmt: skip
    assert plan_of(whole(SLED, near)) is None
    plan = plan_of(whole(SLED, far))
    assert plan is not None
    assert plan.seconds < 10.0


def test_many_samples_are_cut_whatever_the_gap():
    frame = measured(SLED, {}, drives(SLED, 2, 8.0, 1.0 / 8000.0))
    problem = whole(SLED, frame)
    plan = plan_of(problem)
    assert plan is not None
    windows, said = problem_of(replace(problem, held=(1,)), plan)
    fitted = sum(int(windows.lengths[r]) for r in windows.fitted)
    assert 0 < fitted <= FITTED_SAMPLES
    assert 0 < windows.count - fitted <= HELD_SAMPLES
    assert "128000 samples" in said
    assert "one sample in" in said


def test_adjoining_windows_follow_each_other():
    problem = whole(SLED, measured(SLED, {}, drives(SLED)))
    windows = adjoining_windows(problem, WindowPlan(0.4, "asked for", problem.noise)).windows
    for before, after in pairwise(windows):
        if before.record == after.record:
            end = before.span[0] + before.counted[1]
            assert end == after.span[0] + after.counted[0]
    assert {window.record for window in windows} == {0, 1, 2}


def test_a_gap_in_the_data_is_in_no_window():
    frame = measured(SLED, {}, drives(SLED, 1))
    frame = frame.filter((pl.col("t") < 3.0) | (pl.col("t") > 3.5))
    problem = whole(SLED, frame)
    windows = adjoining_windows(problem, WindowPlan(0.4, "asked for", problem.noise)).windows
    assert len(windows) > 5
    assert all(np.diff(window.t).max() < 0.4 for window in windows)


def test_thinning_keeps_the_impulse():
    run = drives(SLED, 1, 4.0, 1e-3)[0]
    few = decimated(run, 0.005)
    assert few.t.size == run.t.size / 5
    assert np.sum(few.drive * 5e-3) == pytest.approx(np.sum(run.drive * 1e-3), abs=1e-12)
    assert decimated(run, 0.0015) is run


def test_thinning_keeps_how_far_the_impulse_of_a_gap_may_be_off():
    run = drives(SLED, 1, 4.0, 1e-3)[0]
    bounds = np.where((run.t > 1.0) & (run.t < 1.0995), 0.1, 0.0)
    few = decimated(replace(run, drive_deviation=bounds), 0.005)
    assert few.drive_deviation is not None
    assert np.sum(few.drive_deviation * 5e-3) == pytest.approx(np.sum(bounds * 1e-3))


def test_a_hole_in_the_readings_makes_windows_no_shorter():
    frame = measured(SLED, {"viscous_friction": {"c": 0.15}}, drives(SLED, 1, 30.0))
    hole = pl.when(pl.col("t").is_between(10.0, 16.0)).then(None)
    holed = frame.with_columns(x=hole.otherwise("x"))
    plans = [plan_of(whole(SLED, one)) for one in (frame, holed)]
    assert [plan.seconds for plan in plans if plan] == pytest.approx([0.469] * 2, rel=0.01)


def test_thinning_keeps_the_samples_that_have_a_reading():
    run = drives(SLED, 1, 4.0, 1e-3)[0]
    x = np.where(np.arange(run.t.size) % 5 == 3, 0.1, np.nan)
    few = decimated(replace(run, channels={"x": x}), 0.005)
    assert np.isfinite(few.channels["x"]).all()
    assert few.t[0] == pytest.approx(0.003)


def test_planned_runs_begin_at_rest():
    (run,) = drives(SLED, 1, 40.0, 0.01)
    late = replace(run, drive=np.where(run.t > 12.0, run.drive, 0.0))
    problem = for_planning(whole(SLED, measured(SLED, {}, [late])))
    x = problem.runs[0].channels["x"]
    assert np.abs(x[:50] - x[0]).max() < 1e-3
    assert np.ptp(x) > 0.01
