"""Errors of replays that run freely from measured states: how they grow with the horizon."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from locosweep.files.channels import REPLAYED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Point, Problem

    Floats = NDArray[np.float64]


def free_errors(
    problem: Problem, point: Point, cuts: Sequence[tuple[int, int, int]]
) -> list[Floats]:
    """Return measured minus simulated positions in m, each cut replayed from its measured state.

    A cut is a run, its first sample and one beyond the last.
    """
    if not cuts:
        return []
    starts = []
    for r, a, _ in cuts:
        motion = problem.motions[r]
        # A head that rests starts at rest: noise of its speed would break it away.
        still = abs(motion.v[a]) < motion.resting_speed
        starts.append((motion.x[a], 0.0 if still else motion.v[a]))
    read = problem.job.run(
        [(r, a, b, list(point.names)) for r, a, b in cuts],
        np.tile(point.values, (len(cuts), 1)),
        np.tile(point.factors, (len(cuts), 1)),
        np.array(starts),
        problem.threads,
        channels=[REPLAYED.index("x")],
    )[0]
    edges = np.cumsum([b - a for _, a, b in cuts])[:-1]
    return [
        problem.runs[r].channels["x"][a:b] - x
        for (r, a, b), x in zip(cuts, np.split(read, edges), strict=True)
    ]


def equal_cuts(problem: Problem, count: int, least: int = 5) -> list[tuple[int, int, int]]:
    """Cut every run into `count` parts; those of fewer than `least` samples are left out."""
    cuts: list[tuple[int, int, int]] = []
    for r, length in enumerate(problem.lengths.tolist()):
        edges = np.linspace(0, length, count + 1).astype(int).tolist()
        cuts.extend((r, a, b) for a, b in pairwise(edges) if b - a >= least)
    return cuts
