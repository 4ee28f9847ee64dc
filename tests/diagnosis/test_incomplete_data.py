"""What a diagnosis does with readings that are missing, and with uncertain nominal values."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl
import pytest

from locosweep.diagnosis import diagnose
from locosweep.errors import DataFileError
from locosweep.files.robot import Robot, load_robot
from locosweep.files.runs import Run, runs_from_frame
from locosweep.simulation.replay import motor_of, replay_runs

pytestmark = pytest.mark.whole

NOISE = 1e-5
ROBOT = Robot(
    {"mass": 0.2, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {"sensor.position_noise": NOISE},
)
EFFECT = {"coulomb_error": {"d_mu": 0.015}}


def switched(count: int, seconds: float, rate: float) -> list[Run]:
    """Runs of a drive that changes its sign, without readings."""
    t = np.arange(0.0, seconds, 1.0 / rate)
    runs = []
    for k in range(count):
        drive = np.where(np.sin(2.0 * np.pi * (0.7 + 0.2 * k) * t + 0.3 * k) > 0.0, 1.2, -1.1)
        drive[:5] = 0.0
        runs.append(Run(str(k), t, drive, {"x": np.zeros(t.size)}))
    return runs


def measured(runs: list[Run], effects: dict[str, Any], robot: Robot = ROBOT) -> pl.DataFrame:
    frame = replay_runs(replace(robot, effects=effects), runs)
    noise = np.random.default_rng(3).normal(0.0, NOISE, frame.height)
    drive = pl.Series("drive", np.concatenate([run.drive for run in runs]))
    return frame.select("run", "t", pl.col("x") + pl.Series(noise)).with_columns(drive)


def without(frame: pl.DataFrame, run: str, first: int, last: int | None) -> pl.DataFrame:
    """The same with some readings of a run missing."""
    number = pl.int_range(pl.len()).over("run")
    gone = (pl.col("run") == run) & (number >= first)
    if last is not None:
        gone &= number < last
    return frame.with_columns(x=pl.when(gone).then(None).otherwise(pl.col("x")))


@pytest.mark.filterwarnings("error")
class TestMissing:
    @pytest.mark.parametrize("share", [0.03, 0.1])
    def test_rows_that_were_left_out_change_no_verdict(self, share: float):
        # Drives that are smooth and that switch, whose switches lie in gaps too.
        runs = switched(4, 4.0, 100.0)
        for k in (0, 2):
            wave = np.round(1.2 * np.sin((4.0 + k) * runs[k].t), 3)
            runs[k] = replace(runs[k], drive=np.where(runs[k].t < 0.05, 0.0, wave))
        robot = replace(ROBOT, other={"sensor.position_noise": 10.0 * NOISE})
        noise = np.random.default_rng(6).normal(0.0, 10.0 * NOISE, 4 * runs[0].t.size)
        frame = measured(runs, {"coulomb_error": {"d_mu": 0.05}})
        frame = frame.with_columns(x=pl.col("x") + pl.Series(noise))
        kept = np.random.default_rng(8).random(frame.height) >= share
        found = diagnose(frame.filter(pl.Series(kept)), robot, threads=1)
        assert "coulomb_error" in found.report["verdict"]["equivalent"][0]
        assert found.report["gap"]["shrink"] > 0.9
        assert any("rows are missing" in w for w in found.report["warnings"])

    def test_a_run_without_a_position_is_left_out_and_said(self):
        frame = without(measured(switched(4, 4.0, 100.0), EFFECT), "1", 0, None)
        found = diagnose(frame, ROBOT, threads=1)
        assert any(w.startswith("run 1: x has 0 values") for w in found.report["warnings"])
        assert found.status == "explained"
        assert found.report["verdict"]["effects"] == ["coulomb_error"]
        rows = found.report["where"]["runs"]
        assert [row["run"] for row in rows] == ["0", "2", "3"]

    def test_a_body_that_one_run_does_not_measure_is_no_obstacle(self):
        frame = measured(switched(4, 2.0, 100.0), EFFECT)
        still = np.random.default_rng(4).normal(0.0, NOISE, frame.height)
        seen = pl.when(pl.col("run") != "2").then(pl.Series(still))
        found = diagnose(frame.with_columns(x_rear=seen), ROBOT, threads=1)
        assert found.report["verdict"]["effects"] == ["coulomb_error"]

    def test_no_position_at_all_is_one_clear_line(self):
        frame = measured(switched(2, 2.0, 100.0), {})
        for label in "01":
            frame = without(frame, label, 0, None)
        with pytest.raises(DataFileError, match="column x has fewer than 20 values"):
            diagnose(frame, ROBOT, threads=1)

    def test_a_start_that_was_not_measured_may_lie_anywhere(self):
        frame = without(measured(switched(4, 4.0, 100.0), EFFECT), "0", 0, 200)
        found = diagnose(frame, ROBOT, threads=1)
        assert found.report["verdict"]["effects"] == ["coulomb_error"]
        value = found.report["candidates"][0]["parameters"]["coulomb_error"]["d_mu"]["value"]
        assert value == pytest.approx(0.015, rel=1e-3)

    def test_no_window_begins_where_nothing_was_measured(self):
        frame = measured(switched(2, 30.0, 50.0), EFFECT)
        for label in "01":
            frame = without(frame, label, 200, 1300)
        found = diagnose(frame, ROBOT, threads=1)
        assert found.report["verdict"]["effects"] == ["coulomb_error"]

    def test_a_long_run_with_hardly_a_reading_is_told_so(self):
        frame = measured(switched(2, 30.0, 50.0), EFFECT)
        number = pl.int_range(pl.len()).over("run")
        frame = frame.with_columns(x=pl.when(number % 60 == 0).then(pl.col("x")))
        found = diagnose(frame, ROBOT, threads=1)
        assert found.effects == ["coulomb_error"]
        assert sum("98% of x is missing" in warning for warning in found.warnings) == 2

    def test_a_single_run_without_readings_in_its_last_part(self):
        frame = without(measured(switched(1, 6.0, 100.0), {}), "0", 400, None)
        pushed = frame.with_columns(drive=pl.col("drive") + 0.05 * (3.0 * pl.col("t")).sin())
        for one in (frame, pushed):
            found = diagnose(one, ROBOT, threads=1)
            assert found.status in ("none", "partial", "unexplained"), found

    def test_a_run_to_be_kept_that_has_no_readings_is_told(self):
        frame = without(measured(switched(4, 4.0, 100.0), EFFECT), "2", 0, None)
        found = diagnose(frame, ROBOT, holdout=["2", "3"], threads=1)
        assert found.gap["held_out"] == ["3"]
        assert any("run 2 was to be kept from the fit" in warning for warning in found.warnings)


def test_runs_too_short_for_windows_are_diagnosed() -> None:
    found = diagnose(measured(switched(2, 0.2, 100.0), {}), ROBOT, threads=1)
    assert found.status == "none"


class TestUncertain:
    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("effects", "name"),
        [
            ({"viscous_friction": {"c": 0.4}}, "viscous_friction"),
            (
                {"direction_dependent_friction": {"F_c_forward": 0.52, "F_c_backward": 0.66}},
                "direction_dependent_friction",
            ),
        ],
    )
    def test_the_augmented_file_replays_to_the_curves_of_the_report(self, tmp_path, effects, name):
        uncertain = {"uncertainty.mass": 0.02, "uncertainty.gain": 0.02, "uncertainty.clock": 0.002}
        nominal = Robot(ROBOT.parameters, {**ROBOT.other, **uncertain})
        true = Robot({**ROBOT.parameters, "mass": 0.203}, dict(ROBOT.other))
        frame = measured(switched(5, 3.0, 100.0), effects, true)
        found = diagnose(frame, nominal, threads=1)
        assert name in {n for c in found.report["verdict"]["equivalent"] for n in c}
        found.save(tmp_path / "out")
        model = load_robot(tmp_path / "out" / "augmented.toml")
        read = replay_runs(model, runs_from_frame(frame))["x"].to_numpy()
        shown = np.concatenate([trace.augmented["x"] for trace in found.traces])
        np.testing.assert_allclose(read, shown, rtol=0.0, atol=1e-9)


def test_small_gaps_are_located_in_spite_of_the_noise() -> None:
    # Friction changes halfway: no sample of the gap stands out of the noise.
    runs = switched(4, 4.0, 200.0)
    frame = measured(runs, {"lubricant_buildup": {"k_b": 0.004}})
    found = diagnose(frame, ROBOT, threads=1)
    assert found.status in ("explained", "ambiguous")
    base, real = (
        replay_runs(replace(ROBOT, effects=e), runs)["x"].to_numpy()
        for e in ({}, {"lubricant_buildup": {"k_b": 0.004}})
    )
    squares = (real - base) ** 2
    labels, t = frame["run"].to_numpy(), frame["t"].to_numpy()
    inside = np.zeros(t.size, dtype=bool)
    for window in found.report["where"]["windows"]:
        inside |= (labels == window["run"]) & (t >= window["t0"]) & (t <= window["t1"])
    most = np.sort(squares)[::-1][: int(inside.sum())].sum()
    assert squares[inside].sum() > 0.8 * most


@pytest.mark.slow
def test_a_lag_far_shorter_than_a_sample_is_found_beside_a_weak_drive() -> None:
    quiet = Robot(dict(ROBOT.parameters), {"sensor.position_noise": 1e-6})
    true = {"drive_lag": {"T": 2e-4}, "drive_gain_error": {"e": -2e-3}}
    runs = switched(4, 4.0, 100.0)
    frame = replay_runs(replace(quiet, effects=true), runs)
    noise = np.random.default_rng(5).normal(0.0, 1e-6, frame.height)
    drive = pl.Series("drive", np.concatenate([run.drive for run in runs]))
    frame = frame.select("run", "t", pl.col("x") + pl.Series(noise)).with_columns(drive)
    found = diagnose(frame, quiet, threads=1)
    classes = found.report["verdict"]["equivalent"]
    assert len(classes) == 2
    assert {"drive_lag", "drive_gain_error"} <= {name for names in classes for name in names}


@pytest.mark.slow
def test_a_push_that_no_drive_knows_of_is_no_other_law_of_anything() -> None:
    runs = switched(4, 4.0, 100.0)
    pushed = [replace(r, drive=r.drive + 0.1 * np.sin(15.0 * r.t + k)) for k, r in enumerate(runs)]
    frame = measured(pushed, {})
    drive = pl.Series("drive", np.concatenate([run.drive for run in runs]))
    found = diagnose(frame.with_columns(drive), ROBOT, threads=1)
    assert found.status == "unexplained"


MOTOR = {"supply_voltage": 6.0, "winding_resistance": 20.0, "force_constant": 1.7}


def pushed(effects: dict[str, Any]) -> pl.DataFrame:
    """Runs of a drive that only pushes, with the electric power of its motor."""
    t = np.arange(0.0, 3.0, 0.01)
    runs = []
    for k in range(4):
        drive = np.where(np.sin(2.0 * np.pi * (0.6 + 0.2 * k) * t) > 0.2, 0.9 + 0.1 * k, 0.0)
        runs.append(Run(str(k), t, drive, {"x": np.zeros(t.size)}))
    read = replay_runs(replace(ROBOT, effects=effects), runs)
    current = pl.col("force") / MOTOR["force_constant"]
    power = MOTOR["winding_resistance"] * current**2 + pl.col("force") * pl.col("v")
    noise = np.random.default_rng(5).normal(0.0, 1.0, (2, read.height))
    return read.select(
        "run",
        "t",
        x=pl.col("x") + pl.Series(NOISE * noise[0]),
        power=power + pl.Series(0.02 * noise[1]),
        drive=pl.Series(np.concatenate([run.drive for run in runs])),
    )


class TestPower:
    def robot(self, motor: dict[str, float]) -> Robot:
        return replace(
            ROBOT,
            parameters=ROBOT.parameters | motor,
            other=ROBOT.other | {"sensor.power_noise": 0.02},
        )

    def test_power_tells_apart_what_the_position_cannot(self):
        frame = pushed({"drive_gain_error": {"e": -0.06}})
        blind = diagnose(frame.drop("power"), self.robot(MOTOR), threads=1)
        seen = diagnose(frame, self.robot(MOTOR), threads=1)
        # A head that is only pushed forward loses as much to friction that follows the drive.
        assert "load_dependent_friction" in blind.report["verdict"]["equivalent"][0]
        assert seen.status == "explained"
        assert seen.report["verdict"]["effects"] == ["drive_gain_error"]
        assert {"x", "power"} <= {row["channel"] for row in seen.report["where"]["channels"]}

    def test_the_model_of_the_plant_leaves_no_power(self):
        found = diagnose(pushed({}), self.robot(MOTOR), threads=1)
        assert found.status == "none"

    def test_a_file_gives_the_motor(self, tmp_path):
        file = tmp_path / "nominal.toml"
        file.write_text(
            "[robot]\nsegments = 4\nmass = 0.2\n[surface]\nmu_coulomb = 0.3\n"
            "[motor]\nsupply_voltage = 24.0\nresistance = 20.0\nforce_constant = 1.7\n"
        )
        assert motor_of(load_robot(file)) == (20.0, 1.7)

    def test_without_a_motor_the_column_is_left_out_and_said(self):
        found = diagnose(pushed({}), self.robot({}), threads=1)
        assert any(w.startswith("power is measured but") for w in found.report["warnings"])
        assert found.status == "none"


def test_a_head_that_slides_to_rest_before_the_first_push_is_no_gap():
    t = np.arange(0.0, 3.0, 0.01)
    runs = []
    for k, speed in enumerate((0.0, 0.08, -0.05, 0.12)):
        drive = np.where((t > 0.3) & (np.sin(2.0 * np.pi * (0.6 + 0.2 * k) * t) > 0.0), 1.1, 0.0)
        runs.append(Run(str(k), t, drive, {"x": np.zeros(t.size), "v": np.full(t.size, speed)}))
    found = diagnose(measured(runs, {}), ROBOT, threads=1)
    assert found.status == "none"
    assert measured(runs, {}).filter(pl.col("run") == "1")["x"].max() > 50 * NOISE


@pytest.mark.slow
def test_a_slow_start_under_a_drive_that_is_on_is_no_gap() -> None:
    # Cut from longer runs in mid-motion: too slow for a parabola through the first samples.
    t = np.arange(0.0, 4.0, 1.0 / 250.0)
    long = [
        Run(str(k), t, (0.64 + 0.01 * k) * np.sin(2.0 * np.pi * 0.5 * t), {"x": 0.0 * t})
        for k in range(4)
    ]
    frame = measured(long, {})
    speeds = replay_runs(ROBOT, long)["v"].to_numpy().reshape(4, -1)
    cuts = [int(np.flatnonzero((v[:-1] < 0.0015) & (v[1:] >= 0.0015))[0]) for v in speeds]
    number = pl.int_range(pl.len()).over("run")
    first = pl.col("run").replace_strict({str(k): cut for k, cut in enumerate(cuts)})
    found = diagnose(frame.filter(number >= first), ROBOT, threads=1)
    assert found.status == "none"
