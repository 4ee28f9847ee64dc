"""What stands between a user and the kernels: one call, an import, a command.

``--quick`` takes fewer repetitions.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import locosweep as ls
from common.record import json_option, write

_HEATMAP = (
    "heatmap mean_velocity --x slope_deg=0:25:500 --y mu_static=0.1:1:500 "
    "--set mu_coulomb=0.3 --best-over segments=2:64"
)
# What the console script does, which is not installed beside a source tree.
_COMMAND = "import sys; sys.argv[0] = 'locosweep'; from locosweep.cli import main; sys.exit(main())"
# The package imports what it needs when it needs it: this takes the same in any case.
_FIRST = (
    "import locosweep as ls; ls.sweep('mean_velocity', mu_static=0.5, mu_coulomb=0.3, segments=4)"
)


@dataclass(frozen=True)
class Line:
    """One measured time, in seconds, with its target."""

    what: str
    median: float
    fastest: float
    target: float | None = None


def repeated(call: Callable[[], object], batches: int, per_batch: int) -> tuple[float, float]:
    """Return median and fastest time of one call over batches of them."""
    call()
    taken = []
    for _ in range(batches):
        start = time.perf_counter()
        for _ in range(per_batch):
            call()
        taken.append((time.perf_counter() - start) / per_batch)
    return statistics.median(taken), min(taken)


def process(arguments: list[str], runs: int) -> tuple[float, float]:
    """Return median and fastest time of a whole Python process, after one to warm up."""
    package = Path(ls.__file__).parent.parent
    paths = [str(package), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(paths)}
    taken = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(runs + 1):
            start = time.perf_counter()
            done = subprocess.run(
                [sys.executable, *arguments],
                cwd=folder,
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
            taken.append(time.perf_counter() - start)
            if done.returncode:
                raise SystemExit(f"{' '.join(arguments)} failed:\n{done.stderr}")
    return statistics.median(taken[1:]), min(taken[1:])


def calls(quick: bool) -> list[Line]:
    """Measure calls that compute next to nothing."""
    batches, size = (5, 200) if quick else (25, 2000)

    def point() -> object:
        return ls.sweep("mean_velocity", mu_static=0.5, mu_coulomb=0.3, segments=4)

    known = ls.Grid(mu_static=0.5, mu_coulomb=0.3, segments=4)

    def point_of_grid() -> object:
        return ls.sweep("mean_velocity", known)

    def grid() -> object:
        return ls.Grid(mu_static=[0.4, 0.5], mu_coulomb=0.3, segments=range(2, 9))

    return [
        Line("one point, by keywords", *repeated(point, batches, size), 50e-6),
        Line("one point, of a grid", *repeated(point_of_grid, batches, size)),
        Line("a grid of two short axes", *repeated(grid, batches, size)),
    ]


def processes(quick: bool) -> list[Line]:
    """Measure whole processes, the interpreter's own start among them."""
    runs = 3 if quick else 9
    found = [
        Line("python -c pass", *process(["-c", "pass"], runs)),
        Line("import numpy", *process(["-c", "import numpy"], runs)),
        Line("import locosweep", *process(["-c", "import locosweep"], runs), 0.25),
        Line("import locosweep, one point", *process(["-c", _FIRST], runs)),
    ]
    if importlib.util.find_spec("locosweep.cli") is None:
        print("locosweep --help, locosweep heatmap: skipped, no locosweep.cli here")
        return found
    command = ["-c", _COMMAND]
    heatmap = process([*command, *_HEATMAP.split()], min(runs, 5))
    return [
        *found,
        Line("locosweep --help", *process([*command, "--help"], runs), 0.15),
        Line("locosweep heatmap, 500 x 500 x 63", *heatmap, 1.5),
    ]


def text(seconds: float) -> str:
    """Write a time in the unit that suits it."""
    if seconds < 1e-3:
        return f"{1e6 * seconds:.1f} us"
    return f"{1e3 * seconds:.0f} ms" if seconds < 1 else f"{seconds:.2f} s"


def main() -> None:
    """Parse the command line, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="fewer repetitions")
    json_option(parser)
    given = parser.parse_args()
    lines = [*calls(given.quick), *processes(given.quick)]
    print(f"{'':36}{'median':>10}{'fastest':>10}{'target':>11}")
    for line in lines:
        target = f"<= {text(line.target)}" if line.target else "-"
        met = "" if line.target is None or line.median <= line.target else "  NOT MET"
        print(f"{line.what:36}{text(line.median):>10}{text(line.fastest):>10}{target:>11}{met}")
    write(given.json, {"lines": [asdict(line) for line in lines]})


if __name__ == "__main__":
    main()
