"""The Slurm script of the documentation, its tasks killed and started again."""

from __future__ import annotations

import os
import random
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from run_cases import partials

import locosweep as ls
from locosweep.run_folder.verify import verify
from locosweep.specs.sweep import Spec

ROOT = Path(__file__).parents[2]
SPEC = """
format = "locosweep.sweep/1"
quantities = ["final_position"]
[simulation]
law = "lugre"
drive = "sine"
[axes]
mu_static = {from = 0.3, to = 0.6, count = 400}
drive_amplitude = {from = 0.5, to = 2, count = 60}
[fixed]
mu_coulomb = 0.3
# Makes each cell slow: signals have to come before the sweep is done.
tolerance = 1e-8
"""


def logged(run: Path, pid: int) -> int:
    """Count the chunks that the process with this number has logged."""
    # The first line says who writes.
    return sum(log.read_bytes().count(b"\n") - 1 for log in run.glob(f"log/*-{pid}-*.jsonl"))


@pytest.mark.slow
def test_tasks_of_the_script_are_killed_and_started_again(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "cluster.md").read_text()
    (script,) = re.findall(r"^```bash\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert "exec locosweep" in script
    # Chunks small enough for a task to be in the middle of several.
    (tmp_path / "sweep.sh").write_text(script.replace("--out run/", "--out run/ --chunk 100"))
    (tmp_path / "spec.toml").write_text(SPEC)
    command = tmp_path / "bin" / "locosweep"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m locosweep "$@"\n')
    command.chmod(0o755)
    count = 3

    def begin(task: int) -> subprocess.Popen[str]:
        environment = os.environ | {
            "PATH": f"{command.parent}:{os.environ['PATH']}",
            "SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": str(count),
            "SLURM_CPUS_PER_TASK": "1",
        }  # fmt: skip
        return subprocess.Popen(
            ["bash", "sweep.sh"], cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True
        )

    def end(task: subprocess.Popen[str], number: signal.Signals, chunks: int) -> int:
        """Send a signal once a task has logged so many chunks of 240; return its exit code."""
        # Not after a time: how many chunks fit into it is the engine's speed.
        while logged(tmp_path / "run", task.pid) < chunks:
            assert task.poll() is None
            time.sleep(0.002)
        task.send_signal(number)
        task.communicate(timeout=30)
        return task.returncode

    chance = random.Random(4)  # noqa: S311 - moments, not secrets
    for number, code in ((signal.SIGTERM, 143), (signal.SIGKILL, -9), (signal.SIGTERM, 143)):
        tasks = [begin(task) for task in range(count)]
        # Each is watched by a thread: one that starts early would be done before the last begins.
        with ThreadPoolExecutor(count) as watchers:
            ends = [watchers.submit(end, task, number, chance.randint(1, 8)) for task in tasks]
        assert [one.result() for one in ends] == [code] * count
        assert verify(tmp_path / "run").faults == ()
    assert not ls.open_run(tmp_path / "run").complete
    for task in [begin(task) for task in range(count)]:
        _, err = task.communicate(timeout=120)
        assert task.returncode == 0, err
    run = ls.open_run(tmp_path / "run")
    assert run.complete
    assert verify(run.folder).faults == ()
    assert partials(run.folder) == []
    whole = Spec.load(tmp_path / "spec.toml").run()
    assert run.to_result().values.tobytes() == whole.values.tobytes()
