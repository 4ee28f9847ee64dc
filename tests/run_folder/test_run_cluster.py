"""The Slurm script of the documentation, its tasks killed and started again."""

from __future__ import annotations

import os
import random
import re
import signal
import subprocess
import sys
import time
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
"""


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

    chance = random.Random(4)  # noqa: S311 - moments, not secrets
    ended = []
    for number in (signal.SIGTERM, signal.SIGKILL, signal.SIGTERM):
        tasks = [begin(task) for task in range(count)]
        logs = len(list(tmp_path.glob("run/log/*")))
        while len(list(tmp_path.glob("run/log/*"))) < logs + count:
            assert any(task.poll() is None for task in tasks)
            time.sleep(0.02)
        for task in tasks:
            time.sleep(chance.uniform(0.0, 0.15))
            task.send_signal(number)
            task.communicate(timeout=30)
            ended.append(task.returncode)
        assert verify(tmp_path / "run").faults == ()
    assert set(ended) == {143, -9}
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
