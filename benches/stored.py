"""Sweeps larger than memory: run folders beside the disk, virtual grids beside a sweep, Dask.

``--quick`` takes a twentieth of the cells; its times say little. ``--only`` takes some parts.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import locosweep as ls
from common.machine import describe
from common.record import json_option, write
from common.table import table
from locosweep.specs.span import Span

_COMMAND = "import sys; sys.argv[0] = 'locosweep'; from locosweep.cli import main; sys.exit(main())"
_PEAK = (
    "import sys; from locosweep.cli import main; code = main(sys.argv[1:])\n"
    # Not ru_maxrss, which a process inherits from the one that started it.
    "peak = next(line for line in open('/proc/self/status') if line.startswith('VmHWM'))\n"
    "sys.stderr.write(peak.split()[1]); sys.exit(code)"
)
_MASSES = 120
_PAIRS = 41
_TRAJECTORIES, _ROBOTS, _CHUNKS = 10**7, 10**5, 110_592
_QUICK = 20
"""Of so many cells, trajectories, robots and chunks a quick run takes one."""
OPEN_SECONDS, SLICE_RATIO, PEAK_MB, DISK_SHARE = 0.05, 1.3, 512, 0.8
DASK_SHARE, STATUS_SECONDS = 0.9, 2.0
Rows = list[dict[str, Any]]


def seconds(job: Callable[[], object]) -> float:
    """Return how long a job takes."""
    begin = time.perf_counter()
    job()
    return time.perf_counter() - begin


def opening(spec: ls.Spec) -> float:
    """Return the median time in which a virtual grid opens, imports aside."""
    ls.open_grid(spec)
    return statistics.median(seconds(lambda: ls.open_grid(spec)) for _ in range(_PAIRS))


def slicing(spec: ls.Spec) -> tuple[float, float]:
    """Return the time of a slice of 1000 x 1000 and its ratio to the sweep of that slice.

    Turn by turn, so that what else the machine does falls on both.
    """
    values = ls.open_grid(spec)["mean_velocity"]
    part = values[2000:3000, 4000:5000, 500]
    fixed = {name: float(value) for name, value in spec.fixed}
    grid = ls.Grid(
        mu_static=part.mu_static.to_numpy(), slope_deg=part.slope_deg.to_numpy(),
        mass=float(part.mass), **fixed,
    )  # fmt: skip
    ours, theirs = [], []
    for _ in range(_PAIRS):
        ours.append(seconds(lambda: values[2000:3000, 4000:5000, 500].to_numpy()))
        theirs.append(seconds(lambda: ls.sweep("mean_velocity", grid)))
    return min(ours), min(ours) / min(theirs)


def disk(folder: Path, size: int) -> float:
    """Return the bytes per second of one file written in order and brought to the disk."""
    piece = np.random.default_rng(1).bytes(4 << 20)

    def job() -> None:
        with (folder / "plain").open("wb", buffering=0) as file:
            for _ in range(max(size // len(piece), 1)):
                file.write(piece)
            os.fsync(file.fileno())

    taken = seconds(job)
    (folder / "plain").unlink()
    return max(size // len(piece), 1) * len(piece) / taken


def command(folder: Path, *words: str, code: str = _COMMAND) -> str:
    """Run a command in a folder, return what it wrote to standard error."""
    done = subprocess.run(
        [sys.executable, "-c", code, *words], cwd=folder, check=False, text=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip
    if done.returncode:
        sys.exit(done.stderr)
    return done.stderr


def row(work: str, found: str, target: str = "-", met: bool | None = None) -> dict[str, Any]:
    """Return a row of the table."""
    return {"work": work, "found": found, "target": target,
            "met": {True: "yes", False: "NO", None: "-"}[met]}  # fmt: skip


def peak_row(work: str, err: str) -> dict[str, Any]:
    """Return the row of a command's peak memory, which it wrote as its last words, in kB."""
    peak = int(err) * 1024 / 1e6
    return row(work, f"{peak:.0f} MB", f"{PEAK_MB} MB", peak <= PEAK_MB)


def grids(_: int) -> Rows:
    """Measure virtual grids."""
    spec = ls.Spec(
        ("mean_velocity",),
        (("mu_static", Span(0.2, 0.9, 10_000)), ("slope_deg", Span(0, 20, 10_000)),
         ("mass", Span(0.1, 1.0, 1000))),
        (("mu_coulomb", 0.3), ("segments", 4.0)),
    )  # fmt: skip
    opened = opening(spec)
    sliced, ratio = slicing(spec)
    return [
        row("open a virtual grid of 1e11 points", f"{1e3 * opened:.1f} ms", "50 ms",
            opened <= OPEN_SECONDS),
        row("slice of 1000 x 1000 of it", f"{1e3 * sliced:.2f} ms"),
        row("the same in sweeps of that slice", f"{ratio:.2f}", "1.3", ratio <= SLICE_RATIO),
    ]  # fmt: skip


