"""numba: loops as users write them, and with everything folded into tables."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numba import njit, prange

from common.threads import numba_threads, thread_counts
from peers.work import (
    CLOSED,
    COUNTS,
    FRESH,
    GRAVITY,
    REUSED,
    SEARCH,
    STROKE,
    Array,
    Axes,
    Variant,
)

# Division by zero gives what it gives in NumPy; with Python's rule it would raise.
compiled = njit(parallel=True, fastmath=False, error_model="numpy")


@compiled
def dense(
    mu_static: Array,
    mu_coulomb: Array,
    cos: Array,
    sin: Array,
    segments: Array,
    gravity: float,
    stroke: float,
    out: Array,
) -> None:
    for i in prange(mu_static.size):
        for j in range(mu_coulomb.size):
            for k in range(cos.size):
                hold = mu_static[i] * cos[k] - sin[k]
                for m in range(segments.size):
                    n = segments[m]
                    a = gravity * ((n - 1) * hold - mu_coulomb[j] * cos[k] - sin[k])
                    if hold > 0 and a > 0:
                        out[i, j, k, m] = math.sqrt(stroke * a / 2) / n
                    else:
                        out[i, j, k, m] = np.nan


@compiled
def dense_folded(
    mu_static: Array,
    mu_coulomb: Array,
    of_static: Array,
    of_coulomb: Array,
    rest: Array,
    out: Array,
) -> None:
    for i in prange(mu_static.size):
        for j in range(mu_coulomb.size):
            row = out[i, j]
            for m in range(rest.size):
                square = mu_static[i] * of_static[m] - mu_coulomb[j] * of_coulomb[m] - rest[m]
                row[m] = math.sqrt(square) if square > 0 else np.nan


@compiled
def search(
    mu_static: Array,
    mu_coulomb: Array,
    cos: Array,
    sin: Array,
    counts: Array,
    gravity: float,
    stroke: float,
    out: Array,
) -> None:
    for i in prange(mu_static.size):
        for j in range(mu_coulomb.size):
            for k in range(cos.size):
                hold = mu_static[i] * cos[k] - sin[k]
                best, at = -np.inf, np.nan
                for m in range(counts.size):
                    n = counts[m]
                    a = gravity * ((n - 1) * hold - mu_coulomb[j] * cos[k] - sin[k])
                    if hold > 0 and a > 0:
                        v = math.sqrt(stroke * a / 2) / n
                        if v > best:
                            best, at = v, n
                out[i, j, k] = at


@compiled
def search_monotone(
    mu_static: Array,
    mu_coulomb: Array,
    cos: Array,
    sin: Array,
    counts: Array,
    per_square: Array,
    out: Array,
) -> None:
    # The velocity's square, up to a factor, has its peak at the same count.
    for i in prange(mu_static.size):
        for j in range(mu_coulomb.size):
            for k in range(cos.size):
                hold = mu_static[i] * cos[k] - sin[k]
                drag = mu_coulomb[j] * cos[k] + sin[k]
                best, at = 0.0, np.nan
                for m in range(counts.size):
                    score = ((counts[m] - 1) * hold - drag) * per_square[m]
                    if score > best:
                        best, at = score, counts[m]
                out[i, j, k] = at


@compiled
def closed(
    mu_static: Array,
    mu_coulomb: Array,
    cos: Array,
    sin: Array,
    least: float,
    most: float,
    out: Array,
) -> None:
    for i in prange(mu_static.size):
        for j in range(mu_coulomb.size):
            for k in range(cos.size):
                hold = mu_static[i] * cos[k] - sin[k]
                drag = mu_coulomb[j] * cos[k] + sin[k]
                low = min(max(math.floor(2 * (hold + drag) / hold), least), most)
                high = min(low + 1, most)
                push_low, push_high = (low - 1) * hold - drag, (high - 1) * hold - drag
                best = high if push_high * low**2 > push_low * high**2 else low
                out[i, j, k] = best if hold > 0 and push_high > 0 else np.nan


@compiled
def fill(flat: Array, value: float) -> None:
    for i in prange(flat.size):
        flat[i] = value


def _folded(axes: Axes) -> tuple[Array, Array, Array]:
    """Factors of mu_static and mu_coulomb, and the rest, over slope and count."""
    cos, sin, n = axes.cos[:, None], axes.sin[:, None], axes.segments
    unit = GRAVITY * STROKE / (2 * n**2)
    tables = (unit * (n - 1) * cos, unit * cos, unit * n * sin)
    return tables[0].ravel(), tables[1].ravel(), tables[2].ravel()


def variants(group: str, axes: Axes, out: Array) -> list[Variant]:
    """List numba's ways to do the work of a group."""
    friction = (axes.mu_static, axes.mu_coulomb)
    slope = (axes.cos, axes.sin)
    physics = (GRAVITY, STROKE)
    empty = partial(np.empty, axes.shape)
    found: list[Variant] = []

    def add(key: str, label: str, work: Callable[[Array], Any], kind: str = "peer") -> None:
        def call() -> Array:
            target = empty() if group == FRESH else out
            work(target)
            return target

        for n in thread_counts():
            found.append(Variant(key, label, n, call, kind, partial(numba_threads, n)))

    if group in (REUSED, FRESH):
        tables = _folded(axes)
        rows = (*axes.shape[:2], -1)
        add("numba", "numba", lambda to: dense(*friction, *slope, axes.segments, *physics, to))
        add(
            "numba.folded",
            "numba, folded into tables",
            lambda to: dense_folded(*friction, *tables, to.reshape(rows)),
        )
    elif group == SEARCH:
        add("numba", "numba", lambda to: search(*friction, *slope, COUNTS, *physics, to))
        add(
            "numba.monotone",
            "numba, without the root",
            lambda to: search_monotone(*friction, *slope, COUNTS, COUNTS**-2.0, to),
        )
    elif group == CLOSED:
        bounds = (COUNTS[0], COUNTS[-1])
        add("numba", "numba", lambda to: closed(*friction, *slope, *bounds, to))
    if group != SEARCH:
        add("fill", "limit: plain fill", lambda to: fill(to.reshape(-1), 1.25), "limit")
    return found
