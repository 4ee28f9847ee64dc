"""The command `init`: a rig's own log becomes runs and a first nominal file, in one step."""

import json
import shlex
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from locosweep.cli import main
from locosweep.files.robot import Robot
from locosweep.files.runs import Run, load_runs
from locosweep.simulation.replay import replay_runs

RIG = Robot(
    {"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {},
    {"viscous_friction": {"c": 1.5}},
)
SET = ("--set", "mass=0.25", "--set", "mu_coulomb=0.3")


def exported(path, count=4, seconds=4.0):
    """A rig's log as its software exports it, and the runs behind it.

    With a byte order mark, a comment, semicolons, decimal commas, CRLF, foreign names, mm, Unix
    time, columns of no use, and 2 % of the rows missing.
    """
    t = np.arange(0.0, seconds, 0.01)
    runs = [
        Run(str(k), t, np.where(t < 0.1, 0.0, (1.1 + 0.1 * k) * np.sin((5 + k) * (t - 0.1))))
        for k in range(count)
    ]
    read = replay_runs(RIG, runs)["x"].to_numpy().reshape(count, t.size)
    random = np.random.default_rng(1)
    lines = ["# Prüfstand 3, Bediener: Müller", "Zeit;Sollkraft_N;Istposition_mm;Temp [°C];Notiz"]
    begin = 1764075181.0
    for run, x in zip(runs, read, strict=True):
        seen = 1e3 * (x + 0.0125 + random.normal(0.0, 1e-5, t.size))
        for k in range(t.size):
            if k < 5 or random.random() > 0.02:
                row = f"{begin + t[k]:.3f};{run.drive[k]:.4f};{seen[k]:.4f};20.5;ok"
                lines.append(row.replace(".", ","))
        begin += 30.0
    path.write_bytes(("\r\n".join(lines) + "\r\n").encode("utf-8-sig"))
    return runs, read


@pytest.fixture
def call(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        done = capsys.readouterr()
        return code, done.out, done.err

    return run


def test_a_log_becomes_runs_and_a_nominal_file(call, tmp_path):
    runs, read = exported(tmp_path / "rig.csv", count=2, seconds=1.0)
    code, out, err = call("init", "rig.csv", "--out", "rig", *SET)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == "t is Zeit (by its name), in s (Unix time)"
    assert "x is Istposition_mm (by its name), in mm (by its name)" in lines
    assert lines[-1] == (
        "next: locosweep diagnose rig/runs.csv --nominal rig/nominal.toml --out rig/report"
    )
    found, notices = load_runs("rig/runs.csv")
    assert notices == []
    assert len(found) == 2
    for run, true, x in zip(found, runs, read, strict=True):
        at = np.round(run.t / 0.01).astype(int)
        np.testing.assert_allclose(run.t, true.t[at], atol=1e-9)
        np.testing.assert_allclose(run.drive, true.drive[at], atol=1e-4)
        np.testing.assert_allclose(run.channels["x"], x[at] + 0.0125, atol=6e-5)
    assert sorted(path.name for path in (tmp_path / "rig").iterdir()) == [
        "nominal.toml", "runs.csv"
    ]  # fmt: skip


def test_the_documentation_shows_what_is_printed(call, tmp_path):
    page = (Path(__file__).parents[1] / "docs" / "your-data.md").read_text(encoding="utf-8")
    commands, log, printed = (
        block.split("\n", 1)[1].splitlines() for block in page.split("```")[1:6:2]
    )
    exported(tmp_path / "rig.csv")
    assert (tmp_path / "rig.csv").read_text("utf-8-sig").splitlines()[: len(log)] == log
    first, second = (shlex.split(line.removeprefix("$ locosweep ")) for line in commands)
    code, out, _ = call(*first)
    assert code == 0
    assert out.splitlines() == printed
    assert shlex.split(printed[-1].removeprefix("next: locosweep ")) == second


def test_the_next_command_is_one_for_a_shell(call, tmp_path):
    exported(tmp_path / "rig.csv", count=1, seconds=1.0)
    code, out, _ = call("init", "rig.csv", "--out", "my rig", *SET)
    assert code == 0
    assert out.splitlines()[-1] == (
        "next: locosweep diagnose 'my rig/runs.csv' --nominal 'my rig/nominal.toml' "
        "--out 'my rig/report'"
    )


def test_what_is_missing_is_said_and_named_by_the_diagnosis(call, tmp_path):
    exported(tmp_path / "rig.csv", count=2, seconds=1.0)
    code, out, _ = call("init", "rig.csv", "--out", "rig", "--json")
    assert code == 0
    report = json.loads(out)
    assert report["missing"] == ["robot.mass", "surface.mu_coulomb"]
    assert report["columns"]["x"] == "Istposition_mm"
    assert report["runs"] == 2
    code, out, err = call("diagnose", "rig/runs.csv", "--nominal", "rig/nominal.toml", "--out", "d")
    assert (code, out) == (2, "")
    assert "rig/nominal.toml: [robot] mass is '?'" in err


def test_options_come_before_guesses(call):
    t = np.arange(30) * 0.01
    frame = pl.DataFrame({"clock": t, "a": 0 * t, "b": t, "c": 2 * t})
    frame.write_csv("r.csv")
    assert call("init", "r.csv", "--out", "o")[0] == 2
    code, out, _ = call(
        "init", "r.csv", "--out", "o", "--column", "drive=a", "--column", "x=c", "--unit", "x=mm"
    )
    assert code == 0
    assert "x is c (as you say), in mm (as you say)" in out
    assert pl.read_csv("o/runs.csv")["x"][10] == pytest.approx(2e-4)


def test_a_full_folder_is_refused(call, tmp_path):
    exported(tmp_path / "rig.csv", count=1, seconds=1.0)
    assert call("init", "rig.csv", "--out", "rig", *SET)[0] == 0
    before = (tmp_path / "rig" / "nominal.toml").read_text()
    code, out, err = call("init", "rig.csv", "--out", "rig", "--set", "mass=1")
    assert (code, out) == (2, "")
    assert "rig is not empty" in err
    assert (tmp_path / "rig" / "nominal.toml").read_text() == before
    assert call("init", "rig.csv", "--out", "rig", "--set", "mass=1", "--force")[0] == 0
    assert (tmp_path / "rig" / "nominal.toml").read_text() != before


@pytest.mark.parametrize(
    "options",
    [
        ("gone.csv",), ("r.csv", "--set", "mass"), ("r.csv", "--set", "mass=x"),
        ("r.csv", "--set", "masss=1"), ("r.csv", "--pause", "0"), ("r.csv", "--unit", "x=kN"),
        ("r.csv", "--column", "y=x"), ("r.csv", "--decimal", "dot"), ("run.mcap",), (),
    ],
)  # fmt: skip
def test_bad_input_costs_one_line_and_leaves_nothing(call, tmp_path, options):
    t = np.arange(30) * 0.01
    pl.DataFrame({"t": t, "drive": t, "x": t}).write_csv("r.csv")
    code, out, err = call("init", *options, "--out", "o")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert not (tmp_path / "o").exists()


@pytest.mark.slow
@pytest.mark.whole
def test_two_steps_from_a_log_to_a_verdict(call, tmp_path):
    exported(tmp_path / "rig.csv")
    assert call("init", "rig.csv", "--out", "rig", *SET)[0] == 0
    code, out, err = call(
        "diagnose", "rig/runs.csv", "--nominal", "rig/nominal.toml", "--out", "report", "--json"
    )
    assert code == 0
    verdict = json.loads(out)["verdict"]
    assert "viscous_friction" in {name for group in verdict["equivalent"] for name in group}
    assert verdict["status"] in ("explained", "ambiguous")
    assert "rows are missing" in err
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    assert report["gap"]["shrink"] > 0.98
