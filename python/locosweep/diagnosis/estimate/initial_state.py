"""Initial states: runs that begin in motion, and the speed with which they do."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import Model, fit_all, point_of, start_fits
from locosweep.diagnosis.estimate.problem import InitialStates

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Nuisances
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

_DEVIATIONS = 3.0
"""Deviations from which a start speed is looked into."""
_LEAST_SAMPLES = 5
"""Samples that a start speed is read off, at least."""
_GAIN = 16.0
"""Gain in chi2 on its run that a start speed needs: four deviations."""


@dataclass(frozen=True)
class _StartSpeed:
    """Speed that the first samples of a run ask for, m/s."""

    samples: int
    """Number of these samples."""
    speed: float
    driven: bool
    """True if the drive is on at the first sample, which may look like a speed."""


def initial_states(problem: Problem, nuisances: Nuisances) -> InitialStates:
    """Find the states in which runs begin: some in motion, the others at rest.

    A run begins in motion where both the parabola through its first samples and the nominal
    model ask for a start speed, over all of it or there. Where the drive is on at the first
    sample, which a parabola cannot tell from a speed, the nominal model must ask both
    over all of it and there.
    """
    count = len(problem.runs)
    found = {r: _start_speed(problem, r) for r in range(count)}
    asked = {r: one for r, one in found.items() if one is not None}
    resting = problem.starts.position
    if not asked:
        return InitialStates(resting, np.zeros(count))
    position, read = resting.copy(), np.zeros(count)
    for r, start in asked.items():
        # Its later resting position is not its first one.
        x = problem.runs[r].channels["x"]
        position[r], read[r] = x[np.isfinite(x)][0], start.speed
    moved = replace(problem, initial=InitialStates(position, read))
    fitted, squares = _tried_speeds(moved, replace(nuisances, moving=tuple(asked)))
    speed = np.zeros(count)
    moving = []
    for r, start in asked.items():
        own = moved.of_run(r, range(count))
        # Over the whole run a gap can ask for a speed, in the first samples only motion.
        first = own[: start.samples]
        whole = squares[0, own].sum() - squares[1:, own].sum(axis=1)
        early = squares[0, first].sum() - squares[1:, first].sum(axis=1)
        if whole[0] > _GAIN and early[0] > (_GAIN if start.driven else 0.0):
            speed[r] = fitted[r]
            moving.append(r)
        elif not start.driven and early[1] > _GAIN:
            speed[r] = start.speed
            moving.append(r)
        else:
            position[r] = resting[r]
    return InitialStates(position, speed, tuple(moving))


def _tried_speeds(problem: Problem, nuisances: Nuisances) -> tuple[Floats, Floats]:
    """Return the fitted start speeds, and squared residuals at rest, with these, and as read."""
    every = list(range(len(problem.runs)))
    starts = start_fits(nuisances, Model((), ()), np.zeros((1, 0)))
    (with_speed,) = fit_all(problem, starts, runs=every)
    fitted = point_of(problem, with_speed)
    at_rest, read = fitted.speeds.copy(), fitted.speeds.copy()
    asked = list(nuisances.moving)
    at_rest[asked], read[asked] = 0.0, problem.starts.speed[asked]
    points = [replace(fitted, speeds=speeds) for speeds in (at_rest, fitted.speeds, read)]
    return fitted.speeds, problem.residuals(points, every) ** 2


def _start_speed(problem: Problem, r: int) -> _StartSpeed | None:
    """Return the start speed that the first samples of a run ask for, if any."""
    run = problem.runs[r]
    few = _first_samples(run)
    pushed = np.flatnonzero(np.diff(run.drive)) + 1
    if run.drive[0] == 0.0 and pushed.size and pushed[0] >= _LEAST_SAMPLES:
        # The next push of the drive is no start speed.
        few, pushed = min(few, int(pushed[0]) + 1), pushed[:0]
    elif pushed.size > 1:
        few = min(few, max(int(pushed[1]) + 1, 2 * _LEAST_SAMPLES))
    t, x = run.since_start[:few], run.channels["x"][:few]
    ok = np.isfinite(x)
    if ok.sum() < _LEAST_SAMPLES:
        return None
    # A parabola: the head may also start from rest at once, or with the first push.
    base = np.vander(t, 3)
    if pushed.size and pushed[0] < few - 2:
        late = np.maximum(t - run.since_start[pushed[0]], 0.0)
        base = np.column_stack([late**2, base])
    base = base[ok]
    if np.linalg.matrix_rank(base) < base.shape[1]:
        return None
    fit, *_ = np.linalg.lstsq(base, x[ok], rcond=None)
    spread = np.sqrt(np.linalg.inv(base.T @ base)[-2, -2]) * problem.noise["x"].sd
    speed, sure = float(fit[-2]), abs(fit[-2]) > _DEVIATIONS * spread
    if "v" in run.channels and np.isfinite(run.channels["v"][0]):
        first = float(run.channels["v"][0])
        if abs(first) > _DEVIATIONS * problem.noise["v"].sd:
            speed, sure = first, True
    if sure:
        return _StartSpeed(few, speed, driven=False)
    return _mean_speed(problem, r) if run.drive[0] != 0.0 else None


def _mean_speed(problem: Problem, r: int) -> _StartSpeed | None:
    """Return the mean speed over the first samples of a run, if it is not 0."""
    run = problem.runs[r]
    few = _first_samples(run)
    t, x = run.since_start[:few], run.channels["x"][:few]
    ok = np.isfinite(x)
    t, x = t[ok], x[ok]
    if t.size < _LEAST_SAMPLES:
        return None
    arms = t - t.mean()
    speed = float(arms @ x / (arms @ arms))
    deviation = problem.noise["x"].sd / float(np.sqrt(arms @ arms))
    return _StartSpeed(few, speed, driven=True) if abs(speed) > _DEVIATIONS * deviation else None


def _first_samples(run: Run) -> int:
    return int(np.clip(run.t.size // 40, 8, 60))
