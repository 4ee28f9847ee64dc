"""Errors of x on runs that a model has seen, and in blocks of those that it has not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import point_of
from locosweep.diagnosis.estimate.unseen import groups_of, without_groups
from locosweep.diagnosis.select import thresholds as limits

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Point, Problem
    from locosweep.diagnosis.select.search import Search

    Floats = NDArray[np.float64]

_FAR = 2.0
"""Error on the runs that a fit has seen, over the smallest one, from which it is no rival."""


def seen_error(problem: Problem, fits: Sequence[Fit]) -> list[float]:
    """Return the root mean square error of x on the fitted runs, of each of some fits."""
    errors = problem.position_errors(_points(problem, fits), problem.fitted)
    return list(np.sqrt(np.nanmean(errors**2, axis=1)).tolist())


def unseen_squares(
    search: Search, problem: Problem, fits: Sequence[Fit]
) -> tuple[Floats, NDArray[np.intp]]:
    """Return mean squared errors of x in blocks of runs that a fit has not seen, a row a fit.

    And the run that each block is of, as a number. Of the fitted runs each is left out in turn;
    those kept from fits count where they may judge. What lies far behind on the runs that it has
    seen is not tried on others.
    """
    fitted = groups_of(problem, problem.fitted)
    kept = groups_of(problem, problem.held) if search.judges else []
    if len(fitted) < 2:
        return _later_or_kept(problem, fits, kept or fitted)
    groups = [*fitted, *kept]
    blocks = -(-limits.UNSEEN_BLOCKS // len(groups))
    seen, of_run = _block_errors(problem, [_points(problem, fits)] * len(groups), groups, blocks)
    sizes = np.sqrt(seen.mean(axis=1))
    near = [i for i in range(len(fits)) if i == 0 or sizes[i] <= _FAR * sizes.min()]
    thetas = without_groups(problem, [fits[i] for i in near], fitted)
    points = [
        [point_of(problem, fits[i], theta[g] if g < len(fitted) else None)
         for i, theta in zip(near, thetas, strict=True)]
        for g in range(len(groups))
    ]  # fmt: skip
    seen[near], _ = _block_errors(problem, points, groups, blocks)
    return seen, of_run


def _points(problem: Problem, fits: Sequence[Fit]) -> list[Point]:
    return [point_of(problem, fit) for fit in fits]


def _later_or_kept(
    problem: Problem, fits: Sequence[Fit], groups: Sequence[list[int]]
) -> tuple[Floats, NDArray[np.intp]]:
    """Return errors where only one run is fitted: of its last part, or of what was kept from it."""
    points = [_points(problem, fits)] * len(groups)
    if problem.train_fraction == 1.0:
        return _block_errors(problem, points, groups, limits.UNSEEN_BLOCKS)
    later = problem.of_all_samples()
    own = np.flatnonzero(~problem.seen)
    errors = later.position_errors(points[0], range(len(problem.runs)))[:, own]
    parts = np.array_split(np.arange(own.size), limits.UNSEEN_BLOCKS)
    rows = [np.nanmean(errors[:, part] ** 2, axis=1) for part in parts
            if np.isfinite(errors[0, part]).any()]  # fmt: skip
    if not rows:
        return _block_errors(problem, points, groups, limits.UNSEEN_BLOCKS)
    return np.array(rows).T, np.zeros(len(rows), dtype=np.intp)


def _block_errors(
    problem: Problem, points: Sequence[Sequence[Point]], groups: Sequence[list[int]], blocks: int
) -> tuple[Floats, NDArray[np.intp]]:
    """Return mean squared errors of x in blocks of groups of runs, of points for each group.

    And the group that each block is of.
    """
    rows, of_run = [], []
    for g, (own, group) in enumerate(zip(points, groups, strict=True)):
        errors = problem.position_errors(own, group)
        for part in np.array_split(np.arange(errors.shape[1]), blocks):
            if np.isfinite(errors[0, part]).any():
                rows.append(np.nanmean(errors[:, part] ** 2, axis=1))
                of_run.append(g)
    return np.array(rows).T, np.array(of_run, dtype=np.intp)
