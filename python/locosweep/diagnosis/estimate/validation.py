"""Residuals of the validation data: runs, or the part of a run, that fits do not see."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.files.channels import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Point, Problem

    Floats = NDArray[np.float64]


def validation_residuals(problem: Problem, points: Sequence[Point]) -> Floats:
    """Return whitened residuals of the validation data, in the form of `Problem.residuals`.

    Start offsets of held-out runs are refitted; behind `train_fraction` they stay those of
    the fit. What rows that miss may have changed is refitted everywhere, and offsets with it.
    Shape (points, 0) where no data validate.
    """
    if problem.train_fraction < 1.0:
        found = problem.replay(points, range(len(problem.runs)))
        edges = problem.starts_at[:-1]
        rows = []
        for c in problem.channels:
            w = problem.weights[c]
            e = (np.where(w > 0.0, problem.measured[c], 0.0) - found[c]) * w
            if problem.has_offset(c):
                if CHANNELS[c].from_rest:
                    e -= np.repeat(problem.start_levels[c], problem.lengths) * w
                if not problem.gap_shifts.kinds:
                    wf = w * problem.seen
                    bottom = np.add.reduceat(wf * wf, edges) + problem.priors[c] ** -2.0
                    offset = np.add.reduceat(e * wf, edges, axis=1) / bottom
                    e -= np.repeat(offset, problem.lengths, axis=1) * w
            rows.append(e)
        if problem.gap_shifts.kinds:
            shifts = problem.shifts_of(dict(zip(problem.channels, rows, strict=True)))
            rows = [e - shifts[c] for c, e in zip(problem.channels, rows, strict=True)]
        return np.concatenate([np.where(problem.seen, 0.0, e) for e in rows], axis=1)
    if not problem.held:
        return np.zeros((len(points), 0))
    e = problem.residuals(points, problem.held)
    kinds = []
    if problem.position_matters:
        kinds.append(("start_offsets", problem.priors["x"]))
    if any(r in problem.starts.moving for r in problem.held):
        free = np.isin(np.arange(len(problem.runs)), problem.starts.moving)
        kinds.append(("speeds", np.where(free, 1e30, 1e-30)))
    return _refitted_starts(problem, points, e, kinds) if kinds else e


def _refitted_starts(
    problem: Problem, points: Sequence[Point], e: Floats, kinds: list[tuple[str, Floats]]
) -> Floats:
    """Fit how runs start, to first order, and take that out of their residuals."""
    columns = []
    for kind, spread in kinds:
        step = np.where(spread < 1e20, 0.1 * spread, 1e-4 * problem.speed_scale)
        step = np.maximum(step, 1e-12)
        moved = [replace(p, **{kind: getattr(p, kind) + step}) for p in points]
        columns.append((problem.residuals(moved, problem.held) - e, step, spread))
    for r in problem.held:
        own = problem.of_run(r, problem.held)
        jacobian = np.stack([c[:, own] / step[r] for c, step, _ in columns], axis=1)
        prior = np.diag([min(s[r] ** -2.0, 1e60) for _, _, s in columns])
        normal = jacobian @ jacobian.transpose(0, 2, 1) + prior
        gradient = jacobian @ e[:, own, None]
        shift = np.linalg.solve(normal, gradient)
        e[:, own] -= (jacobian.transpose(0, 2, 1) @ shift)[:, :, 0]
    return e
