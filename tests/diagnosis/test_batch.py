"""Batches of diagnoses: resumed to the same files, in shards, one bad rig costs its own line."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import numpy as np
import polars as pl
import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.diagnosis import batch
from locosweep.diagnosis.batch import Rig, diagnose_batch

if TYPE_CHECKING:
    from pathlib import Path

NOMINAL = """
[robot]
mass = 0.2
segments = 4
[surface]
mu_coulomb = 0.3
"""
T = np.linspace(0.0, 1.0, 101)


def write_rigs(folder: Path, count: int) -> Path:
    """Write rigs that stay still, so that a diagnosis takes a moment, and their list."""
    (folder / "n.toml").write_text(NOMINAL)
    rows = ["runs,nominal"]
    for i in range(count):
        noise = np.random.default_rng(i).normal(0.0, 1e-5, T.size)
        frame = pl.DataFrame({"t": T, "drive": np.where(T > 0.1, 0.5, 0.0), "x": noise})
        frame.write_csv(folder / f"r{i}.csv")
        rows.append(f"r{i}.csv,n.toml")
    (folder / "list.csv").write_text("\n".join(rows) + "\n")
    return folder / "list.csv"


def files(out: Path) -> dict[str, str]:
    """Hash of every file of a batch."""
    return {
        str(path.relative_to(out)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(out.rglob("*"))
        if path.is_file()
    }


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_rigs(tmp_path, 3)
    return tmp_path


def call(capsys: pytest.CaptureFixture[str], *more: str, code: int = 0) -> tuple[str, str]:
    given = ["diagnose", "--batch", "list.csv", "--out", "out", "--threads", "1", *more]
    assert main(given) == code
    told = capsys.readouterr()
    return told.out, told.err


@pytest.mark.whole
def test_bad_rigs_cost_their_own_line_and_a_second_call_does_nothing(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (place / "broken.csv").write_text("t,drive,x\n0,0,zero\n")
    (place / "list.csv").write_text(
        "name,runs,nominal,options\n"
        "good,r0.csv,n.toml,\n"
        "gone,none.csv,n.toml,\n"
        "broken,broken.csv,n.toml,\n"
        "seeded,r1.csv,n.toml,--seed 3 --max-effects 1\n"
    )
    out, err = call(capsys, "--progress", "json", code=1)
    lines = out.splitlines()
    assert lines[0] == "good    none (probability " + lines[0].rpartition(" ")[2]
    assert lines[1].startswith("gone    error: ")
    assert "none.csv" in lines[1]
    assert "broken.csv" in lines[2]
    assert lines[4] == "2 of 4 rigs have a verdict: out/verdicts.csv"
    last = json.loads(err.splitlines()[-1])
    assert (last["done"], last["total"], last["failures"]) == (4, 4, 2)
    table = pl.read_parquet(place / "out" / "verdicts.parquet")
    assert table["status"].to_list() == ["none", "error", "error", "none"]
    assert pl.read_csv(place / "out" / "verdicts.csv")["name"].to_list() == table["name"].to_list()
    report = json.loads((place / "out" / "rigs" / "seeded" / "report.json").read_text())
    assert report["provenance"]["seed"] == 3
    assert (place / "out" / "rigs" / "good" / "report.html").is_file()
    before = {p: p.stat().st_mtime_ns for p in (place / "out" / "rigs").rglob("*")}
    call(capsys, "--quiet", code=1)
    assert {p: p.stat().st_mtime_ns for p in (place / "out" / "rigs").rglob("*")} == before
    # What was bad is done once it is good.
    (place / "none.csv").write_text((place / "r2.csv").read_text())
    out, _ = call(capsys, "--quiet", code=1)
    assert out.splitlines()[1].startswith("gone    none")


@pytest.mark.slow
def test_a_batch_that_is_killed_or_dealt_gives_the_files_of_one(tmp_path: Path) -> None:
    write_rigs(tmp_path, 4)
    command = [sys.executable, "-m", "locosweep", "diagnose", "--batch", "list.csv", "--quiet",
               "--threads", "2", "--out"]  # fmt: skip
    subprocess.run([*command, "whole"], cwd=tmp_path, check=True, capture_output=True)
    wanted = files(tmp_path / "whole")
    assert len([name for name in wanted if name.endswith("report.json")]) == 4
    for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGKILL):
        process = subprocess.Popen([*command, "killed"], cwd=tmp_path, stdout=subprocess.DEVNULL)
        done = len(list(tmp_path.glob("killed/records/*.json")))
        while process.poll() is None and len(list(tmp_path.glob("killed/records/*.json"))) == done:
            time.sleep(0.01)
        process.send_signal(number)
        process.wait(timeout=60)
    # Workers end with their parent, and may take a moment.
    time.sleep(2.0)
    subprocess.run([*command, "killed"], cwd=tmp_path, check=True, capture_output=True)
    assert files(tmp_path / "killed") == wanted
    shards = [
        subprocess.Popen([*command, "dealt", "--shard", f"{i}/2"], cwd=tmp_path,
                         stdout=subprocess.DEVNULL) for i in range(2)
    ]  # fmt: skip
    assert [shard.wait(timeout=300) for shard in shards] == [0, 0]
    assert files(tmp_path / "dealt") == wanted


def end_at_once(*_: object, **__: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def row_that_ends(rig: Rig, out: Path, code: str) -> dict[str, object]:
    """As `batch._row`, but that the process of one rig is killed in the middle of it."""
    if rig.name == "deadly":
        from locosweep.diagnosis import pipeline

        pipeline.diagnose = end_at_once
    return ROW(rig, out, code)


ROW = batch._row


@pytest.mark.slow
def test_a_rig_whose_process_is_killed_costs_its_own_line(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batch, "_row", row_that_ends)
    names = ("a", "deadly", "b")
    rigs = [Rig(n, place / f"r{i}.csv", place / "n.toml") for i, n in enumerate(names)]
    table = diagnose_batch(rigs, place / "out", processes=2)
    assert table["status"].to_list() == ["none", "error", "none"]
    assert "its process ended twice" in table["error"][1]
    assert list((place / "out" / "records").glob("*.partial")) == []


LISTS = {
    "": "columns are nothing: needed are runs and nominal",
    "runs\nr0.csv": "needed are runs and nominal",
    "runs,nominal,mass\nr0.csv,n.toml,3": "columns are runs, nominal, mass",
    "runs,runs,nominal\na,b,c": "once each",
    "runs,nominal\n": "no rig",
    "runs,nominal\nr0.csv": "row 2: 1 cells: allowed are 2",
    "runs,nominal\n,n.toml": "row 2: runs is ''",
    "runs,nominal\nr0.csv,n.toml\n\nr0.csv,n.toml": "row 4: name r0 is that of row 2",
    "name,runs,nominal\nA,r0.csv,n.toml\na,r1.csv,n.toml": "row 3: name a is that of row 2",
    "name,runs,nominal\n../x,r0.csv,n.toml": "row 2: name is '../x'",
    "runs,nominal,options\nr0.csv,n.toml,--no-such": "row 2: options: No such option",
    "runs,nominal,options\nr0.csv,n.toml,--out x": "row 2: options: --out is not allowed",
    "runs,nominal,options\nr0.csv,n.toml,more.csv": "row 2: options: more.csv is no option",
    "runs,nominal,options\nr0.csv,n.toml,--help": "row 2: options: no help",
    "runs,nominal,options\nr0.csv,n.toml,'": "row 2: options: No closing quotation",
    'runs,nominal\n"r0.csv,n.toml': "no CSV file in UTF-8",
    "runs,nominal\n\udcff,n.toml": "no CSV file in UTF-8",
}


@pytest.mark.usefixtures("place")
@pytest.mark.parametrize("text", LISTS)
def test_a_bad_list_is_one_line_before_anything_is_done(
    text: str, place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (place / "list.csv").write_bytes(text.encode(errors="surrogateescape"))
    _, err = call(capsys, code=2)
    assert LISTS[text] in err
    assert err.startswith("locosweep: list.csv")
    assert err.count("\n") == 1
    assert not (place / "out").exists()


@pytest.mark.usefixtures("place")
@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["r0.csv"], "beside RUNS or --nominal"),
        (["--nominal", "n.toml"], "beside RUNS or --nominal"),
        (["--shard", "2/2"], "allowed is I/N"),
        (["--batch", "none.csv"], "none.csv: No such file"),
    ],
)
def test_what_does_not_go_together_is_refused(
    more: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert words in call(capsys, *more, code=2)[1]
    assert main(["diagnose", "r0.csv", "--nominal", "n.toml", "--out", "o", "--shard", "0/2"]) == 2
    assert "--shard: allowed only with --batch" in capsys.readouterr().err


def test_a_batch_in_python_refuses_what_is_no_batch(tmp_path: Path) -> None:
    rig = Rig("a", tmp_path / "r.csv", tmp_path / "n.toml")
    for rigs, words in (([], "at least one"), ([rig, rig], "name a is given twice")):
        with pytest.raises(ls.InputError, match=words):
            diagnose_batch(rigs, tmp_path / "out")
    with pytest.raises(ls.InputError, match="allowed is I/N"):
        diagnose_batch([rig], tmp_path / "out", shard=(1, 1))
    assert not (tmp_path / "out").exists()
