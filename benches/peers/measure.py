"""Checks results against each other, then takes times in turn."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from peers.work import Array, Variant

# Cancellation close to where a robot just moves; elsewhere it is some 1e-16.
_ALLOWED = 1e-7
# Calls that take longer are repeated no more than this often.
_LONG, _FEW = 0.5, 3


@dataclass(frozen=True)
class Row:
    """What one variant did."""

    variant: Variant
    ns: float
    """Per point, median."""
    least: float
    """Per point, fastest run."""
    difference: float | None
    """Largest relative difference to NumPy; None for a limit."""
    other_nans: int
    """Cells where only one of both is NaN."""


def compare(actual: Array, expected: Array) -> tuple[float, int]:
    """Return the largest relative difference and the number of unequal NaN cells."""
    worst, other = 0.0, 0
    for a, b in zip(actual, expected, strict=True):
        works = ~np.isnan(b)
        other += int(np.count_nonzero(np.isnan(a) == works))
        with np.errstate(invalid="ignore"):
            worst = max(worst, float(np.max(np.abs(a - b) / np.abs(b), where=works, initial=0.0)))
    return worst, other


def check(variant: Variant, expected: Array, out: Array) -> tuple[float | None, int]:
    """Run once, which compiles where that is needed, and compare."""
    out.fill(-1.0)
    with variant.around():
        actual = np.asarray(variant.call())
    if variant.kind == "limit":
        return None, 0
    rows = max(1, round(variant.share * expected.shape[0]))
    if actual.shape != expected[:rows].shape:
        raise SystemExit(f"{variant.label}: shape {actual.shape}, not {expected[:rows].shape}")
    difference, other = compare(actual, expected[:rows])
    if other or not difference <= _ALLOWED:
        raise SystemExit(
            f"{variant.label} differs by {difference:.1e}, {other} cells are NaN on one side only"
        )
    return difference, other


def measure(
    group: str,
    variants: list[Variant],
    expected: Array,
    out: Array,
    rounds: int,
    tell: Callable[[str], Any],
) -> list[Row]:
    """Check all variants, then time them in turn: A B C A B C ..."""
    found = []
    for variant in variants:
        found.append(check(variant, expected, out))
        tell(f"{group}: {variant.label}, {variant.threads} checked")
    times: list[list[float]] = [[] for _ in variants]
    gc.disable()
    for turn in range(rounds):
        tell(f"{group}: round {turn + 1} of {rounds}")
        for variant, taken in zip(variants, times, strict=True):
            if len(taken) >= _FEW and min(taken) > _LONG:
                continue
            taken.append(_time(variant))
    gc.enable()
    rows = []
    for variant, taken, (difference, other) in zip(variants, times, found, strict=True):
        points = max(1, round(variant.share * expected.shape[0])) * expected[0].size
        median, least = (1e9 * t / points for t in (statistics.median(taken), min(taken)))
        rows.append(Row(variant, median, least, difference, other))
    return rows


def _time(variant: Variant) -> float:
    with variant.around():
        # Threads of the one before may still be spinning.
        time.sleep(0.02)
        start = time.perf_counter()
        result = variant.call()
        taken = time.perf_counter() - start
    # Returning the memory is part of no variant.
    del result
    return taken
