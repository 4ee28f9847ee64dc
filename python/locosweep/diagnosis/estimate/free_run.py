"""Errors of replays that run freely from measured states: how they grow with the horizon."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Point, Problem


def _restarted(
    problem: Problem, point: Point, cuts: list[tuple[int, int, int]]
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Replay windows (run, first, one beyond last) from their measured state.

    Returns for each its times and the residual of the position in m.
    """
    if not cuts:
        return []
    starts = []
    for r, a, _ in cuts:
        motion = problem.motions[r]
        # A head that rests starts at rest: noise of its speed would break it away.
        limit = 4.0 * motion.deviation + 0.01 * float(np.abs(motion.v).max(initial=0.0))
        still = abs(motion.v[a]) < limit
        starts.append((motion.x[a], 0.0 if still else motion.v[a]))
    columns = [(r, a, b, list(point.names)) for r, a, b in cuts]
    count = len(cuts)
    read = problem.job.run(
        columns,
        np.tile(point.values, (count, 1)),
        np.tile(point.factors, (count, 1)),
        np.array(starts),
        problem.threads,
    )[0]
    found, at = [], 0
    for r, a, b in cuts:
        x = problem.runs[r].channels["x"][a:b]
        found.append((problem.runs[r].t[a:b], x - read[at : at + b - a]))
        at += b - a
    return found


def free_errors(
    problem: Problem, point: Point, cuts: list[tuple[int, int, int]]
) -> list[NDArray[np.float64]]:
    """Return measured minus simulated positions in windows, each from its measured state."""
    return [e for _, e in _restarted(problem, point, cuts)]


def _cuts(problem: Problem, count: int) -> list[tuple[int, int, int]]:
    cuts: list[tuple[int, int, int]] = []
    for r in range(len(problem.runs)):
        edges = np.linspace(0, int(problem.lengths[r]), count + 1).astype(int)
        cuts.extend((r, int(a), int(b)) for a, b in pairwise(edges) if b - a >= 5)
    return cuts
