"""Columns in wrong units, with wrong signs, swapped or dead, and effects that are none of these."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from locosweep.diagnosis.data.readings.columns import check_columns
from locosweep.errors import DataFileError
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs

ROBOT = Robot(
    {"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0, "viscous": 0.05},
    {"sensor.position_noise": 2e-5},
)
PENDULUM = Robot(
    {"mass": 0.15, "gravity": 9.81, "segments": 1.0},
    {"sensor.position_noise": 1e-3, "surface.coulomb_force": 0.1, "bench.kind": "rotary",
     "bench.gravity_torque": 3.0},
)  # fmt: skip
T = np.linspace(0.0, 2.5, 301)


def measured(robot: Robot = ROBOT, size: float = 1.0, **effects: dict[str, float]) -> list[Run]:
    runs = []
    for k in range(4):
        drive = size * (1.0 + 0.12 * k) * np.sin(2.0 * np.pi * (0.7 + 0.3 * k) * (T - 0.1))
        runs.append(Run(str(k), T, np.where(T < 0.1, 0.0, drive), {"x": np.zeros(T.size)}))
    read = replay_runs(replace(robot, effects=effects), runs)
    noise = np.random.default_rng(1).normal(0.0, 1.0, (2, 4, T.size))
    x, force = (read[name].to_numpy().reshape(4, -1) for name in ("x", "force"))
    x, force = x + float(robot.other["sensor.position_noise"]) * noise[0], force + 0.01 * noise[1]
    return [
        replace(run, channels={"x": a, "force": b})
        for run, a, b in zip(runs, x, force, strict=True)
    ]


RUNS = measured()


def each(change: Callable[[Run], Run], runs: list[Run] = RUNS) -> list[Run]:
    return [change(run) for run in runs]


def x_times(factor: float) -> Callable[[Run], Run]:
    return lambda run: replace(run, channels={"x": factor * run.channels["x"]})


def drive_times(factor: float) -> Callable[[Run], Run]:
    return lambda run: replace(run, drive=factor * run.drive)


def found(runs: list[Run], robot: Robot = ROBOT) -> tuple[str, str, str]:
    """Column, kind and what it likely is, the same in all runs."""
    columns = check_columns(runs, robot)
    assert columns.hopeless
    assert [one.run for one in columns.findings] == [run.label for run in runs]
    assert all((one.t0, one.t1) == (0.0, 2.5) for one in columns.findings)
    ((column, kind, likely),) = {(one.column, one.kind, one.likely) for one in columns.findings}
    return column, kind, likely


def test_columns_in_their_places() -> None:
    for robot, runs in ((ROBOT, RUNS), (PENDULUM, measured(PENDULUM))):
        columns = check_columns(runs, robot)
        assert columns.findings == ()
        assert list(columns.runs) == runs


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "mm"), (1e2, "cm"), (1 / 0.0254, "inch")])
def test_a_position_in_another_unit(factor: float, unit: str) -> None:
    assert found(each(x_times(factor))) == ("x", "unit", unit)
    assert f"--unit x={unit}" in check_columns(each(x_times(factor)), ROBOT).findings[0].note


@pytest.mark.parametrize("factor", [1e2, 60.0, 45.0, 1 / 0.0254])
def test_of_an_inch_and_a_centimetre_both_are_named(factor: float) -> None:
    """A head that travels less than the nominal one, in cm, travels as far as one in inches."""
    note = check_columns(each(x_times(factor)), ROBOT).findings[0].note
    assert "--unit x=cm" in note
    assert "--unit x=inch" in note
    assert " or " in note


def test_an_angle_in_degrees() -> None:
    runs = each(x_times(180.0 / np.pi), measured(PENDULUM))
    assert found(runs, PENDULUM) == ("x", "unit", "deg")


@pytest.mark.parametrize(("factor", "unit"), [(1e2, "percent"), (1e3, "mN")])
def test_a_drive_in_another_unit(factor: float, unit: str) -> None:
    assert found(each(drive_times(factor))) == ("drive", "unit", unit)


def test_a_drive_that_could_not_move_anything() -> None:
    assert found(each(drive_times(1e-3))) == ("drive", "unit", "")


def test_signs() -> None:
    assert found(each(x_times(-1.0))) == ("x", "sign", "")
    assert found(each(drive_times(-1.0))) == ("x", "sign", "")
    assert found(each(x_times(-1.0), measured(PENDULUM)), PENDULUM) == ("x", "sign", "")


def test_one_run_that_was_turned_is_left_out() -> None:
    columns = check_columns([*RUNS[:2], x_times(-1.0)(RUNS[2]), RUNS[3]], ROBOT)
    assert [run.label for run in columns.runs] == ["0", "1", "3"]
    ((run, kind, masked),) = [(one.run, one.kind, one.masked) for one in columns.findings]
    assert (run, kind, masked, columns.hopeless) == ("2", "sign", True, False)


def test_swapped_columns() -> None:
    def with_drive(run: Run) -> Run:
        return replace(run, drive=run.channels["x"], channels={"x": run.drive})

    def with_force(run: Run) -> Run:
        return replace(run, channels={"x": run.channels["force"], "force": run.channels["x"]})

    def with_rear(run: Run) -> Run:
        rest = np.random.default_rng(3).normal(0.0, 2e-5, T.size)
        return replace(run, channels={"x": rest, "x_rear": run.channels["x"]})

    assert found(each(with_drive)) == ("x", "swapped", "drive")
    assert found(each(with_force)) == ("x", "swapped", "force")
    assert found(each(with_rear)) == ("x", "swapped", "x_rear")


def test_a_dead_encoder() -> None:
    for rest in (np.zeros(T.size), np.random.default_rng(3).normal(0.0, 2e-5, T.size)):
        assert found(each(lambda run, x=rest: replace(run, channels={"x": x}))) == (
            "x", "frozen", "",
        )  # fmt: skip
    # A drive that would move nothing says nothing about the encoder.
    weak = measured(size=0.2)
    assert check_columns(weak, ROBOT).findings == ()


@pytest.mark.parametrize(
    "effects",
    [
        {"coulomb_error": {"d_mu": -0.15}},
        {"coulomb_error": {"d_mu": 0.15}},
        {"drive_gain_error": {"e": -0.3}},
        {"drive_delay": {"T": 0.15}},
        {"sensor_delay": {"T": 0.15}},
        {"drive_lag": {"T": 0.2}},
        {"sensor_scale": {"e": 0.5}},
        {"payload_mass": {"dm": -0.12}},
        {"slope_error": {"d_alpha_deg": 8.0}},
    ],
)
def test_strong_effects_are_none_of_these(effects: dict[str, dict[str, float]]) -> None:
    assert check_columns(measured(**effects), ROBOT).findings == ()


def test_a_head_that_drag_holds_is_no_drive_in_another_unit() -> None:
    """A strong drive against drag accelerates nothing, in no unit of it either."""
    servo = replace(PENDULUM, parameters={**PENDULUM.parameters, "viscous": 1.0})
    hard = measured(servo, size=90.0, quadratic_drag={"c2": 40.0})
    assert check_columns(hard, servo).findings == ()


def test_a_reading_of_noise_alone_is_no_unit() -> None:
    noise = np.random.default_rng(4).normal(0.0, 1.0, T.size)
    columns = check_columns(each(lambda run: replace(run, channels={"x": noise})), ROBOT)
    assert columns.findings == ()


def test_numbers_that_cannot_be_computed_with_are_refused() -> None:
    with pytest.raises(DataFileError, match="run 0, column x: its values are about"):
        check_columns(each(x_times(1e200)), ROBOT)
    with pytest.raises(DataFileError, match="column drive"):
        check_columns(each(drive_times(1e38)), ROBOT)
