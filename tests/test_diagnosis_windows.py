"""The diagnosis of long runs and of plants that fall over: in windows."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from locosweep.diagnosis import Diagnosis, diagnose
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.estimate.shooting import WindowProblem
from locosweep.diagnosis.estimate.window_plan import (
    FITTED_SAMPLES,
    HELD_SAMPLES,
    Plan,
    adjoining_windows,
    decimated,
    plan_of,
    problem_of,
)
from locosweep.files.robot import Robot
from locosweep.files.runs import Run, runs_from_frame
from locosweep.simulation.replay import replay_runs

SLED = Robot(
    {"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {"sensor.position_noise": 5e-5},
)
PENDULUM = Robot(
    {"mass": 0.05, "gravity": 9.81, "segments": 1.0},
    {
        "sensor.position_noise": 1e-3,
        "surface.coulomb_force": 0.05,
        "bench.kind": "rotary",
        "bench.gravity_torque": 1.0,
    },
)
SECONDS = {id(SLED): 0.4, id(PENDULUM): 0.45}
DATA = Path(os.environ.get("LOCOSWEEP_DATA", "")) / "realdata" / "dfki_pendulum"
needs_data = pytest.mark.skipif(
    not (os.environ.get("LOCOSWEEP_DATA") and DATA.is_dir()),
    reason="LOCOSWEEP_DATA does not name a folder with measured runs of a pendulum",
)


def drives(robot: Robot, count: int = 3, seconds: float = 8.0, step: float = 0.005) -> list[Run]:
    """Runs of two sines; those of the pendulum take it over the top."""
    runs = []
    for k in range(count):
        t = np.arange(0.0, seconds, step)
        slow, fast = (0.9, 0.25) if robot is PENDULUM else (1.0, 0.35)
        drive = (slow + 0.15 * k) * np.sin(2.0 * np.pi * (0.55 + 0.1 * k) * t)
        drive += fast * np.sin(2.0 * np.pi * 1.7 * t + k)
        runs.append(Run(str(k), t, drive, {"x": np.zeros(t.size)}))
    return runs


def measured(
    robot: Robot, effects: dict[str, dict[str, float]], runs: list[Run], seed: int = 1
) -> pl.DataFrame:
    """What the sensors read where reality has `effects`."""
    frame = replay_runs(replace(robot, effects=effects), runs)
    noise = np.random.default_rng(seed).normal(
        0.0, float(robot.other["sensor.position_noise"]), len(frame)
    )
    drive = np.concatenate([run.drive for run in runs])
    return frame.select("run", "t").with_columns(
        drive=pl.Series(drive), x=pl.Series(frame["x"].to_numpy() + noise)
    )


def whole(robot: Robot, frame: pl.DataFrame, **changes: object) -> Problem:
    return Problem(robot, runs_from_frame(frame), 1, **changes)  # type: ignore[arg-type]


def in_windows(problem: Problem) -> WindowProblem:
    plan = Plan(SECONDS[id(problem.robot)], "asked for", problem.noise)
    return problem_of(problem, plan)[0]


class TestWhen:
    def test_short_runs_stay_whole(self):
        frame = measured(SLED, {"payload_mass": {"dm": 0.05}}, drives(SLED))
        assert plan_of(whole(SLED, frame)) is None

    def test_a_pendulum_that_hangs_stays_whole(self):
        runs = [replace(run, drive=0.08 * run.drive) for run in drives(PENDULUM)]
        assert plan_of(whole(PENDULUM, measured(PENDULUM, {}, runs))) is None

    def test_a_pendulum_over_the_top_is_cut_by_its_rate(self):
        plan = plan_of(whole(PENDULUM, measured(PENDULUM, {}, drives(PENDULUM))))
        assert plan is not None
        # Twice the time in which an error grows by e: sqrt(J / torque).
        assert plan.seconds == pytest.approx(2.0 * np.sqrt(0.05), rel=0.01)
        assert "grow" in plan.why

    def test_a_long_run_is_cut_where_its_model_loses_it(self):
        runs = drives(SLED, 1, 40.0, 0.02)
        near = measured(SLED, {}, runs)
        far = measured(SLED, {"direction_dependent_friction":
            {"F_c_forward": 0.7, "F_c_backward": 0.75}}, runs)  # fmt: skip
        assert plan_of(whole(SLED, near)) is None
        plan = plan_of(whole(SLED, far))
        assert plan is not None
        assert plan.seconds < 10.0

    def test_many_samples_are_cut_whatever_the_gap(self):
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


class TestWindows:
    @pytest.mark.parametrize("robot", [SLED, PENDULUM], ids=["sled", "pendulum"])
    @pytest.mark.parametrize(
        ("name", "values"),
        [
            ("viscous_friction", {"c": 0.05}),
            ("sensor_scale", {"e": 0.03}),
            ("sensor_drift", {"b": 0.01}),
            ("sensor_delay", {"T": 0.01}),
            ("drive_delay", {"T": 0.02}),
            ("friction_drift", {"a": 0.3, "T": 5.0}),
        ],
    )
    def test_the_truth_leaves_noise(self, robot, name, values):
        windows = in_windows(whole(robot, measured(robot, {name: values}, drives(robot))))
        plain = windows.plain()
        true = replace(plain, names=(name,), values=plain.values.copy())
        for key, value in values.items():
            true.values[windows.parameter_index(name, key)] = value
        nominal, left = (windows.residuals([plain, true]) ** 2).sum(axis=1) / windows.degrees()
        assert nominal > 2.0
        assert 0.9 < left < 1.25

    def test_tiles_follow_each_other(self):
        problem = whole(SLED, measured(SLED, {}, drives(SLED)))
        windows = adjoining_windows(problem, Plan(0.4, "asked for", problem.noise)).windows
        for before, after in pairwise(windows):
            if before.record == after.record:
                end = before.span[0] + before.counted[1]
                assert end == after.span[0] + after.counted[0]
        assert {window.record for window in windows} == {0, 1, 2}

    def test_a_gap_in_the_data_is_in_no_window(self):
        frame = measured(SLED, {}, drives(SLED, 1))
        frame = frame.filter((pl.col("t") < 3.0) | (pl.col("t") > 3.5))
        problem = whole(SLED, frame)
        windows = adjoining_windows(problem, Plan(0.4, "asked for", problem.noise)).windows
        assert len(windows) > 5
        assert all(np.diff(window.t).max() < 0.4 for window in windows)

    def test_thinning_keeps_the_impulse(self):
        run = drives(SLED, 1, 4.0, 1e-3)[0]
        few = decimated(run, 0.005)
        assert few.t.size == run.t.size / 5
        assert np.sum(few.drive * 5e-3) == pytest.approx(np.sum(run.drive * 1e-3), abs=1e-12)
        assert decimated(run, 0.0015) is run


@pytest.fixture(scope="module")
def fallen() -> Diagnosis:
    """A pendulum with more mass than its model, over the top."""
    return diagnose(
        measured(PENDULUM, {"payload_mass": {"dm": 0.004}}, drives(PENDULUM)), PENDULUM, threads=1
    )


class TestVerdict:
    def test_the_cause_is_found(self, fallen):
        assert (fallen.status, fallen.equivalent) == ("explained", [["payload_mass"]])
        found = fallen.candidates[0]["parameters"]["payload_mass"]["dm"]
        assert found["value"] == pytest.approx(0.004, rel=0.02)
        assert fallen.gap["shrink"] > 0.9
        assert "over 0.447 s from the measured state" in fallen.gap["metric"]

    def test_the_report_speaks_of_the_runs(self, fallen):
        labels = {"0", "1", "2"}
        assert {row["run"] for row in fallen.where["runs"]} == labels
        assert set(fallen.gap["held_out"]) | set(fallen.gap["used_for_fit"]) == labels
        for row in fallen.where["windows"]:
            assert row["run"] in labels
            assert 0.0 <= row["t0"] < row["t1"] <= 8.0
        assert [trace.t.size for trace in fallen.traces] == [1600] * 3
        assert any("windows of 0.447 s" in text for text in fallen.warnings)
        json.dumps(fallen.report, allow_nan=False)

    def test_the_curves_start_anew(self, fallen):
        trace = fallen.traces[0]
        known = np.isfinite(trace.augmented["x"])
        assert known.mean() > 0.95
        assert np.abs(trace.augmented["x"] - trace.measured["x"])[known].max() < 0.1

    @pytest.mark.slow
    def test_what_it_writes(self, fallen, tmp_path):
        fallen.save(tmp_path / "report")
        assert (tmp_path / "report" / "report.html").stat().st_size > 10_000


@pytest.mark.slow
@needs_data
def test_a_real_pendulum() -> None:
    """Its remainder is beyond the noise: nothing is named, but the report says what is near."""
    frame = pl.read_csv(DATA / "runs.csv").filter(pl.col("run").is_in([5, 6, 7]))
    found = diagnose(frame, DATA / "nominal.toml", holdout=["6", "7"], max_effects=2, threads=1)
    assert (found.status, found.effects) == ("unexplained", [])
    near = found.report["verdict"]["nearest"]
    sets = [frozenset(names) for names in [near["effects"], *near["as_near"]]]
    # A heavier body and a weaker torque do the same to these runs.
    assert any("payload_mass" in names for names in sets)
    assert any("drive_gain_error" in names for names in sets)
    assert not any("viscous_friction" in names for names in sets)
    # Run 7 is the authors' own excitation, far rougher than the fitted run 5.
    assert near["shrink_without_worst"] > 0.1
    runs = {row["run"]: row["after"] / row["before"] for row in near["runs"]}
    assert runs["5"] < 0.4
    assert runs["6"] < 0.7
    assert any("windows of 0.443 s" in text for text in found.warnings)
    shown = {frozenset(c["effects"]): c for c in found.candidates}
    assert all(names in shown for names in sets)
    shrinks = [shown[names]["shrink"] for names in sets]
    assert all(s is not None and np.isfinite(s) for s in shrinks)
