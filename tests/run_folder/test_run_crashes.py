"""A run folder is resumable at every instant: kill -9, failing calls, a full disk."""

from __future__ import annotations

import json
import re
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from run_cases import CLOSED, data_files, partials

import locosweep as ls
from locosweep.run_folder import commit
from locosweep.run_folder.commit import host
from locosweep.run_folder.log_lines import line_of
from locosweep.run_folder.overview import overview

DRIVER = Path(__file__).with_name("crash_driver.py")
SPEC: dict[str, Any] = {**CLOSED, "chunk": 30}
ALL = 1000
"""More times than any step is passed."""


def drive(mode: str, most: int, folder: Path) -> list[dict[str, Any]]:
    done = subprocess.run(
        [sys.executable, "-W", "error", str(DRIVER), mode, str(folder), str(most)],
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    first, *rows = map(json.loads, done.stdout.splitlines())
    assert first["files"] > 10
    return rows


def assert_resumable(rows: list[dict[str, Any]]) -> None:
    for row in rows:
        # What stands under a final name is whole, before and after.
        assert row["before"]["wrong"] == [], row
        assert row["done"] == {"value": True}, row
        assert row["faults"] == {"value": 0}, row
        assert row["whole"], row
        assert row["after"]["partials"] == [], row


@pytest.mark.parametrize(
    "most",
    [pytest.param(1, marks=pytest.mark.whole), pytest.param(ALL, marks=pytest.mark.slow)],
)
def test_a_kill_at_every_step_of_a_commit_is_resumed_to_the_same_bits(
    most: int, tmp_path: Path
) -> None:
    rows = drive("kill", most, tmp_path)
    assert len(rows) >= (10 if most == 1 else 100)
    assert {row["ended"] for row in rows} == {9}
    assert any(row["before"]["partials"] for row in rows)
    assert_resumable(rows)


@pytest.mark.slow
def test_a_kill_at_a_random_moment_is_resumed_to_the_same_bits(tmp_path: Path) -> None:
    rows = drive("random", 80, tmp_path)
    assert sum(row["ended"] == 9 for row in rows) > 40
    # Kills meet several states; how many of the two dozen is up to the machine.
    assert len({row["before"]["files"] for row in rows}) > 3
    assert_resumable(rows)


@pytest.mark.parametrize(
    ("mode", "words", "most"),
    [
        pytest.param("ENOSPC", "No space left on device", 1, marks=pytest.mark.whole),
        pytest.param("EIO", "Input/output error", ALL, marks=pytest.mark.slow),
        pytest.param("EACCES", "Permission denied", 2, marks=pytest.mark.slow),
        pytest.param("EROFS", "Read-only file system", 2, marks=pytest.mark.slow),
    ],
)
def test_a_failing_call_says_where_in_one_line_and_keeps_the_rest(
    mode: str, words: str, most: int, tmp_path: Path
) -> None:
    rows = drive(mode, most, tmp_path)
    assert len(rows) >= (10 if most < ALL else 100)
    for row in rows:
        error = row["answer"]["error"]
        assert re.match(rf"InputError: {re.escape(str(tmp_path))}/\S+: cannot ", error), error
        assert words in error
        assert "\n" not in error
        assert row["before"]["partials"] == []
    assert_resumable(rows)


def test_a_full_disk_leaves_no_stub_and_is_resumed(tmp_path: Path) -> None:
    """Files may not grow beyond what metadata and logs take: chunks do not fit."""
    folder = tmp_path / "run"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    big = {**SPEC, "mu_static": np.linspace(0.2, 0.8, 400), "chunk": 8400}
    resource.setrlimit(resource.RLIMIT_FSIZE, (40_000, before[1]))
    try:
        with pytest.raises(ls.InputError, match="File too large") as caught:
            ls.sweep(**big, out=folder)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert re.search(r"/c\.0\.0\.0: cannot write \d+ bytes", str(caught.value))
    assert partials(folder) == []
    assert not [name for name in data_files(folder) if name.endswith("c.0.0.0")]
    assert ls.sweep(**big, out=folder).complete


def test_a_wrong_fault_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for wrong in ("kill", "kill@nowhere:1", "boom@write:1", "kill@write:x"):
        monkeypatch.setenv("LOCOSWEEP_FAULT", wrong)
        with pytest.raises(ls.InputError, match="LOCOSWEEP_FAULT"):
            ls.sweep(**SPEC, out=tmp_path / "run")


def test_a_torn_last_line_of_a_log_counts_as_not_written(tmp_path: Path) -> None:
    run = ls.sweep(**SPEC, out=tmp_path / "run")
    wanted = data_files(run.folder)
    (log,) = (run.folder / "log").iterdir()
    whole = log.read_bytes()
    log.write_bytes(whole[:-20])
    torn = ls.open_run(run.folder)
    assert len(torn.missing) == 1
    assert not torn.complete
    with pytest.raises(ls.InputError, match=r"1 of \d+ chunks are not computed"):
        torn.to_xarray()
    assert ls.sweep(**SPEC, out=run.folder).complete
    assert data_files(run.folder) == wanted
    assert len(list((run.folder / "log").iterdir())) == 2


@pytest.mark.parametrize("change", ["twice", "flipped", "foreign", "deep", "blank"])
def test_other_lines_of_a_log_lose_nothing(change: str, tmp_path: Path) -> None:
    run = ls.sweep(**SPEC, out=tmp_path / "run")
    (log,) = (run.folder / "log").iterdir()
    lines = log.read_bytes().splitlines(keepends=True)
    missing = 0
    if change == "twice":
        lines.append(lines[-1])
    elif change == "flipped":
        lines[2] = lines[2].replace(b'"chunk":', b'"chunk" ', 1)
        missing = 1
    elif change == "foreign":
        lines += [b"\xff\xfe no json\n", b"{}\t00000000\n"]
    elif change == "deep":
        lines.append(b"[" * 100_000 + b"\n")
    else:
        lines.insert(1, b"\n\n")
    log.write_bytes(b"".join(lines))
    assert len(ls.open_run(run.folder).missing) == missing
    assert ls.sweep(**SPEC, out=run.folder).complete


@pytest.mark.parametrize(
    "record",
    [
        "text",
        3,
        {"at": "now"},
        {"at": float("inf")},
        {"chunk": float("inf"), "files": {}, "counts": {}, "seconds": 0, "at": 0},
        {"chunk": 0, "files": {}, "counts": {}, "seconds": 0, "at": 0},
        {"counts": {}},
        {"counts": {"mean_velocity": {"0": 1}, "peak_power": {"250": 1}}},
        {"counts": {"mean_velocity": {"0": 1}, "peak_power": {"x": 1}}},
    ],
)
def test_a_line_that_says_what_cannot_be_counts_as_altered(record: Any, tmp_path: Path) -> None:
    """With a checksum that is right, as another program would write it."""
    run = ls.sweep(**SPEC, out=tmp_path / "run")
    (log,) = (run.folder / "log").iterdir()
    lines = log.read_bytes().splitlines(keepends=True)
    if isinstance(record, dict) and record.keys() == {"counts"}:
        record = json.loads(lines[-1].rpartition(b"\t")[0]) | record
    log.write_bytes(b"".join([*lines, line_of(record)]))
    found = overview(run.folder)
    assert found.done == run.manifest.plan.count
    assert sum(w.dropped for w in found.writers) == 1
    assert ls.sweep(**SPEC, out=run.folder).complete


def test_a_clock_beyond_the_calendar_is_no_error(tmp_path: Path) -> None:
    run = ls.sweep(**SPEC, out=tmp_path / "run")
    (log,) = (run.folder / "log").iterdir()
    last = json.loads(log.read_bytes().splitlines()[-1].rpartition(b"\t")[0])
    log.write_bytes(log.read_bytes() + line_of(last | {"at": 1e18}))
    assert overview(run.folder).writers[0].last == "at no time"


def test_files_that_nobody_logged_are_not_trusted(tmp_path: Path) -> None:
    run = ls.sweep(**SPEC, out=tmp_path / "run")
    wanted = data_files(run.folder)
    (log,) = (run.folder / "log").iterdir()
    log.unlink()
    victim = run.folder / "data.zarr" / "mean_velocity" / "c.0.0.0"
    victim.write_bytes(victim.read_bytes()[:-1] + b"!")
    assert len(ls.open_run(run.folder).missing) == run.manifest.plan.count
    assert ls.sweep(**SPEC, out=run.folder).complete
    assert data_files(run.folder) == wanted


def test_only_what_dead_writers_of_this_machine_left_is_removed(tmp_path: Path) -> None:
    run = ls.sweep(**SPEC, out=tmp_path / "run")
    root = run.folder / "data.zarr" / "mean_velocity"
    dead = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"],
                          capture_output=True, text=True, check=True).stdout.strip()  # fmt: skip
    gone = root / f"c.0.0.0.{host()}-{dead}-00ff.partial"
    kept = [
        root / f"c.0.0.0.{host()}-1-00ff.partial",
        root / f"c.0.0.0.elsewhere-{dead}-00ff.partial",
    ]
    for path in (gone, *kept):
        path.write_bytes(b"half")
    ls.sweep(**SPEC, out=run.folder)
    assert not gone.exists()
    assert all(path.exists() for path in kept)
    assert ls.open_run(run.folder).complete


def test_a_system_without_folders_to_open_or_processes_to_ask(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on Windows, where signal 0 is Ctrl-C to the process that is asked for."""
    run = ls.sweep(**SPEC, out=tmp_path / "other")
    left = run.folder / "data.zarr" / f"zarr.json.{host()}-1-00ff.partial"
    left.write_bytes(b"half")
    killed: list[int] = []
    with monkeypatch.context() as windows:
        windows.delattr(commit.os, "O_DIRECTORY")
        windows.setattr(commit.os, "kill", lambda pid, _: killed.append(pid))
        windows.setattr(commit.os, "name", "nt")
        commit.sync_folders([run.folder])
        assert commit.sweep_stale([run.folder / "data.zarr"]) == 0
    assert killed == []
    assert left.exists()
