"""Our own side: the public call, and the kernels of every SIMD level."""

from __future__ import annotations

from functools import partial
from typing import Any

import locosweep as ls
from common.threads import thread_counts
from locosweep import _core
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

_LIMITS = {"segments_min": COUNTS[0], "segments_max": COUNTS[-1]}
_WORK: dict[str, tuple[str, dict[str, Any], dict[str, str]]] = {
    REUSED: ("mean_velocity", {}, {}),
    FRESH: ("mean_velocity", {}, {}),
    SEARCH: ("mean_velocity", {"segments": COUNTS}, {"over": "segments", "reduce": "argmax"}),
    CLOSED: ("best_segments", _LIMITS, {}),
}


def variants(group: str, axes: Axes, out: Array) -> list[Variant]:
    """List our ways to do the work of a group."""
    quantity, more, how = _WORK[group]
    given = {
        "mu_static": axes.mu_static,
        "mu_coulomb": axes.mu_coulomb,
        "slope_deg": axes.slope_deg,
        "gravity": GRAVITY,
        "stroke": STROKE,
    }
    if axes.segments.size:
        given["segments"] = axes.segments
    grid = ls.Grid(**given, **more)
    target = None if group == FRESH else out

    def sweep(threads: int) -> Array:
        return ls.sweep(quantity, grid, out=target, threads=threads, **how).values

    found = [Variant("ours", "locosweep", n, partial(sweep, n), "ours") for n in thread_counts()]
    if group == FRESH:
        return found
    request = (quantity, how.get("reduce"), None)
    job = _core.Sweep(list(grid.axes.items()), list(grid.fixed.items()), [request], how.get("over"))

    def run(level: str, threads: int) -> Array:
        job.run([(0, out)], threads, None, None, None, level)
        return out

    for level in _core.simd_levels():
        for n in thread_counts():
            call = partial(run, level, n)
            found.append(Variant(f"ours.{level}", f"locosweep, {level}", n, call, "ours"))
    return found
