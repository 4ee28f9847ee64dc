"""Checks the ways of a work against its reference, then takes times in turn."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from dynamics_peers.work import FLOORS, OWN_ALLOWED, Points, Way, spread
from peers.work import Array

# Trajectories that are checked of every way, from the first to the last.
CHECKED = {"W3": 256, "W4": 64, "W5": 4096, "robot": 128, "replay": 96, "bristles": 4}
# Calls that take longer are repeated no more than this often.
_LONG, _FEW = 0.5, 3


@dataclass(frozen=True)
class Row:
    """What one way did."""

    way: Way
    seconds: float
    """Per trajectory, median; processor time of one thread, wall-clock time of several."""
    least: float
    """Per trajectory, fastest run."""
    worst: float
    """Largest relative difference to the reference."""
    typical: float
    """Median of it."""
    own: float | None
    """Difference to the small-step limit of the same model."""


class References:
    """Results of the reference, computed once for each choice of rows."""

    def __init__(
        self, work: str, points: Points, compute: Callable[[str, Points], Array | None]
    ) -> None:
        self.work, self.points, self._compute = work, points, compute
        self._known: dict[int, Array | None] = {}

    def rows(self, count: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
        """Choose rows of a result of ``count``."""
        return spread(count, CHECKED[self.work])

    def expected(self, count: int) -> Array | None:
        """Return the results in these rows; None if nothing installed attains the work."""
        if count not in self._known:
            some = self.points.some(count).take(self.rows(count))
            self._known[count] = self._compute(self.work, some)
        return self._known[count]


def differences(work: str, actual: Array, expected: Array) -> Array:
    """Return the relative difference of every trajectory; NaN counts as infinite."""
    scale = np.maximum(np.abs(expected), FLOORS[work])
    off: Array = np.nan_to_num(np.abs(actual - expected) / scale, nan=np.inf)
    worst: Array = off.max(axis=1)
    return worst


def check(way: Way, references: References) -> tuple[float, float, float | None]:
    """Run once, which compiles where that is needed, and compare."""
    expected = references.expected(way.points)
    assert expected is not None
    with way.around():
        actual = np.asarray(way.call())
    if actual.shape != (way.points, expected.shape[1]):
        raise SystemExit(f"{way.label}: shape {actual.shape} for {way.points} trajectories")
    found = differences(references.work, actual[references.rows(way.points)], expected)
    worst, typical = float(found.max()), float(np.median(found))
    if way.allowed is not None and not worst <= way.allowed:
        raise SystemExit(f"{way.label} differs by {worst:.1e}, allowed is {way.allowed:.0e}")
    own = way.own() if way.own else None
    if own is not None and not own <= OWN_ALLOWED:
        raise SystemExit(f"{way.label} is {own:.1e} off the limit of small steps")
    return worst, typical, own


def measure(
    ways: list[Way], references: References, rounds: int, tell: Callable[[str], None]
) -> list[Row]:
    """Check all ways, then time them in turn: A B C A B C ..."""
    found = []
    for way in ways:
        found.append(check(way, references))
        tell(f"{references.work}: {way.label}, {way.threads} checked")
    times: list[list[float]] = [[] for _ in ways]
    gc.disable()
    for turn in range(rounds):
        tell(f"{references.work}: round {turn + 1} of {rounds}")
        for way, taken in zip(ways, times, strict=True):
            if len(taken) < _FEW or min(taken) < _LONG:
                taken.append(_time(way))
    gc.enable()
    return [
        Row(way, statistics.median(taken) / way.points, min(taken) / way.points, *compared)
        for way, taken, compared in zip(ways, times, found, strict=True)
    ]


def _time(way: Way) -> float:
    # What else runs on the machine takes turns with a single thread, which its processor time
    # does not contain. Several threads are about waiting for each other too.
    clock = time.process_time if way.threads == 1 else time.perf_counter
    with way.around():
        # Threads of the one before may still be spinning.
        time.sleep(0.02)
        start = clock()
        way.call()
        return clock() - start
