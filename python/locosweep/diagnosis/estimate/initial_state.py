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
_WHOLE, _NOISE = 0.9, 2.0
"""Share of a run's squares that a start speed has to take, and squares a sample that it may leave,
where its first samples do not show it: what else the model lacks takes part in all of a run. Not
derived."""


@dataclass(frozen=True)
class _StartSpeed:
    """Speed that the first samples of a run ask for, m/s."""

    samples: int
    """Number of these samples."""
    speed: float
    """As the samples show it; 0 where they show none."""
    driven: bool
    """True if the drive is on at the first sample, which may look like a speed."""
    near: float = 0.0
    """Speed with which the nominal model does best there: where a fit begins."""

    @property
    def sure(self) -> bool:
        """True if the samples show a speed that no drive could make."""
        return self.speed != 0.0 and not self.driven

    def found(self, early: Floats, whole: Floats, count: int) -> bool:
        """Return whether a fitted speed is one.

        By squares of so many residuals, at rest and with it, in the first samples and in all.
        """
        # Over the whole run a gap can ask for a speed, in the first samples only motion.
        least = 0.0 if self.sure else _GAIN
        if whole[0] - whole[1] <= _GAIN or early[0] - early[1] <= least:
            return False
        return self.speed != 0.0 or bool(
            whole[1] < (1.0 - _WHOLE) * whole[0] and whole[1] < _NOISE * count
        )

    def shown(self, early: Floats) -> bool:
        """Return whether the speed is one as the samples show it.

        By their squares: at rest, with a fitted speed, and with this one.
        """
        return self.sure and bool(early[0] - early[2] > _GAIN)


def initial_states(problem: Problem, nuisances: Nuisances) -> InitialStates:
    """Find the states in which runs begin: some in motion, the others at rest.

    A run begins in motion where both the parabola through its first samples and the nominal
    model ask for a start speed, over all of it or there. Where the drive is on at the first
    sample, which a parabola cannot tell from a speed, the nominal model must ask both
    over all of it and there. Where no parabola asks for one, little more than noise may be left
    with it, too, of a run that the nominal model does not describe from rest.
    """
    count = len(problem.runs)
    resting = problem.starts.position
    x = [run.channels["x"] for run in problem.runs]
    # The later resting position of a run in motion is not its first one.
    first = np.array([one[np.isfinite(one)][0] if np.isfinite(one).any() else 0.0 for one in x])
    asked = _asked(replace(problem, initial=InitialStates(first, np.zeros(count))), nuisances.speed)
    if not asked:
        return InitialStates(resting, np.zeros(count))
    position, read = resting.copy(), np.zeros(count)
    for r, start in asked.items():
        position[r], read[r] = first[r], start.speed
    moved = replace(problem, initial=InitialStates(position, read))
    begins = np.array([start.near - start.speed for start in asked.values()])
    fitted, squares = _tried_speeds(moved, replace(nuisances, moving=tuple(asked)), begins)
    speed = np.zeros(count)
    moving = []
    for r, start in asked.items():
        own = moved.of_run(r, range(count))
        early = squares[:, own[: start.samples]].sum(axis=1)
        if start.found(early, squares[:, own].sum(axis=1), own.size):
            speed[r] = fitted[r]
            moving.append(r)
        elif start.shown(early):
            speed[r] = start.speed
            moving.append(r)
        else:
            position[r] = resting[r]
    return InitialStates(position, speed, tuple(moving))


def _asked(problem: Problem, largest: float) -> dict[int, _StartSpeed]:
    """Return the runs that may begin in motion, with their speeds.

    Their first samples show it, or the nominal model does better there with one of the speeds that
    are tried, each twice the one before.
    """
    every = range(len(problem.runs))
    shown = {r: start for r in every if (start := _start_speed(problem, r)) is not None}
    samples = [shown[r].samples if r in shown else _first_samples(problem.runs[r]) for r in every]
    times = [run.since_start[:n][-1] for run, n in zip(problem.runs, samples, strict=True)]
    # What moves less than noise in this time cannot be seen.
    least = np.minimum(problem.noise["x"].sd / np.maximum(times, 1e-9), largest)
    sizes = 2.0 ** np.arange(np.ceil(np.log2(largest / least.min())) + 1.0)
    scan = np.minimum(sizes[:, None] * least, largest)
    read = [shown[r].speed if r in shown else 0.0 for r in every]
    scan = np.vstack([np.zeros(len(every)), scan, -scan, read])
    nominal = problem.plain()
    places = [problem.of_run(r, every)[:n] for r, n in zip(every, samples, strict=True)]
    early = np.zeros(scan.shape)
    for row, speeds in zip(early, scan, strict=True):
        (e,) = problem.residuals([replace(nominal, speeds=speeds)], list(every))
        row[:] = [float(e[own] @ e[own]) for own in places]
    asked = {}
    for r in every:
        best = int(np.argmin(early[:, r]))
        near = float(scan[best, r])
        known = np.isfinite(problem.runs[r].channels["x"][: samples[r]]).sum()
        if r in shown:
            asked[r] = replace(shown[r], near=near)
        elif known >= _LEAST_SAMPLES and early[0, r] - early[best, r] > _GAIN:
            asked[r] = _StartSpeed(samples[r], 0.0, driven=True, near=near)
    return asked


def _tried_speeds(problem: Problem, nuisances: Nuisances, begins: Floats) -> tuple[Floats, Floats]:
    """Return the fitted start speeds, and squared residuals at rest, with these, and as read.

    Fits begin so much beside what was read.
    """
    every = list(range(len(problem.runs)))
    before, behind = len(nuisances.uncertain), len(nuisances.start_offsets)
    nuisance = np.concatenate([np.zeros(before), begins, np.zeros(behind)])
    starts = start_fits(nuisances, Model((), ()), np.zeros((1, 0)), nuisance)
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
