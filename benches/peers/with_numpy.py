"""NumPy: broadcasting as users write it, and blocks that stay in the caches."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np

from common.threads import thread_counts
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

_SLICE = 0.1
_BLOCK = 1 << 14


def dense(axes: Axes) -> Array:
    """Mean velocity at every point, in whole arrays."""
    mu_static = axes.mu_static[:, None, None, None]
    mu_coulomb = axes.mu_coulomb[:, None, None]
    cos, sin = axes.cos[:, None], axes.sin[:, None]
    n = axes.segments
    hold = mu_static * cos - sin
    acceleration = GRAVITY * ((n - 1) * hold - mu_coulomb * cos - sin)
    with np.errstate(invalid="ignore"):
        velocity = np.sqrt(STROKE * acceleration / 2) / n
    return np.where((hold > 0) & (acceleration > 0), velocity, np.nan)


def dense_blocked(axes: Axes, out: Array) -> Array:
    """Mean velocity in place, in blocks of some columns of the second axis."""
    cos, sin, n = axes.cos, axes.sin, axes.segments
    rows = max(1, _BLOCK // (cos.size * n.size))
    drag = (axes.mu_coulomb[:, None] * cos + sin)[:, :, None]
    for i, mu_static in enumerate(axes.mu_static):
        hold = mu_static * cos - sin
        # NaN goes through all that follows.
        push = (n - 1) * np.where(hold > 0, hold, np.nan)[:, None]
        for j in range(0, drag.shape[0], rows):
            block = out[i, j : j + rows]
            np.subtract(push, drag[j : j + rows], out=block)
            np.copyto(block, np.nan, where=block <= 0)
            block *= GRAVITY * STROKE / 2
            np.sqrt(block, out=block)
            block /= n
    return out


def search(axes: Axes, share: float) -> Array:
    """Best count of every cell, by the largest of all velocities."""
    mu_static = axes.mu_static[: max(1, round(share * axes.mu_static.size)), None, None, None]
    mu_coulomb = axes.mu_coulomb[:, None, None]
    cos, sin = axes.cos[:, None], axes.sin[:, None]
    hold = mu_static * cos - sin
    acceleration = GRAVITY * ((COUNTS - 1) * hold - mu_coulomb * cos - sin)
    works = (hold > 0) & (acceleration > 0)
    with np.errstate(invalid="ignore"):
        velocity = np.sqrt(STROKE * acceleration / 2) / COUNTS
    best = COUNTS[np.argmax(np.where(works, velocity, -np.inf), axis=-1)]
    return np.where(works.any(axis=-1), best, np.nan)


def search_all(axes: Axes) -> Array:
    """Best count of every cell, slice by slice: what the others are checked against."""
    parts = np.array_split(axes.mu_static, axes.mu_static.size)
    slices = [Axes(part, axes.mu_coulomb, axes.slope_deg, axes.segments) for part in parts]
    return np.concatenate([search(part, 1.0) for part in slices])


def closed(axes: Axes) -> Array:
    """Best count of every cell, from the optimum over real numbers."""
    mu_static = axes.mu_static[:, None, None]
    mu_coulomb = axes.mu_coulomb[:, None]
    cos, sin = axes.cos, axes.sin
    hold, drag = mu_static * cos - sin, mu_coulomb * cos + sin
    with np.errstate(divide="ignore", invalid="ignore"):
        low = np.clip(np.floor(2 * (hold + drag) / hold), COUNTS[0], COUNTS[-1])
    high = np.minimum(low + 1, COUNTS[-1])
    push_low, push_high = (low - 1) * hold - drag, (high - 1) * hold - drag
    best = np.where(push_high * low**2 > push_low * high**2, high, low)
    return np.where((hold > 0) & (push_high > 0), best, np.nan)


def fill(out: Array, threads: int) -> Array:
    """Fill an array: the least that a result of its size can cost."""
    if threads == 1:
        out.fill(1.25)
        return out
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda part: np.copyto(part, 1.25), np.array_split(out, threads)))
    return out


def fills(group: str, axes: Axes, out: Array) -> list[Variant]:
    """List the limits of a group, for want of a compiler."""

    def call(threads: int) -> Array:
        return fill(np.empty(axes.shape) if group == FRESH else out, threads)

    return [
        Variant("fill", "limit: plain fill (numpy)", n, partial(call, n), "limit")
        for n in thread_counts()
    ]


def variants(group: str, axes: Axes, out: Array) -> list[Variant]:
    """List NumPy's ways to do the work of a group."""
    whole = Variant("numpy", "numpy, broadcasting", 1, partial(dense, axes))
    blocked = partial(dense_blocked, axes, out)
    return {
        REUSED: [whole, Variant("numpy.blocked", "numpy, blocks in place", 1, blocked)],
        FRESH: [whole],
        SEARCH: [
            Variant(
                "numpy",
                "numpy, broadcasting (on a tenth)",
                1,
                partial(search, axes, _SLICE),
                share=_SLICE,
            )
        ],
        CLOSED: [Variant("numpy", "numpy", 1, partial(closed, axes))],
    }[group]