def closed(part: int) -> Rows:
    """Measure a run of a million closed-form cells for each mass beside a plain file."""
    masses = _MASSES // part
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sweep = [
            "sweep", "mean_velocity", "--axis", "mu_static=0.4:0.8:1000", "--axis",
            "slope_deg=0:5:1000", "--axis", f"mass=0.1:1:{masses}", "--set", "mu_coulomb=0.3",
            "--set", "segments=4", "--out", "run/", "--progress", "none",
        ]  # fmt: skip
        size = 9 * 10**6 * masses
        before = disk(folder, size)
        err = []
        filled = seconds(lambda: err.append(command(folder, *sweep, code=_PEAK)))
        rate = (before + disk(folder, size)) / 2
        again = seconds(lambda: command(folder, *sweep))
        read = seconds(lambda: command(folder, "verify", "run"))
    share = size / filled / rate
    return [
        row("run folder, start of the command included", f"{size / filled / 1e6:.0f} MB/s"),
        row("plain file on the same disk", f"{rate / 1e6:.0f} MB/s"),
        row("run folder beside the plain file", f"{share:.2f}", "0.8", share >= DISK_SHARE),
        peak_row("peak memory of the run", *err),
        row("the same command again, nothing left to do", f"{again:.1f} s"),
        row("verify", f"{size / read / 1e6:.0f} MB/s"),
    ]


def trajectories(part: int) -> Rows:
    """Measure ten million exact trajectories of a segment, streamed to a folder."""
    length = round((_TRAJECTORIES / part) ** 0.5)
    with tempfile.TemporaryDirectory() as name:
        sweep = [
            "sweep", "final_position", "--axis", f"mu_coulomb=0.1:0.5:{length}", "--axis",
            f"drive_amplitude=0.5:3:{length}", "--drive", "pulse", "--set", "drive_period=0.5",
            "--set", "viscous=0.2", "--set", "duration=1",
            "--out", "run/", "--progress", "none",
        ]  # fmt: skip
        err = []
        taken = seconds(lambda: err.append(command(Path(name), *sweep, code=_PEAK)))
    return [
        row(f"{length**2:.3g} trajectories to a run folder", f"{taken:.1f} s"),
        peak_row("peak memory of these", *err),
    ]


def dask(part: int) -> Rows:
    """Measure two Dask workers of one thread beside two threads, on robots with elastic joints."""
    from distributed import Client, LocalCluster

    length = round((_ROBOTS / part) ** 0.5)
    robots: dict[str, Any] = {
        "mu_static": np.linspace(0.3, 0.8, length), "mass": np.linspace(0.1, 1.0, length),
        "mu_coulomb": 0.25, "segments": 4,
        "joint_stiffness": 2e3, "joint_damping": 20.0, "speed_limit": 0.1,
    }  # fmt: skip
    with (
        tempfile.TemporaryDirectory() as name,
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        folder = Path(name)

        def sweep(out: str, **how: Any) -> None:
            ls.sweep("gait_advance", ls.Grid(**robots), out=folder / out, chunk=2500, **how)

        sweep("first", client=client)
        ours, theirs = [], []
        for turn in range(3):
            theirs.append(seconds(lambda turn=turn: sweep(f"threads{turn}", threads=2)))
            ours.append(seconds(lambda turn=turn: sweep(f"dask{turn}", client=client)))
    share = statistics.median(theirs) / statistics.median(ours)
    return [
        row(f"{length**2:.3g} robots on two threads", f"{statistics.median(theirs):.1f} s"),
        row("rate of two Dask workers beside two threads", f"{share:.2f}", "0.9",
            share >= DASK_SHARE),
    ]  # fmt: skip


def many(part: int) -> Rows:
    """Measure a run of a hundred thousand chunks: opening it, and telling its status."""
    length = round((_CHUNKS / part) ** (1 / 3))
    axes = {"mu_static": np.linspace(0.3, 0.8, length), "slope_deg": np.linspace(0, 10, length),
            "mass": np.linspace(0.1, 1.0, length)}  # fmt: skip
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "run"
        grid = ls.Grid(**axes, mu_coulomb=0.3, segments=4)
        begin = time.process_time()
        ls.sweep("mean_velocity", grid, out=folder, chunk=1)
        each = (time.process_time() - begin) / length**3
        opened = min(seconds(lambda: ls.open_run(folder)) for _ in range(5))
        told = min(seconds(lambda: command(folder.parent, "status", "run")) for _ in range(5))
    return [
        row("processor time a chunk of one cell", f"{1e3 * each:.1f} ms"),
        row(f"open a run of {length**3} chunks", f"{opened:.1f} s", "2 s",
            opened <= STATUS_SECONDS),
        row("status of it, start of the command included", f"{told:.1f} s", "2 s",
            told <= STATUS_SECONDS),
    ]  # fmt: skip


PARTS: dict[str, Callable[[int], Rows]] = {
    "grids": grids, "closed": closed, "trajectories": trajectories, "dask": dask, "many": many,
}  # fmt: skip


def main() -> None:
    """Parse the command line, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="few cells")
    parser.add_argument("--only", default=",".join(PARTS), help="parts, with commas between")
    json_option(parser)
    given = parser.parse_args()
    parts = given.only.split(",")
    if unknown := set(parts) - PARTS.keys():
        parser.error(f"--only: no part {min(unknown)}: there are {', '.join(PARTS)}")
    part = _QUICK if given.quick else 1
    rows = [one for name in parts for one in PARTS[name](part)]
    print(", ".join(f"{name} {value}" for name, value in describe(["locosweep"]).items()))
    heads = ["work", "found", "target", "met"]
    print(table([heads, *([one[key] for key in heads] for one in rows)]))
    write(given.json, {"rows": rows})


if __name__ == "__main__":
    main()
