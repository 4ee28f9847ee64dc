"""numexpr: the formula as one expression."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import numexpr
import numpy as np

from common.threads import thread_counts
from peers.work import FRESH, GRAVITY, REUSED, STROKE, Array, Axes, Variant

# cos and sin would be functions.
_HOLD = "(mu_static * c - s)"
_ACCELERATION = f"(g * ((n - 1) * {_HOLD} - mu_coulomb * c - s))"
_VELOCITY = f"sqrt(d * {_ACCELERATION} / 2) / n"
_DENSE = f"where(({_HOLD} > 0) & ({_ACCELERATION} > 0), {_VELOCITY}, nan)"


@contextmanager
def _threads(count: int) -> Iterator[None]:
    before = numexpr.set_num_threads(count)
    try:
        yield
    finally:
        numexpr.set_num_threads(before)


def variants(group: str, axes: Axes, out: Array) -> list[Variant]:
    """List numexpr's ways to do the work of a group."""
    if group not in (REUSED, FRESH):
        return []
    given = {
        "mu_static": axes.mu_static[:, None, None, None],
        "mu_coulomb": axes.mu_coulomb[:, None, None],
        "c": axes.cos[:, None],
        "s": axes.sin[:, None],
        "n": axes.segments,
        "g": GRAVITY,
        "d": STROKE,
        "nan": np.nan,
    }
    target = out if group == REUSED else None
    call = partial(numexpr.evaluate, _DENSE, local_dict=given, out=target)
    return [
        Variant("numexpr", "numexpr", n, call, around=partial(_threads, n)) for n in thread_counts()
    ]
