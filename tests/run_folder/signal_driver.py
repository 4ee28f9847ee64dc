"""Sends signals to commands while they compute, write and draw; prints what became of each.

Runs as a program: commands are forked from it, which imports once and computes nothing.
``python tests/run_folder/signal_driver.py FOLDER 50`` sends each signal 50 times at each phase.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import sys
import time
from pathlib import Path
from typing import Any

import matplotlib.backends.backend_agg
import matplotlib.figure
import polars  # noqa: F401 - imported once, before forks
import zarr  # noqa: F401
from run_cases import partials

import locosweep as ls
from locosweep.cli import main as command
from locosweep.run_folder import chunk_files, commit
from locosweep.run_folder.cells import Cells
from locosweep.run_folder.manifest import NAME
from locosweep.run_folder.verify import verify

SIGNALS = {signal.SIGTERM: 143, signal.SIGHUP: 129, signal.SIGINT: 130}
# With this tolerance a chunk takes a tenth of a second, so that some are done, and there are many.
SWEEP = ["sweep", "final_position", "--axis", "mu_static=0.3:0.6:400", "--axis",
         "drive_amplitude=0.5:2:60", "--law", "lugre", "--drive", "sine", "--set",
         "mu_coulomb=0.3", "--set", "tolerance=1e-8", "--threads", "1"]  # fmt: skip
# A chunk is 64 MiB, and takes longer to write than to compute.
STORE = ["sweep", "mean_velocity", "--axis", "mu_static=0.4:0.8:1000", "--axis",
         "slope_deg=0:5:1000", "--axis", "mass=0.1:1:100", "--set", "mu_coulomb=0.3", "--set",
         "segments=4", "--threads", "1"]  # fmt: skip
DRAW = ["heatmap", "mean_velocity", "--x", "mu_static=0.3:0.8:1500", "--y", "slope_deg=0:20:1500",
        "--set", "mu_coulomb=0.3", "--set", "segments=4", "--threads", "1"]  # fmt: skip
FEW = 4
"""Chunks that a command may end within the longest delay."""
PHASES = {
    "kernel": ([*SWEEP, "--chunk", "500", "--out", "run/"], Cells, "block"),
    "write": ([*STORE, "--out", "run/"], commit, "_write"),
    "plot": ([*DRAW, "--out", "map.png"], matplotlib.figure.Figure, "savefig"),
}  # fmt: skip


def child(phase: str, pipe: int, folder: Path) -> None:
    """Run the command of a phase, and say when that begins; never returns."""
    code = 70
    try:
        os.chdir(folder)
        arguments, owner, name = PHASES[phase]
        called = getattr(owner, name)

        def told(*given: Any, **more: Any) -> Any:
            # The first file of a run is its small manifest.
            if phase != "write" or given[0].name.startswith("c."):
                os.write(pipe, b"!")
            return called(*given, **more)

        setattr(owner, name, told)
        if phase == "write":
            setattr(chunk_files, "write_file", commit.write_file)  # noqa: B010
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, 2)
        code = command(arguments)
    except SystemExit as stop:
        code = int(stop.code or 0)
    finally:
        os._exit(code)


def one(phase: str, number: signal.Signals, folder: Path, delay: float) -> dict[str, Any]:
    """Send one signal so long after a phase began; return code, latency and what is left."""
    folder.mkdir(exist_ok=True)
    if (folder / "run" / NAME).exists() and len(ls.open_run(folder / "run").missing) <= FEW:
        # A command that is done before the signal comes says nothing of it.
        shutil.rmtree(folder / "run")
    ours, theirs = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(ours)
        child(phase, theirs, folder)
    os.close(theirs)
    os.read(ours, 1)
    time.sleep(delay)
    begin = time.perf_counter()
    os.kill(pid, number)
    _, status = os.waitpid(pid, 0)
    taken = time.perf_counter() - begin
    os.close(ours)
    found: dict[str, Any] = {"phase": phase, "signal": number.name, "taken": taken,
                             "code": os.waitstatus_to_exitcode(status)}  # fmt: skip
    if phase == "plot":
        found["left"] = [path.name for path in folder.iterdir()]
    else:
        run = folder / "run"
        found["faults"] = len(verify(run).faults)
        found["partials"] = len(partials(run))
        found["chunks"] = ls.open_run(run).state.done_count
    return found


def main(root: Path, count: int) -> None:
    # In the background of a shell Ctrl-C would be ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    chance = random.Random(3)  # noqa: S311 - moments, not secrets
    for phase in ("kernel", "write"):
        for number in SIGNALS:
            # On a busy machine no chunk may be done yet when the first signals come, and these
            # should find some that they could damage.
            folder, delay = root / f"{phase}-{number.name}", 0.2
            while not one(phase, signal.SIGTERM, folder, delay)["chunks"]:
                delay *= 2.0
    # Turns outside, so that a part of them says something of all.
    for turn in range(count):
        for phase in PHASES:
            for number in SIGNALS:
                folder = root / f"{phase}-{number.name}"
                found = one(phase, number, folder, chance.uniform(0.0, 0.2))
                sys.stdout.write(json.dumps({"turn": turn, **found}) + "\n")
                sys.stdout.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
