"""Commands of run folders, as people and Slurm run them."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING, Any

import polars as pl
import pytest
from run_cases import data_files

import locosweep as ls
from locosweep import _core
from locosweep.cli import main
from locosweep.run_folder.verify import verify
from locosweep.specs.sweep import Spec

if TYPE_CHECKING:
    from pathlib import Path

SPEC = """
format = "locosweep.sweep/1"
quantities = ["mean_velocity"]
[axes]
segments = {from = 2, to = 20}
slope_deg = {from = 0, to = 20, count = 41}
[fixed]
mu_static = 0.5
mu_coulomb = 0.3
"""
LONG = """
format = "locosweep.sweep/1"
quantities = ["final_position"]
[simulation]
law = "lugre"
drive = "sine"
[axes]
mu_static = {from = 0.3, to = 0.6, count = 120}
drive_amplitude = {from = 0.5, to = 2, count = 60}
[fixed]
mu_coulomb = 0.3
# Makes each cell slow: signals have to come before the sweep is done.
tolerance = 1e-10
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "spec.toml").write_text(SPEC)
    (tmp_path / "long.toml").write_text(LONG)
    return tmp_path


def run(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 0) -> str:
    assert main(arguments) == code
    told = capsys.readouterr()
    if code == 2:
        assert told.err.count("\n") == 1
        assert told.err.startswith("locosweep: ")
        return told.err
    assert told.err == ""
    return told.out


