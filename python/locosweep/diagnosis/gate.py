"""The data gate: what runs cannot carry, which are kept from fits, how they start."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.fit import Model, fit_all, point_of, start_fits
from locosweep.diagnosis.search import fit_nominal
from locosweep.errors import DataFileError, InputError
from locosweep.replay import motor_of, nominal_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.diagnosis.fit import Nuisances
    from locosweep.diagnosis.problem import Problem
    from locosweep.files import Robot
    from locosweep.measured import Run

__all__ = ["check_runs", "gaps_of", "hold_out", "moving_starts", "usable"]

_TAIL = 0.7
"""Share of a single run that fits see."""
_SPEED = 3.0
"""Deviations from which a start speed is looked into."""
_BEFORE = 5
"""Samples that a start speed is read off, at least."""
_GAIN = 16.0
"""What a start speed has to gain in chi2 on its run."""
_VALUES, _FEWEST = 20, 8
"""Values of x that one run has to have, and every run that takes part."""
_FEW = 4
"""Runs below which answers are wider."""


def usable(runs: Sequence[Run]) -> tuple[list[Run], list[str]]:
    """Return the runs whose position was measured, and a warning for each other one.

    DataFileError where none was.
    """
    known = [int(np.isfinite(run.channels["x"]).sum()) for run in runs]
    if max(known, default=0) < _VALUES:
        raise DataFileError(f"runs: column x has fewer than {_VALUES} values in every run")
    warnings = [
        f"run {run.label}: x has {count} values, at least {_FEWEST} are needed: it is left out"
        for run, count in zip(runs, known, strict=True)
        if count < _FEWEST
    ]
    return [run for run, count in zip(runs, known, strict=True) if count >= _FEWEST], warnings


def check_runs(runs: Sequence[Run], robot: Robot) -> list[str]:
    """Return what is to be known about runs before their diagnosis is believed."""
    nominal = nominal_of(robot)
    warnings = []
    if len(runs) == 1:
        warnings.append("one run only: its last part is the check, and nothing repeats")
    elif len(runs) < _FEW:
        warnings.append(f"{len(runs)} runs only: answers are wider than with {_FEW} or more")
    drives = [run.drive for run in runs]
    if all(np.ptp(drive) == 0.0 for drive in drives):
        warnings.append("the drive is constant in every run: effects of the drive hardly show")
    elif len(runs) > 1 and len({drive.tobytes() for drive in drives}) == 1:
        warnings.append("every run has the same drive: fewer effects can be told apart")
    moved = [float(np.ptp(x[np.isfinite(x)])) for x in (run.channels["x"] for run in runs)]
    span = max(moved)
    noise = float(robot.other.get("sensor.position_noise", 0.0))
    noise = max(noise, float(robot.other.get("sensor.position_resolution", 0.0)))
    if span <= 8.0 * noise or span == 0.0:
        warnings.append("the head never moves beyond the noise in these runs: little can be seen")
    free = max(_free(run, nominal["gain"]) for run in runs) / nominal["mass"]
    flat = "gravity_torque" not in nominal and not _slopes(runs, nominal)
    if flat and span > 2.0 * free + 100.0 * noise:
        warnings.append(
            f"x spans {span:.3g} m, the drive without any friction would move the head by at "
            f"most {free:.3g} m: is x in another unit than m (--unit x=mm)?"
        )
    if motor_of(robot) is None and any("power" in run.channels for run in runs):
        warnings.append(
            "power is measured but the nominal file gives no resistance and force_constant "
            "in [motor]: the column is not used"
        )
    for run in runs:
        steps = np.diff(run.t)
        if steps.max() > 10.0 * np.median(steps):
            warnings.append(
                f"run {run.label}: a gap of {steps.max():.3g} s between samples, "
                "the drive is held over it"
            )
        x = run.channels["x"]
        gone = float((~np.isfinite(x)).mean())
        if gone > 0.2:
            warnings.append(f"run {run.label}: {gone:.0%} of x is missing")
    return warnings


def _free(run: Run, gain: float) -> float:
    """How far a run's drive would move one kilogram from rest, always pushing one way."""
    steps = np.diff(run.t)
    speed = np.concatenate([[0.0], np.cumsum(np.abs(run.drive[:-1]) * gain * steps)])
    return float(np.sum(speed[:-1] * steps + 0.5 * np.diff(speed) * steps))


def _slopes(runs: Sequence[Run], nominal: dict[str, float]) -> bool:
    return any((run.slope_deg or 0.0) != 0.0 for run in runs) or nominal["slope_deg"] != 0.0


def gaps_of(problem: Problem, nuisances: Nuisances) -> list[float]:
    """Return the squared whitened error of the nominal model per sample, run by run.

    Its uncertain values are fitted to all runs: what they explain is no gap.
    """
    every = list(range(len(problem.runs)))
    if nuisances.shares:
        e = fit_nominal(problem, replace(nuisances, places=())).residual
    else:
        e = problem.residuals([problem.plain()], every)[0]
    return [float(np.mean(e[problem.of_run(r, every)] ** 2)) for r in every]


def hold_out(
    runs: Sequence[Run], asked: Sequence[str] | None, gaps: Sequence[float]
) -> tuple[tuple[int, ...], float, bool]:
    """Return the runs kept from fits, the share of a run that fits see, and who chose.

    `gaps` are the squared errors of the nominal model per sample, run by run.
    """
    labels = [run.label for run in runs]
    if asked:
        for label in asked:
            if label not in labels:
                raise InputError(f"holdout: no run {label}: there are {', '.join(labels)}")
        held = tuple(i for i, label in enumerate(labels) if label in asked)
        if len(held) == len(runs):
            raise InputError("holdout: all runs are kept from the fit: leave at least one")
        return held, 1.0, True
    if len(runs) == 1:
        return (), _TAIL, False
    # The runs whose gap is most like that of all, but not the richest, which fits need,
    # and no slope that only they have.
    size = np.log(np.maximum(np.array(gaps), 1e-300))
    middle = np.log(max(float(np.mean(gaps)), 1e-300))
    slopes = [run.slope_deg for run in runs]
    order = sorted(
        range(len(runs)),
        key=lambda i: (
            slopes.count(slopes[i]) == 1,
            len(runs) > 2 and size[i] == size.max(),
            abs(size[i] - middle),
            i,
        ),
    )
    count = max(1, len(runs) // 4)
    return tuple(sorted(order[:count])), 1.0, False


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
