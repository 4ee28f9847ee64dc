"""Runs that begin in motion, and the speed with which they do."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import Model, fit_all, point_of, start_fits

if TYPE_CHECKING:
    from locosweep.diagnosis.estimate.least_squares import Nuisances
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.files.runs import Run

__all__ = ["moving_starts"]

_SPEED = 3.0
"""Deviations from which a start speed is looked into."""
_BEFORE = 5
"""Samples that a start speed is read off, at least."""
_GAIN = 16.0
"""What a start speed has to gain in chi2 on its run."""


def _drifts(problem: Problem, r: int) -> tuple[int, float, bool]:
    """Return the first samples of a run, their mean speed, and whether it is not 0."""
    run = problem.runs[r]
    few = _first(run)
    t, x = run.since_start[:few], run.channels["x"][:few]
    ok = np.isfinite(x)
    t, x = t[ok], x[ok]
    if t.size < _BEFORE:
        return few, 0.0, False
    arms = t - t.mean()
    speed = float(arms @ x / (arms @ arms))
    return few, speed, abs(speed) > _SPEED * problem.noise["x"].sd / float(np.sqrt(arms @ arms))


def _first(run: Run) -> int:
    return int(np.clip(run.t.size // 40, 8, 60))


def moving_starts(problem: Problem, nuisances: Nuisances) -> tuple[int, ...]:
    """Find runs that begin in motion; the speed of the others is set to 0.

    A run does where both the parabola through its first samples and the nominal model
    ask for a start speed, over all of it or there. Where the drive is on at the first
    sample, which a parabola cannot tell from a speed, the nominal model must ask both
    over all of it and there.
    """
    asked: dict[int, tuple[int, float]] = {}
    driven: set[int] = set()
    problem.begin[:, 1] = 0.0
    for r, run in enumerate(problem.runs):
        few = _first(run)
        pushed = np.flatnonzero(np.diff(run.drive)) + 1
        if run.drive[0] == 0.0 and pushed.size and pushed[0] >= _BEFORE:
            # What the drive does next is no start speed.
            few, pushed = min(few, int(pushed[0]) + 1), pushed[:0]
        elif pushed.size > 1:
            few = min(few, max(int(pushed[1]) + 1, 2 * _BEFORE))
        t, x = run.since_start[:few], run.channels["x"][:few]
        ok = np.isfinite(x)
        if ok.sum() < _BEFORE:
            continue
        # A parabola: the head may also start from rest at once, or with the first push.
        base = np.vander(t, 3)
        if pushed.size and pushed[0] < few - 2:
            late = np.maximum(t - run.since_start[pushed[0]], 0.0)
            base = np.column_stack([late**2, base])
        base = base[ok]
        if np.linalg.matrix_rank(base) < base.shape[1]:
            continue
        fit, *_ = np.linalg.lstsq(base, x[ok], rcond=None)
        spread = np.sqrt(np.linalg.inv(base.T @ base)[-2, -2]) * problem.noise["x"].sd
        speed, sure = float(fit[-2]), abs(fit[-2]) > _SPEED * spread
        if "v" in run.channels and np.isfinite(run.channels["v"][0]):
            first = float(run.channels["v"][0])
            if abs(first) > _SPEED * problem.noise["v"].sd:
                speed, sure = first, True
        if not sure and run.drive[0] != 0.0:
            few, speed, sure = _drifts(problem, r)
            driven.update([r] if sure else [])
        if sure:
            problem.begin[r, 1] = speed
            asked[r] = few, speed
    if not asked:
        return ()
    resting = problem.begin[:, 0].copy()
    for r in asked:
        # Where it rests later is not where it began.
        x = problem.runs[r].channels["x"]
        problem.begin[r, 0] = x[np.isfinite(x)][0]
    every = list(range(len(problem.runs)))
    free = replace(nuisances, moving=tuple(asked))
    with_speed = start_fits(free, Model((), ()), np.zeros((1, 0)))[0]
    fit_all(problem, [with_speed], runs=every)
    fitted = point_of(problem, with_speed)
    read, at_rest = fitted.speeds.copy(), fitted.speeds.copy()
    for r, (_, speed) in asked.items():
        read[r], at_rest[r] = speed, 0.0
    points = [replace(fitted, speeds=speeds) for speeds in (at_rest, fitted.speeds, read)]
    squares = problem.residuals(points, every) ** 2
    problem.begin[:, 1] = 0.0
    moving = []
    for r, (few, speed) in asked.items():
        place = problem.of_run(r, every)
        # Over the whole run a gap can ask for a speed, in the first samples only motion.
        whole = squares[0, place].sum() - squares[1:, place].sum(axis=1)
        early = squares[0, place[:few]].sum() - squares[1:, place[:few]].sum(axis=1)
        if whole[0] > _GAIN and early[0] > (_GAIN if r in driven else 0.0):
            problem.begin[r, 1] = fitted.speeds[r]
            moving.append(r)
        elif r not in driven and early[1] > _GAIN:
            problem.begin[r, 1] = speed
            moving.append(r)
        else:
            problem.begin[r, 0] = resting[r]
    return tuple(moving)
