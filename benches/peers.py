"""locosweep beside what its users would write instead, in one process, in turn.

Run with ``--quick`` for a look in half a minute; only NumPy is required.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from common.machine import describe
from common.record import json_option, write
from common.table import table

# The folder of the same name, which goes before this file.
from peers import memory, report, targets, with_locosweep, with_numpy
from peers.measure import Row, measure
from peers.work import CLOSED, FRESH, REUSED, SEARCH, Array, Axes, dense_axes, design_axes

_QUICK_SCALE, _ROUNDS, _QUICK_ROUNDS = 0.02, 7, 3
_HUGE_PAGES = Path("/sys/kernel/mm/transparent_hugepage/enabled")


def load_peers(quick: bool) -> list[ModuleType]:
    """Return the peers that are installed; say which are not."""
    found = []
    for name in ("numexpr", "numba", "jax"):
        if quick and name == "jax":
            print("jax: skipped, too slow to start for --quick")
            continue
        try:
            found.append(importlib.import_module(f"peers.with_{name}"))
        except ModuleNotFoundError as error:
            if error.name != name:
                raise
            print(f"{name}: skipped, not installed")
    return found


def machine(peers: list[ModuleType], scale: float, rounds: int) -> dict[str, Any]:
    """Describe what the numbers hold for."""
    pages = _HUGE_PAGES.read_text() if _HUGE_PAGES.exists() else "[unknown]"
    names = [peer.__name__.removeprefix("peers.with_") for peer in peers]
    known = describe(["locosweep", "numpy", *names])
    known["huge_pages"] = pages.split("[")[1].split("]")[0]
    return known | {"scale": scale, "rounds": rounds}


def run(
    scale: float, rounds: int, peers: list[ModuleType], tell: Callable[[str], None]
) -> dict[str, list[Row]]:
    """Measure all groups."""
    work: list[tuple[str, Axes, Callable[[Axes], Array]]] = [
        (REUSED, dense_axes(scale), with_numpy.dense),
        (FRESH, dense_axes(scale), with_numpy.dense),
        (SEARCH, design_axes(scale), with_numpy.search_all),
        (CLOSED, design_axes(5 * scale), with_numpy.search_all),
    ]
    groups = {}
    compiled = any(peer.__name__.endswith("numba") for peer in peers)
    for group, axes, reference in work:
        expected = reference(axes)
        out = np.empty(axes.shape)
        variants = with_locosweep.variants(group, axes, out)
        variants += with_numpy.variants(group, axes, out)
        for peer in peers:
            variants += peer.variants(group, axes, out)
        if not compiled and group != SEARCH:
            variants += with_numpy.fills(group, axes, out)
        groups[group] = measure(group, variants, expected, out, rounds, tell)
    return groups


def main() -> None:
    """Parse the command line, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="small arrays, few rounds, no jax")
    parser.add_argument("--scale", type=float, help="share of the full arrays (default 1)")
    parser.add_argument("--rounds", type=int, help=f"runs of each variant (default {_ROUNDS})")
    json_option(parser)
    given = parser.parse_args()
    scale = given.scale or (_QUICK_SCALE if given.quick else 1.0)
    rounds = given.rounds or (_QUICK_ROUNDS if given.quick else _ROUNDS)

    def tell(text: str) -> None:
        if sys.stderr.isatty():
            print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)

    # First, as it needs a machine with free memory.
    needed = memory.measure(scale)
    peers = load_peers(given.quick)
    about = machine(peers, scale, rounds)
    groups = run(scale, rounds, peers, tell)
    tell("")
    found = targets.judge(report.times_of(groups), needed, scale)
    print(", ".join(f"{name} {value}" for name, value in about.items()))
    for group, rows in groups.items():
        print(f"\n{group}\n")
        print(table(report.cells(group, rows)))
    print()
    for lines in (report.scaling(groups), report.verdicts(found)):
        print(table(lines) + "\n")
    write(given.json, report.record(about, groups, needed, found))


if __name__ == "__main__":
    main()