def test_a_sweep_file_goes_into_a_folder_and_is_told_of(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(capsys, "sweep", "spec.toml", "--out", "run/", "--chunk", "100") == "run/\n"
    assert run(capsys, "sweep", "--spec", "spec.toml", "--out", "run") == "run\n"
    text = run(capsys, "status", "run")
    assert text.startswith("10 of 10 chunks done (100.0%), 0 missing, 0 damaged\n")
    assert "mean_velocity: ok 9" in text
    assert "cells/s, last at 20" in text
    assert text.endswith(f", by {_core.version()} on {_core.simd_level()}\n")
    told = json.loads(run(capsys, "status", "run", "--json"))
    assert (told["chunks"], told["done"], told["missing"]) == (10, 10, 0)
    assert sum(told["statuses"]["mean_velocity"].values()) == 19 * 41
    assert [w["chunks"] for w in told["writers"]] == [10]
    assert run(capsys, "verify", "run").endswith(
        "10 of 10 chunks are written, 0 files are damaged\n"
    )
    again = json.loads(run(capsys, "sweep", "spec.toml", "--out", "run", "--json"))
    assert again["chunks"] == {"all": 10, "done": 10, "damaged": 0}
    assert again["outputs"][0]["statuses"]["ok"] > 700
    assert sorted(p.name for p in place.iterdir()) == ["long.toml", "run", "spec.toml"]


def test_damage_is_told_with_exit_code_1_and_repaired(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run(capsys, "sweep", "spec.toml", "--out", "run", "--chunk", "100")
    wanted = data_files(place / "run")
    victim = place / "run" / "data.zarr" / "mean_velocity" / "c.0.0"
    victim.write_bytes(victim.read_bytes()[:-1])
    assert "chunk 0 is damaged: mean_velocity/c.0.0 has" in run(capsys, "status", "run")
    text = run(capsys, "verify", "run", code=1)
    assert text.startswith("data.zarr/mean_velocity/c.0.0: altered (hash differs)\n")
    assert "chunk 0 is damaged" in run(capsys, "export", "run", "--out", "x.parquet", code=2)
    assert not (place / "x.parquet").exists()
    assert "1 repaired" in run(capsys, "verify", "run", "--repair")
    assert data_files(place / "run") == wanted


@pytest.mark.usefixtures("place")
def test_a_run_is_exported_as_parquet(capsys: pytest.CaptureFixture[str]) -> None:
    run(capsys, "sweep", "spec.toml", "--out", "run", "--chunk", "100")
    wanted = Spec.load("spec.toml").run().to_polars()
    axes = ["segments", "slope_deg"]
    run(capsys, "export", "run", "--out", "all.parquet")
    run(capsys, "export", "run", "--out", "parts")
    for source in ("all.parquet", "parts/*.parquet"):
        found = pl.read_parquet(source).sort(axes)
        assert found.equals(wanted.sort(axes), null_equal=True)
    said = run(capsys, "export", "run", "--out", "parts", code=2)
    assert "parts is not empty: allowed is a new folder, or an empty one" in said
    assert "allowed are .parquet" in run(capsys, "export", "run", "--out", "x.csv", code=2)


def test_what_is_altered_while_it_is_exported_is_named(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same size, so that only its hash tells."""
    run(capsys, "sweep", "spec.toml", "--out", "run", "--chunk", "100")
    victim = place / "run" / "data.zarr" / "mean_velocity" / "c.1.1"
    victim.write_bytes(b"\0" * victim.stat().st_size)
    for out in ("x.parquet", "x"):
        text = run(capsys, "export", "run", "--out", out, code=2)
        assert "is damaged (mean_velocity/c.1.1 was altered)" in text
        assert "Traceback" not in text
        assert not (place / out).exists()


@pytest.mark.usefixtures("place")
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("sweep spec.toml --out run.csv", "allowed are .parquet"),
        ("sweep spec.toml mean_velocity --out run/", "beside QUANTITY or --spec"),
        ("sweep spec.toml --spec spec.toml --out run/", "beside QUANTITY or --spec"),
        ("sweep spec.toml --axis segments=2:3 --out run/", "--axis"),
        ("sweep none.toml --out run/", "none.toml: No such file"),
        ("sweep spec.toml --out run/ --shard 2/2", "allowed is I/N"),
        ("sweep spec.toml --out run/ --shard 1", "allowed is I/N"),
        ("sweep spec.toml --out run/ --shard 1/9999999999999999999", "allowed is I/N"),
        ("sweep spec.toml --out r.parquet --shard 0/2", "with --out FOLDER/ only"),
        ("sweep spec.toml --out r.parquet --chunk 5", "with --out FOLDER/ only"),
        ("sweep spec.toml", "--out is missing"),
        ("sweep nonsense --out run/", "unknown quantity 'nonsense'"),
        ("status none", "no such folder"),
        ("verify .", "no run folder"),
        ("export none --out x", "no such folder"),
    ],
)
def test_bad_input_is_one_line(
    arguments: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert words in run(capsys, *arguments.split(), code=2)


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_a_sweep_that_is_told_to_end_does_so_and_goes_on_later(
    number: signal.Signals, code: int, place: Path
) -> None:
    command = [sys.executable, "-m", "locosweep", "sweep", "long.toml", "--out", "run/",
               "--chunk", "60"]  # fmt: skip
    waits = []
    for turn in range(4):
        process = subprocess.Popen(command, cwd=place, stderr=subprocess.PIPE, text=True)
        logs = len(list(place.glob("run/log/*.jsonl")))
        while len(list(place.glob("run/log/*.jsonl"))) == logs:
            assert process.poll() is None, process.communicate()
            time.sleep(0.01)
        time.sleep(0.05 * turn)
        begin = time.perf_counter()
        process.send_signal(number)
        _, err = process.communicate(timeout=20)
        waits.append(time.perf_counter() - begin)
        assert process.returncode == code, err
        assert err == ("locosweep: interrupted\n" if code == 130 else "")
        assert verify(place / "run").faults == ()
    # A quarter of a second on a machine of its own; others may use this one.
    assert min(waits) < 2.0
    assert not ls.open_run(place / "run").complete
    done: Any = subprocess.run(command, cwd=place, capture_output=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    finished = ls.open_run(place / "run")
    whole = Spec.load(place / "long.toml").run()
    assert finished.to_result().values.tobytes() == whole.values.tobytes()
