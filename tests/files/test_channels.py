"""Every consumer of the table of channels over every channel."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import locosweep as ls
from locosweep import _core, measured
from locosweep.diagnosis.data.noise import noise_of
from locosweep.diagnosis.design.distance import PlannedRuns
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.report import figures_style
from locosweep.diagnosis.report.comparison import compare_whole_runs
from locosweep.errors import InputError
from locosweep.files.channels import CHANNELS, OFFSETS, PREDICTED, REPLAYED
from locosweep.files.robot import Robot
from locosweep.files.runs import Run, runs_from_frame
from locosweep.files.units import is_unit
from locosweep.simulation.replay import replay_runs
from locosweep.validation.rigs import Sensors

PACKAGE = Path(__file__).parents[2] / "python" / "locosweep"
T = np.arange(0.0, 1.0, 0.01)
DRIVE = np.where(T < 0.1, 0.0, 1.0)
MOTOR = {"winding_resistance": 20.0, "force_constant": 1.7}
ROBOT = Robot({"mass": 0.25, "segments": 4.0, "mu_coulomb": 0.2, **MOTOR})
ROTARY = Robot(ROBOT.parameters, {"bench.kind": "rotary", "bench.gravity_torque": 1.0})
SENSORS = Sensors(1.0, 0.1, 2.0, 3.0, 4.0)


@pytest.fixture(params=list(CHANNELS))
def name(request):
    return request.param


def run_with(name: str) -> Run:
    """A run that has x and another channel."""
    noise = np.random.default_rng(1).normal(0.0, 1e-3, (2, T.size))
    return Run("0", T, DRIVE, {"x": 1e-3 * T + noise[0], name: 1e-3 * T + noise[1]})


def test_a_replay_returns_them_in_their_order():
    frame = replay_runs(ROBOT, [Run("0", T, DRIVE)])
    assert tuple(frame.columns) == ("run", "t", *REPLAYED)
    # The head moves 0.1 m and more at some speed, the body rests, the drive gives 1 N.
    last = dict(zip(frame.columns, frame.row(-1), strict=True))
    assert last["x"] > 0.1
    assert last["v"] > 0.1
    assert last["x_rear"] == 0.0
    assert last["force"] == 1.0


def test_what_is_predicted_is_replayed_or_follows_from_the_motor():
    assert set(PREDICTED) == set(CHANNELS)
    assert PREDICTED[: len(REPLAYED)] == REPLAYED
    assert set(OFFSETS) <= set(REPLAYED)


def test_outside_users_read_the_same_names(name):
    assert measured.CHANNELS[name] == CHANNELS[name].meaning


def test_units_are_of_the_lists(name):
    channel = CHANNELS[name]
    for unit in (channel.unit, channel.rotary_unit):
        assert is_unit(unit)


def test_a_file_may_have_it(name):
    frame = pl.DataFrame({"t": T, "drive": DRIVE, "x": T}).with_columns(pl.Series(name, 2.0 * T))
    (run,) = runs_from_frame(frame)
    np.testing.assert_array_equal(run.channels[name], 2.0 * T)


def test_the_nominal_file_states_its_noise(name):
    sensor = CHANNELS[name].sensor
    keys = {p.file_key for p in _core.file_keys()}
    assert ("sensor", f"{sensor}_noise") in keys
    assert noise_of(name, [run_with(name)], {f"{sensor}_noise": 0.5}).sd == pytest.approx(
        0.5, rel=1e-4
    )
    assert noise_of(name, [run_with(name)], {}).sd == pytest.approx(1e-3, rel=0.3)


def test_a_diagnosis_fits_it(name):
    problem = Problem(ROBOT, [run_with(name)], 1)
    assert set(problem.channels) == {"x", name}
    assert np.isfinite(problem.residuals([problem.plain()])).all()
    assert (name in problem.priors) == (name in OFFSETS)
    nominal = problem.plain()
    comparison = compare_whole_runs(problem, nominal, nominal)
    assert comparison.unit(name) == CHANNELS[name].unit


def test_an_experiment_may_plan_it_where_it_is_replayed(name):
    if name in REPLAYED:
        assert list(PlannedRuns(ROBOT, [Run("0", T, DRIVE)], {name: 1e-3}).noise) == [name]
        return
    with pytest.raises(InputError, match="unknown channel"):
        ls.distinguish(ROBOT, {"a": (T, DRIVE)}, noise={name: 1e-3})


@pytest.mark.parametrize(("robot", "rotary"), [(ROBOT, False), (ROTARY, True)])
def test_pictures_have_words_symbol_and_unit(name, robot, rotary):
    drawn = figures_style.channel(name, robot)
    assert (drawn.words, drawn.symbol) == (CHANNELS[name].words, CHANNELS[name].symbol)
    assert drawn.unit == CHANNELS[name].unit_on(rotary=rotary)


def test_the_blind_check_has_its_sensor(name):
    own = {"x": 1.0, "x_rear": 1.0, "force": 2.0, "v": 3.0, "power": 4.0}[name]
    assert SENSORS.noise(name) == own
    assert SENSORS.deviation(name) >= own


def test_the_documentation_names_its_column(name):
    page = PACKAGE.parents[1] / "docs" / "diagnosis.md"
    assert f"| `{name}` |" in page.read_text(encoding="utf-8")


ELSEWHERE = {
    "diagnosis/report/figures_motion.py": "order of a picture's rows",
    "validation/experiment.py": "readings of the independent reality",
    "validation/rigs.py": "which sensors a drawn rig has",
}
"""Files that list channels for a reason of their own."""


def test_no_other_file_lists_channels():
    faults = []
    for path in sorted((PACKAGE).rglob("*.py")):
        place = path.relative_to(PACKAGE).as_posix()
        if not place.startswith(("diagnosis", "validation", "simulation/replay", "files")):
            continue
        if place == "files/channels.py" or place in ELSEWHERE:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            parts = node.keys if isinstance(node, ast.Dict) else getattr(node, "elts", [])
            named = {p.value for p in parts if isinstance(p, ast.Constant)} & set(CHANNELS)
            if len(named) > 2:
                faults.append(f"{place}:{node.lineno} {sorted(named)}")
    assert faults == []
