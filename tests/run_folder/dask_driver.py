"""A run that the processes of a real Dask cluster fill; prints what became of it as JSON.

A program of its own, so that the cluster's warnings and processes stay with it.
"""

from __future__ import annotations

import json
import logging
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

from distributed import Client, LocalCluster
from run_cases import CLOSED, data_files, same

import locosweep as ls
from locosweep.run_folder.overview import overview
from locosweep.run_folder.verify import verify

# The tolerance makes each cell slow: a worker has to be killed before all is done.
SPEC: dict[str, Any] = {
    "quantity": "final_position", "mu_static": [0.3 + 0.002 * i for i in range(120)],
    "drive_amplitude": [0.5 + 0.05 * i for i in range(30)], "mu_coulomb": 0.3, "law": "lugre",
    "drive": "sine", "tolerance": 1e-10,
}  # fmt: skip


def kill_when_written(folder: Path, victims: list[int], chunks: int) -> None:
    """End processes at once when so many chunks are there."""
    while len(list(folder.glob("data.zarr/final_position/c.*"))) < chunks:
        time.sleep(0.01)
    for pid in victims:
        os.kill(pid, signal.SIGKILL)


def pids(client: Any) -> list[int]:
    return list(client.run(os.getpid).values())


def fill(client: Any, folder: Path) -> dict[str, Any]:
    told: list[tuple[int, int]] = []
    run = ls.sweep(**CLOSED, chunk=12, out=folder, client=client,
                   progress=lambda done, total, _: told.append((done, total)))  # fmt: skip
    ls.sweep(**CLOSED, chunk=12, out=folder.with_name("one"))
    return {
        "same": same(run, ls.sweep(**CLOSED)),
        "files": data_files(folder) == data_files(folder.with_name("one")),
        "told": told[-1], "steps": len(told), "chunks": run.manifest.plan.count,
        "writers": [w.chunks for w in overview(folder).writers],
    }  # fmt: skip


def kill_one(client: Any, folder: Path) -> dict[str, Any]:
    victim = pids(client)[0]
    killer = threading.Thread(target=kill_when_written, args=(folder, [victim], 5))
    killer.start()
    run = ls.sweep(**SPEC, chunk=60, out=folder, client=client)
    killer.join()
    return {"same": same(run, ls.sweep(**SPEC)), "faults": len(verify(folder).faults),
            "writers": [w.chunks for w in overview(folder).writers],
            "gone": victim not in pids(client)}  # fmt: skip


def other_run(client: Any, folder: Path) -> dict[str, Any]:
    """A worker that cannot write: the message says so, and the rest is kept."""
    ls.sweep(**CLOSED, chunk=12, out=folder)
    for log in (folder / "log").iterdir():
        log.unlink()
    victim = folder / "data.zarr" / "mean_velocity"
    for path in victim.glob("c.*"):
        path.unlink()
        path.mkdir()
    try:
        ls.sweep(**CLOSED, out=folder, client=client)
    except ls.InputError as error:
        return {"error": str(error)}
    return {"error": None}


def again(client: Any, folder: Path) -> dict[str, Any]:
    """Another run under the name of one that is gone, by workers that knew that one."""
    ls.sweep(**CLOSED, chunk=12, out=folder, client=client)
    shutil.rmtree(folder)
    run = ls.sweep(**CLOSED, chunk=30, out=folder, client=client)
    return {"complete": run.complete, "same": same(run, ls.sweep(**CLOSED)),
            "faults": len(verify(folder).faults)}  # fmt: skip


def command(client: Any, folder: Path) -> dict[str, Any]:
    folder.parent.joinpath("s.toml").write_text(
        'format = "locosweep.sweep/1"\nquantities = ["mean_velocity"]\n[axes]\n'
        "segments = {from = 2, to = 20}\n[fixed]\nmu_static = 0.5\nmu_coulomb = 0.3\n"
    )
    address = client.scheduler.address
    done = subprocess.run(
        [sys.executable, "-m", "locosweep", "sweep", "s.toml", "--out", "run/", "--chunk", "3",
         "--dask", address],
        cwd=folder.parent, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    return {"code": done.returncode, "out": done.stdout, "err": done.stderr,
            "complete": ls.open_run(folder).complete}  # fmt: skip


def main(mode: str, folder: Path) -> None:
    # Each worker that ends is told of at length.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with (
        LocalCluster(
            n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        Client(cluster) as client,
    ):
        jobs = {
            "fill": fill,
            "kill": kill_one,
            "fail": other_run,
            "command": command,
            "again": again,
        }
        sys.stdout.write(json.dumps(jobs[mode](client, folder)) + "\n")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
