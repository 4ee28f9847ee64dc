"""Parameters of fits without the runs that they are judged by: each run left out in turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import evaluate, jacobian_of

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
_SHORTEST = 1.0 / 8.0
"""Part of a step that is tried at last. Not derived: shorter ones change little."""


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

    The step of `without_each` is as long as it brings the other runs nearer: where replays go far
    astray, first order may lead anywhere.
    """
    thetas = [without_each(problem, fit, groups) for fit in fits]
    for g, group in enumerate(groups):
        rest = [r for r in problem.fitted if r not in group]
        steps = {i: thetas[i][g] - fit.theta for i, fit in enumerate(fits) if fit.theta.size}
        if not rest or not steps:
            continue
        before = evaluate(problem, [fits[i].unfitted() for i in steps], rest, residuals=False)
        least = {i: one.chi2 for i, one in zip(steps, before, strict=True)}
        part = 1.0
        while steps and part >= _SHORTEST:
            starts = [fits[i].unfitted(fits[i].theta + part * step) for i, step in steps.items()]
            tried = evaluate(problem, starts, rest, residuals=False)
            for i, one in zip(list(steps), tried, strict=True):
                if one.chi2 <= least[i]:
                    thetas[i][g] = one.theta
                    del steps[i]
            part *= 0.5
        for i in steps:
            thetas[i][g] = fits[i].theta
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
