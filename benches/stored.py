"""Sweeps larger than memory: run folders beside the disk, and virtual grids beside a sweep.

``--quick`` takes a twentieth of the cells; its times say little.
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
    "import resource, sys; from locosweep.cli import main; code = main(sys.argv[1:]);"
    "sys.stderr.write(str(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)); sys.exit(code)"
)
_MASSES, _QUICK_MASSES = 120, 6
_PAIRS = 41
OPEN_SECONDS, SLICE_RATIO, PEAK_MB, DISK_SHARE = 0.05, 1.3, 512, 0.8


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


def stored(masses: int) -> dict[str, float]:
    """Return rates and the peak memory of a run of a million cells for each mass."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sweep = [
            "sweep", "mean_velocity", "--axis", "mu_static=0.4:0.8:1000", "--axis",
            "slope_deg=0:5:1000", "--axis", f"mass=0.1:1:{masses}", "--set", "mu_coulomb=0.3",
            "--set", "segments=4", "--out", "run/",
        ]  # fmt: skip
        size = 9 * 10**6 * masses
        before = disk(folder, size)
        peak = 0

        def fill() -> None:
            nonlocal peak
            done = subprocess.run(
                [sys.executable, "-c", _PEAK, *sweep], cwd=folder, check=True, text=True,
                capture_output=True,
            )  # fmt: skip
            peak = int(done.stderr) * 1024

        def command(*words: str) -> None:
            subprocess.run(
                [sys.executable, "-c", _COMMAND, *words], cwd=folder, check=True,
                stdout=subprocess.DEVNULL,
            )  # fmt: skip

        filled = seconds(fill)
        rate = (before + disk(folder, size)) / 2
        again = seconds(lambda: command(*sweep))
        read = seconds(lambda: command("verify", "run"))
    return {
        "disk": rate, "fill": size / filled, "share": size / filled / rate, "resume": again,
        "verify": size / read, "peak_mb": peak / 1e6,
    }  # fmt: skip


def main() -> None:
    """Parse the command line, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="few cells")
    json_option(parser)
    given = parser.parse_args()
    spec = ls.Spec(
        ("mean_velocity",),
        (("mu_static", Span(0.2, 0.9, 10_000)), ("slope_deg", Span(0, 20, 10_000)),
         ("mass", Span(0.1, 1.0, 1000))),
        (("mu_coulomb", 0.3), ("segments", 4.0)),
    )  # fmt: skip
    opened = opening(spec)
    sliced, ratio = slicing(spec)
    run = stored(_QUICK_MASSES if given.quick else _MASSES)
    rows: list[dict[str, Any]] = [
        {"work": "open a virtual grid of 1e11 points", "found": f"{1e3 * opened:.1f} ms",
         "target": "50 ms", "met": opened <= OPEN_SECONDS},
        {"work": "slice of 1000 x 1000 of it", "found": f"{1e3 * sliced:.2f} ms", "target": "-",
         "met": None},
        {"work": "the same in sweeps of that slice", "found": f"{ratio:.2f}", "target": "1.3",
         "met": ratio <= SLICE_RATIO},
        {"work": "run folder, start of the command included",
         "found": f"{run['fill'] / 1e6:.0f} MB/s", "target": "-", "met": None},
        {"work": "plain file on the same disk", "found": f"{run['disk'] / 1e6:.0f} MB/s",
         "target": "-", "met": None},
        {"work": "run folder beside the plain file", "found": f"{run['share']:.2f}",
         "target": "0.8", "met": run["share"] >= DISK_SHARE},
        {"work": "peak memory of the run", "found": f"{run['peak_mb']:.0f} MB", "target": "512 MB",
         "met": run["peak_mb"] <= PEAK_MB},
        {"work": "the same command again, nothing left to do", "found": f"{run['resume']:.1f} s",
         "target": "-", "met": None},
        {"work": "verify", "found": f"{run['verify'] / 1e6:.0f} MB/s", "target": "-", "met": None},
    ]  # fmt: skip
    for row in rows:
        row["met"] = {True: "yes", False: "NO", None: "-"}[row["met"]]
    print(", ".join(f"{name} {value}" for name, value in describe(["locosweep"]).items()))
    heads = ["work", "found", "target", "met"]
    print(table([heads, *([row[key] for key in heads] for row in rows)]))
    write(given.json, {"rows": rows})


if __name__ == "__main__":
    main()
