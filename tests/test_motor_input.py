"""Numbers of the motor that are none: one line that names the argument, or a status."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.errors import InputError
from locosweep.registry import Status

ROBOT = {"segments": 5, "mu_static": 0.5, "mu_coulomb": 0.3, "drive_limit": 30.0,
         "speed_limit": 0.01, "dwell": 0.05, "cycles": 1, "supply_voltage": 24.0}  # fmt: skip
REFUSED = [
    (name, value)
    for name, values in {
        "supply_voltage": (-1.0, math.nan, 1e-300),
        "winding_resistance": (0.0, -1.0, math.nan, math.inf),
        "force_constant": (0.0, -1.0, math.nan, math.inf),
        "speed_limit": (0.0, -1.0, math.nan),
    }.items()
    for value in values
]
TABLES = {"supply_voltage": "motor", "winding_resistance": "motor", "force_constant": "motor",
          "speed_limit": "drive"}  # fmt: skip
KEYS = {"winding_resistance": "resistance"}


@pytest.mark.parametrize(("name", "value"), REFUSED)
def test_library(name, value):
    for call in (ls.run_gait, lambda **values: ls.sweep("gait_advance", **values)):
        with pytest.raises(InputError, match=rf"^{name} is .*: allowed is a number from [^\n]*$"):
            call(**ROBOT | {name: value})


@pytest.mark.parametrize(("name", "value"), REFUSED)
def test_commands_write_nothing(name, value, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    given = [
        part for key, one in (ROBOT | {name: value}).items() for part in ("--set", f"{key}={one}")
    ]
    key = KEYS.get(name, name)
    text = '[gait]\nschedule = "single"\n[robot]\nsegments = 4\n[surface]\nmu_static = 0.5\n'
    (tmp_path / "g.toml").write_text(
        f'format = "locosweep.gait/1"\n{text}mu_coulomb = 0.3\n[{TABLES[name]}]\n{key} = {value}\n'
    )
    for arguments, word in (
        (["sweep", "gait_advance", *given, "--out", "r.parquet"], name),
        (["gait", "g.toml", "--out", "o"], f"[{TABLES[name]}] {key}"),
    ):
        assert main(arguments) == 2
        err = capsys.readouterr().err
        assert err.count("\n") == 1
        assert re.search(rf"{re.escape(word)} is .*: allowed is a number from", err)
        assert [path.name for path in tmp_path.iterdir()] == ["g.toml"]


@pytest.mark.parametrize("stiffness", [math.inf, 2000.0])
@pytest.mark.parametrize(
    "given",
    [{"supply_voltage": 0.0}, {"supply_voltage": 1e-30}, {"supply_voltage": 1e-6},
     {"supply_voltage": math.inf}, {"speed_limit": math.inf}, {"force_constant": 1e-9},
     {"force_constant": 1e9}, {"winding_resistance": 1e-9}, {"winding_resistance": 1e9}],
)  # fmt: skip
def test_extremes_have_a_value_or_a_status(given, stiffness):
    found = ls.sweep("gait_advance", **ROBOT | given, joint_stiffness=stiffness)
    assert np.isfinite(found.values) == (found.status == Status.OK)
    weak = Status.DRIVE_TOO_WEAK if stiffness == math.inf else Status.SUPPLY_TOO_WEAK
    if given.get("supply_voltage", 1.0) < 1.0:
        assert found.status == weak
