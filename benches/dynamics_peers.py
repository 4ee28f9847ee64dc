"""Dynamics in what users would pick instead of locosweep, in one process, in turn.

``--quick`` only checks that all agree, within what each is allowed, and shows no times: it takes
less than two minutes, and needs no peer but NumPy and SciPy.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Callable
from types import ModuleType

from common.machine import describe
from common.record import json_option, write
from common.table import table

# The folder of the same name, which goes before this file.
from dynamics_peers import battery, limits, memory, report, targets, with_numpy
from dynamics_peers.measure import References, Row, measure
from dynamics_peers.replays import KINDS, Bristles
from dynamics_peers.work import LEAST, POINTS, TITLES, WORKS, LuGre, Points
from peers.work import Array

_QUICK_SCALE, _ROUNDS, _QUICK_ROUNDS = 0.002, 5, 1
_PEERS = ("scipy", "numba", "jax", "diffrax", "heyoka", "mujoco")
# Comes with numba, and is imported first.
_UNDERNEATH = ("llvmlite",)
# These take longer to start or compile than a quick run may.
_SLOW = ("jax", "diffrax")


def load_peers(quick: bool) -> dict[str, ModuleType]:
    """Return ours, NumPy, and the peers that can be had; say why others cannot."""
    found = {}
    for name in ("locosweep", "numpy", *_PEERS):
        if quick and name in _SLOW:
            print(f"{name}: skipped, too slow to start for --quick")
            continue
        try:
            found[name] = importlib.import_module(f"dynamics_peers.with_{name}")
        # A library that is there but does not fit the system raises other errors too.
        except (ImportError, OSError) as error:
            missing = (getattr(error, "name", None) or "").split(".")[0]
            if missing not in (name, *_PEERS, *_UNDERNEATH):
                raise
            what = "not installed" if isinstance(error, ModuleNotFoundError) else f"{error}"
            print(f"{name}: skipped, {missing} {what}")
    return found


def reference(peers: dict[str, ModuleType]) -> Callable[[str, Points], Array | None]:
    """Return what computes the results that all others are checked against."""

    def compute(work: str, points: Points) -> Array | None:
        if isinstance(points, LuGre | Bristles):
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
        points = KINDS[work].draw(max(LEAST[work], round(POINTS[work] * scale)))
        references = References(work, points, reference(peers))
        ways = [way for peer in peers.values() for way in peer.ways(work, points)]
        groups[work] = measure(ways, references, rounds, tell)
    return groups


def main() -> None:
    """Parse the command line, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="few points, no times, no jax")
    parser.add_argument("--scale", type=float, help="share of the points (default 1)")
    parser.add_argument("--rounds", type=int, help=f"runs of each way (default {_ROUNDS})")
    parser.add_argument("--only", metavar="W3,robot", help=f"some of {','.join(WORKS)}")
    json_option(parser)
    given = parser.parse_args()
    scale = given.scale or (_QUICK_SCALE if given.quick else 1.0)
    rounds = given.rounds or (_QUICK_ROUNDS if given.quick else _ROUNDS)
    works = given.only.split(",") if given.only else list(WORKS)
    if unknown := [work for work in works if work not in WORKS]:
        parser.error(f"no work {unknown[0]!r}; there are {', '.join(WORKS)}")

    def tell(text: str) -> None:
        if sys.stderr.isatty():
            print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)

    # First, as it needs a machine with free memory.
    held = memory.measure(given.quick)
    peers = load_peers(given.quick)
    about = describe(peers) | {"scale": scale, "rounds": rounds}
    groups = run(works, scale, rounds, peers, tell)
    rates = battery.measure(rounds, tell)
    tell("")
    print(", ".join(f"{name} {value}" for name, value in about.items()))
    for work, rows in groups.items():
        print(f"\n{TITLES[work]}\n")
        lines = report.agreement(rows) if given.quick else report.cells(work, rows)
        print(table(lines))
        for line in report.notes(rows):
            print(f"\n{line}")
    if over := [one for one in held if one.beside_mb > memory.LIMIT_MB]:
        raise SystemExit(f"an ensemble takes {over[0].beside_mb:.0f} MB beside its result")
    if given.quick:
        print(f"\n{len(rates)} effects replayed; memory beside results within bounds")
        return
    limit = limits.measure(rounds)
    found = targets.judge(groups, limit, str(about["simd"]), scale)
    found += [*targets.rates(rates, limit), *targets.memory(held)]
    print("\neffects: 6 runs x 2000 samples, finite differences, 1 thread\n")
    print(table(battery.cells(rates)))
    print("\nall in one: per trajectory and core\n")
    print(table(targets.cells(found)))
    print(f"\n{targets.limits_note(limit)}")
    write(given.json, report.record(about, groups, rates, held, found))


if __name__ == "__main__":
    main()
