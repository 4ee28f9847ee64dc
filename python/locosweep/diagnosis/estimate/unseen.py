"""Parameters of fits without the runs that they are judged by: each run left out in turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import evaluate, fit_all, jacobian_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

_LEAST = 1e-12
"""Part of its precision that every parameter has besides: directions that the other runs do not
know stay as they are."""
_KNOWN = 1e-6
"""Part of a parameter's precision that the other runs must hold, or it stays as it is, as the
start speed of the run that is left out: a thousandth of what a run says of it by itself."""

_FARTHEST = 4.0
"""Deviations that an uncertain nominal value may be off without a run."""
_STEPS = 3
"""Damped steps of a fit without a group: it begins at the end of the fit with it."""


def groups_of(problem: Problem, runs: Sequence[int]) -> list[list[int]]:
    """Return which of some runs belong together: windows of one run are not new to each other."""
    groups: dict[int, list[int]] = {}
    for r in runs:
        groups.setdefault(problem.record_of(r), []).append(r)
    return list(groups.values())


def without_groups(
    problem: Problem, fits: Sequence[Fit], groups: Sequence[Sequence[int]]
) -> list[list[Floats]]:
    """Return the parameters of fits without each group of runs, a list a fit.

    The step of `without_each`, where it brings the other runs nearer. Where replays go far astray,
    first order may lead anywhere: there the fit goes on without the group, in damped steps.
    """
    thetas = [without_each(problem, fit, groups) for fit in fits]
    free = [i for i, fit in enumerate(fits) if fit.theta.size]
    for g, group in enumerate(groups):
        rest = [r for r in problem.fitted if r not in group]
        if not rest or not free:
            continue
        before, after = (
            evaluate(problem, starts, rest, residuals=False)
            for starts in (
                [fits[i].unfitted() for i in free],
                [fits[i].unfitted(thetas[i][g]) for i in free],
            )
        )
        astray = [i for i, a, b in zip(free, before, after, strict=True) if not b.chi2 <= a.chi2]
        again = fit_all(
            problem, [fits[i].unfitted() for i in astray], runs=rest, steps=_STEPS, tolerance=1.0
        )
        for i, fit in zip(astray, again, strict=True):
            thetas[i][g] = fit.theta
    return thetas


def without_each(problem: Problem, fit: Fit, groups: Sequence[Sequence[int]]) -> list[Floats]:
    """Return the parameters of a fit without each group of runs: one step of Gauss and Newton."""
    if not fit.theta.size:
        return [fit.theta for _ in groups]
    slopes, residual = jacobian_of(problem, fit), fit.residual
    precision = slopes @ slopes.T
    floor = _LEAST * np.diag(np.maximum(np.diag(precision), 1e-300))
    low, high = _bounds(fit)
    found = []
    for group in groups:
        own = np.concatenate([problem.of_run(r, problem.fitted) for r in group])
        here = slopes[:, own]
        rest = precision - here @ here.T
        known = np.flatnonzero(np.diag(rest) > _KNOWN * np.diag(precision))
        within = np.ix_(known, known)
        step = np.zeros(fit.theta.size)
        pull = here[known] @ residual[own]
        step[known] = np.linalg.lstsq(rest[within] + floor[within], pull, rcond=None)[0]
        found.append(np.clip(fit.theta + step, low, high))
    return found


def _bounds(fit: Fit) -> tuple[Floats, Floats]:
    """Return the ends of each entry's range; starts of runs have none."""
    low, high = fit.bounds
    for i, uncertain in enumerate(fit.nuisances.uncertain, start=len(fit.model.free)):
        high[i] = _FARTHEST * fit.nuisances.spread[uncertain]
        low[i] = -high[i]
    return low, high
