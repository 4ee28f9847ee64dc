"""Kills and failing calls at every step of a commit, each in a process of its own.

Runs as a program: processes are forked from it, which imports once and computes nothing, so
that two hundred of them take seconds. Prints what became of each as JSON lines.
"""

from __future__ import annotations

import errno
import json
import os
import random
import signal
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import zarr  # noqa: F401 - imported once, before forks
from run_cases import CLOSED, data_files, partials

import locosweep as ls
from locosweep.run_folder.faults import STEPS
from locosweep.run_folder.verify import verify

if TYPE_CHECKING:
    from collections.abc import Callable

SPEC: dict[str, Any] = {**CLOSED, "quantity": "mean_velocity", "chunk": 50, "threads": 1}


def forked(job: Callable[[], object], moment: Callable[[], bool] | None = None) -> tuple[int, Any]:
    """Run a job in a process of its own, which is killed as soon as its moment has come.

    Return the signal that ended it and what it returned.
    """
    ours, theirs = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(ours)
        try:
            answer = {"value": job()}
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {error}"}
        os.write(theirs, json.dumps(answer).encode())
        os._exit(0)
    os.close(theirs)
    if moment is not None:
        while not (moment() or ended(pid)):
            pass
        os.kill(pid, signal.SIGKILL)
    with os.fdopen(ours, "rb") as pipe:
        text = pipe.read()
    _, status = os.waitpid(pid, 0)
    return os.WTERMSIG(status), json.loads(text) if text else None


def ended(pid: int) -> bool:
    """Whether a process of ours has come to its end; it can still be waited for."""
    return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


def once_there_are(files: int, folder: Path, wait: float) -> Callable[[], bool]:
    """Return whether a folder has had so many files for so many seconds.

    Moments are told by files, as a run writes the same ones on each machine and under any load;
    its time differs from run to run.
    """
    since: list[float] = []

    def moment() -> bool:
        if not since and sum(1 for path in folder.rglob("*") if path.is_file()) >= files:
            since.append(time.perf_counter())
        return bool(since) and time.perf_counter() - since[0] >= wait

    return moment


def fill(folder: Path, fault: str | None = None) -> Callable[[], object]:
    """Return a job that sweeps into a folder."""

    def job() -> object:
        if fault is not None:
            os.environ["LOCOSWEEP_FAULT"] = fault
        return ls.sweep(**SPEC, out=folder).complete

    return job


def state(folder: Path, wanted: dict[str, str]) -> dict[str, Any]:
    """What a folder is like now, beside the files that it should have."""
    there = data_files(folder) if folder.exists() else {}
    return {
        "wrong": [name for name, digest in there.items() if wanted.get(name) != digest],
        "files": len(there),
        "partials": partials(folder) if folder.exists() else [],
    }


def resumed(folder: Path, wanted: dict[str, str]) -> dict[str, Any]:
    """Resume a folder and return what it is like then."""
    _, done = forked(fill(folder))
    _, faults = forked(lambda: len(verify(folder).faults))
    return {"done": done, "faults": faults, "whole": data_files(folder) == wanted,
            "after": state(folder, wanted)}  # fmt: skip


def say(**record: object) -> None:
    sys.stdout.write(json.dumps(record) + "\n")


def at_every_step(root: Path, wanted: dict[str, str], action: str, most: int) -> None:
    """Fail or die at the n-th time of each step, until there are no more times."""
    for step in STEPS:
        for turn in range(1, most + 1):
            folder = root / f"{action}-{step}-{turn}"
            killed_by, answer = forked(fill(folder, f"{action}@{step}:{turn}"))
            if killed_by == 0 and answer == {"value": True}:
                break
            say(at=f"{step}:{turn}", ended=killed_by, answer=answer, before=state(folder, wanted),
                **resumed(folder, wanted))  # fmt: skip


def main(mode: str, root: Path, most: int) -> None:
    forked(fill(root / "whole"))
    wanted = data_files(root / "whole")
    say(files=len(wanted))
    if mode == "kill":
        at_every_step(root, wanted, "kill", most)
    elif mode == "random":
        chance = random.Random(7)  # noqa: S311 - moments, not secrets
        begin = time.perf_counter()
        forked(fill(root / "timed"))
        taken = time.perf_counter() - begin
        for turn in range(most):
            folder = root / f"random-{turn}"
            files, wait = chance.randrange(len(wanted)), chance.uniform(0.0, taken / len(wanted))
            killed_by, answer = forked(fill(folder), once_there_are(files, folder, wait))
            say(at=f"{files} files", ended=killed_by, answer=answer, before=state(folder, wanted),
                **resumed(folder, wanted))  # fmt: skip
    else:
        at_every_step(root, wanted, str(getattr(errno, mode)), most)


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]))
