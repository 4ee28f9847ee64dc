"""Dynamics in what users would pick instead of locosweep, in one process, in turn.

Run with ``--quick`` for a look in 20 seconds; only NumPy is required.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.metadata
import json
import os
import platform
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

# The folder of the same name, which goes before this file.
from dynamics_peers import report, with_numpy
from dynamics_peers.measure import References, Row, measure
from dynamics_peers.work import KINDS, LEAST, LUGRE, POINTS, TITLES, WORKS, LuGre, Points
from peers.report import table
from peers.work import Array

_QUICK_SCALE, _ROUNDS, _QUICK_ROUNDS = 0.002, 5, 1
_PEERS = ("scipy", "numba", "jax", "diffrax", "heyoka", "mujoco")
# Comes with numba, and is imported first.
_UNDERNEATH = ("llvmlite",)
# These take longer to start or compile than a quick run may.
_SLOW = ("jax", "diffrax")


def load_peers(quick: bool) -> dict[str, ModuleType]:
    """Return ours, if it is there, NumPy, and the peers that are installed; say which are not."""
    found = {}
    for name in ("locosweep", "numpy", *_PEERS):
        if quick and name in _SLOW:
            print(f"{name}: skipped, too slow to start for --quick")
            continue
        try:
            found[name] = importlib.import_module(f"dynamics_peers.with_{name}")
        except ModuleNotFoundError as error:
            missing = error.name or ""
            if missing == f"dynamics_peers.with_{name}":
                print(f"{name}: skipped, not written yet")
            elif missing.split(".")[0] in (name, *_PEERS, *_UNDERNEATH):
                print(f"{name}: skipped, {missing} not installed")
            else:
                raise
    return found


def machine(peers: dict[str, ModuleType], scale: float, rounds: int) -> dict[str, Any]:
    """Describe what the numbers hold for."""
    cpu = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        cpu = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    known: dict[str, Any] = {
        "processor": cpu,
        "processors": len(os.sched_getaffinity(0)),
        "load": round(os.getloadavg()[0], 2),
        "python": platform.python_version(),
    }
    known |= {name: importlib.metadata.version(name) for name in peers}
    return known | {"scale": scale, "rounds": rounds}


def reference(peers: dict[str, ModuleType]) -> Callable[[str, Points], Array | None]:
    """Return what computes the results that all others are checked against."""

    def compute(work: str, points: Points) -> Array | None:
        if isinstance(points, LuGre) and "scipy" in peers:
            expected: Array = peers["scipy"].reference(points)
            return expected
        return with_numpy.reference(work, points)

    return compute


def run(
    works: list[str],
    scale: float,
    rounds: int,
    peers: dict[str, ModuleType],
    tell: Callable[[str], None],
) -> dict[str, list[Row]]:
    """Measure some works."""
    groups = {}
    for work in works:
        if work == LUGRE and "scipy" not in peers:
            print(f"{work}: skipped, its reference needs scipy")
            continue
        points = KINDS[work].draw(max(LEAST[work], round(POINTS[work] * scale)))
        references = References(work, points, reference(peers))
        ways = [way for peer in peers.values() for way in peer.ways(work, points)]
        groups[work] = measure(ways, references, rounds, tell)
    return groups


def main() -> None:
    """Parse the command line, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="few points, one round, no jax")
    parser.add_argument("--scale", type=float, help="share of the points (default 1)")
    parser.add_argument("--rounds", type=int, help=f"runs of each way (default {_ROUNDS})")
    parser.add_argument("--only", metavar="W3,robot", help=f"some of {','.join(WORKS)}")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all numbers to FILE")
    parser.add_argument("--markdown", action="store_true", help="print Markdown tables")
    given = parser.parse_args()
    scale = given.scale or (_QUICK_SCALE if given.quick else 1.0)
    rounds = given.rounds or (_QUICK_ROUNDS if given.quick else _ROUNDS)
    works = given.only.split(",") if given.only else list(WORKS)
    if unknown := [work for work in works if work not in WORKS]:
        parser.error(f"no work {unknown[0]!r}; there are {', '.join(WORKS)}")

    def tell(text: str) -> None:
        if sys.stderr.isatty():
            print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)

    peers = load_peers(given.quick)
    about = machine(peers, scale, rounds)
    groups = run(works, scale, rounds, peers, tell)
    tell("")
    print(", ".join(f"{name} {value}" for name, value in about.items()))
    for work, rows in groups.items():
        print(f"\n{'### ' if given.markdown else ''}{TITLES[work]}\n")
        print(table(report.cells(work, rows), given.markdown))
        for line in report.notes(rows):
            print(f"\n{line}")
    if given.json:
        given.json.write_text(json.dumps(report.record(about, groups), indent=2) + "\n")


if __name__ == "__main__":
    main()
