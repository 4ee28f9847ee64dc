"""``--progress`` of commands: lines of JSON, or nothing, and results where they were."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from locosweep.cli import main
from locosweep.cli.commands import COMMANDS, command

pytestmark = pytest.mark.whole

ROOT = Path(__file__).parents[1]
SWEEP = ["sweep", "mean_velocity", "--axis", "mu_static=0.2:0.8:20", "--axis", "segments=2:20",
         "--set", "mu_coulomb=0.3"]  # fmt: skip
QUICK: dict[str, list[str]] = {
    "file": [*SWEEP, "--out", "r.parquet"],
    "folder": [*SWEEP, "--out", "other/", "--chunk", "50"],
    "heatmap": ["heatmap", "mean_velocity", "--x", "mu_static=0.2:0.8:20", "--y", "segments=2:20",
                "--set", "mu_coulomb=0.3"],
    "simulate": ["simulate", "--set", "mu_coulomb=0.3", "--set", "drive_force=2", "--out", "m.csv"],
    "gait": ["gait", str(ROOT / "examples" / "gait_wave.toml"), "--out", "gait"],
    "verify": ["verify", "run"],
    "merge": ["merge", "run", "--out", "whole/"],
    "export": ["export", "run", "--out", "x.parquet"],
    "export into a folder": ["export", "run", "--out", "x"],
}  # fmt: skip
LONG = {"sweep", "explore", "heatmap", "simulate", "gait", "diagnose", "distinguish", "friction",
        "blind-check", "reproduce", "laws", "verify", "merge", "export", "propagate",
        "sensitivity"}  # fmt: skip


def events(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines()]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    assert main([*SWEEP, "--out", "run/", "--chunk", "50"]) == 0
    return tmp_path


@pytest.mark.usefixtures("place")
@pytest.mark.parametrize("name", QUICK)
def test_each_event_is_a_line_of_json(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main([*QUICK[name], "--progress", "json", "--json"]) == 0
    told = capsys.readouterr()
    json.loads(told.out)
    last = events(told.err)[-1]
    assert last["done"] == last["total"] > 0
    assert last["eta_s"] == 0.0
    if name == "folder":
        assert last["failures"] > 0


@pytest.mark.usefixtures("place")
def test_none_is_silent(capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main([*SWEEP, "--out", "r.parquet", "--progress", "none"]) == 0
    assert capsys.readouterr().err == ""


def test_every_long_command_has_the_option() -> None:
    having = {
        name for name in COMMANDS
        if any("--progress" in param.opts for param in command(name).params)
    }  # fmt: skip
    assert having == LONG


def test_reproduce_counts_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["reproduce", "2", "--out", str(tmp_path / "out"), "--progress", "json"]) == 0
    assert {event["unit"] for event in events(capsys.readouterr().err)} == {"files"}
