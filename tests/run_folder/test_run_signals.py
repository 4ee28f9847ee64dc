"""Signals while a command computes, writes and draws: exit codes, nothing half-written."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from run_cases import CLOSED, partials

import locosweep as ls
from locosweep.errors import Cancelled
from locosweep.run_folder import commit

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

DRIVER = Path(__file__).with_name("signal_driver.py")
CODES = {"SIGTERM": 143, "SIGHUP": 129, "SIGINT": 130}
TURNS = 3


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no SIGHUP here")
@pytest.mark.usefixtures("ctrl_c")
def test_each_signal_at_each_phase_ends_the_command_and_leaves_what_is_whole(
    tmp_path: Path,
) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", str(DRIVER), str(tmp_path), str(TURNS)],
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    rows = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(rows) == TURNS * 9
    # Otherwise there was nothing that a signal could have damaged.
    assert {row["phase"] for row in rows if row.get("chunks")} == {"kernel", "write"}
    for row in rows:
        assert row["code"] == CODES[row["signal"]], row
        if row["phase"] == "plot":
            assert row["left"] == [], row
        else:
            assert (row["faults"], row["partials"]) == (0, 0), row
    # A quarter of a second on a machine of its own; others may use this one.
    assert sorted(row["taken"] for row in rows)[len(rows) // 2] < 2.0


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_waits_for_the_writers_of_the_last_chunks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is computed any more then: an interrupted wait must not count as an ended one."""
    write = commit._write
    pressed = threading.Event()

    def slowly(
        path: Path, parts: Sequence[bytes | memoryview], stop: Callable[[], bool] | None
    ) -> None:
        if stop is None or pressed.is_set():
            write(path, parts, stop)
            return
        pressed.set()
        with path.open("xb"):
            # By now the thread that computes waits for this one.
            time.sleep(0.05)
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.05)
            raise Cancelled("stopped")

    monkeypatch.setattr(commit, "_write", slowly)
    with pytest.raises(KeyboardInterrupt):
        ls.sweep(**CLOSED, chunk=1000, out=tmp_path / "run")
    assert pressed.is_set()
    assert partials(tmp_path) == []
    assert ls.open_run(tmp_path / "run", allow_missing=True).state.done_count == 0
    assert ls.sweep(**CLOSED, out=tmp_path / "run").complete
