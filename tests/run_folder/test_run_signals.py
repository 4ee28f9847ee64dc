"""Signals while a command computes, writes and draws: exit codes, nothing half-written."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

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
    for row in rows:
        assert row["code"] == CODES[row["signal"]], row
        if row["phase"] == "plot":
            assert row["left"] == [], row
        else:
            assert (row["faults"], row["partials"]) == (0, 0), row
    # A quarter of a second on a machine of its own; others may use this one.
    assert sorted(row["taken"] for row in rows)[len(rows) // 2] < 2.0
