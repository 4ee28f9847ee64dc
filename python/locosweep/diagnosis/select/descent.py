"""Fits of one search from many starts: those that may come near the best to their end."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import chi2_of, evaluate, fit_all
from locosweep.diagnosis.select.screen import informative_runs, near_best, scan
from locosweep.diagnosis.select.thresholds import PENALTY

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.select.search import Collection, Found, Search

CLOSE = 8
"""Fits that are followed to their end whatever the best one reaches."""
FAR_BEHIND = 30.0
"""Chi2 over the best fit's, beyond which no jumps are tried."""
SLACK = 200.0
"""Scores further behind the best one than this, by what derivatives promise, are out of
reach of it also along a valley that bends."""
_FIRST = 3
"""Fits that are followed to their end before others are given limits."""
_ROUGH = 0.5
"""Gain of a step below which a fit is left, unless it may tie with the best one."""
_CONTEST = 60.0
"""Scores this far from the best one may tie with it once both have all digits."""
_DENSE = 161
"""Values of a parameter that no derivative sees."""
_JUMPS = tuple(sign * 0.5 * 0.7**k for k in range(27) for sign in (-1.0, 1.0))
"""Changes of one parameter that are tried, in units of its size."""


def descend(
    search: Search,
    known: Collection,
    starts: Sequence[Fit],
    runs: list[int],
    jumps: int,
    *,
    at_noise: bool = False,
) -> Found:
    """Fit from starts, the first steps on `runs`, and follow those that may come near the best.

    `jumps` limits the fits that are tried from further starts. With `at_noise`, the model that
    the starts extend leaves but noise: then nothing ties. Returns the best fit of each set among
    the starts, or the known one where that is better.
    """
    problem, steps = search.problem, search.steps
    fits = list(starts)
    if not at_noise:
        # The first steps from poor starts need not see all runs.
        fits = near_best(fit_all(problem, evaluate(problem, fits, runs), runs=runs, steps=3))
    fits = _with_limits(search, known, evaluate(problem, fits), at_noise=at_noise)
    fits = near_best(fit_all(problem, fits, steps=3 if at_noise else 1))
    least = min((f.chi2 for f in fits), default=np.inf)
    order = sorted(range(len(fits)), key=lambda i: fits[i].chi2)
    # Those that are far behind stay as they are.
    close = [i for n, i in enumerate(order) if n < CLOSE or fits[i].chi2 < 10.0 * least]

    def improve(chosen: Sequence[int], tolerance: float = 0.02) -> None:
        better = fit_all(problem, [fits[i] for i in chosen], steps=steps, tolerance=tolerance)
        for i, fit in zip(chosen, better, strict=True):
            fits[i] = fit

    first, others = close[:_FIRST], close[_FIRST:]
    improve(first)
    limited = _with_limits(
        search, known, [fits[i] for i in others], [fits[i] for i in first], at_noise=at_noise
    )
    for i, fit in zip(others, limited, strict=True):
        fits[i] = fit
    improve(others, _ROUGH)
    # Only those that may tie need all digits.
    least = min((search.score(fits[i]) for i in close), default=np.inf)
    improve([i for i in close if search.score(fits[i]) < least + _CONTEST])
    close.sort(key=lambda i: fits[i].chi2)
    chosen = [i for i in close if fits[i].chi2 < FAR_BEHIND * fits[close[0]].chi2][:jumps]
    for i, fit in zip(chosen, jump(search, [fits[i] for i in chosen]), strict=True):
        fits[i] = fit
    found: Found = {}
    for fit in fits:
        key = frozenset(fit.model.names)
        best = found.get(key, known.fits.get(key))
        found[key] = fit if best is None or fit.chi2 < best.chi2 else best
    return found


def _with_limits(
    search: Search,
    known: Collection,
    fits: Sequence[Fit],
    others: Sequence[Fit] = (),
    *,
    at_noise: bool,
) -> list[Fit]:
    """Return fits with the chi2 that they have to reach, where some fit leaves little but noise.

    Beside a model that is `at_noise` itself nothing ties: a further effect has to gain.
    """
    best = min([*known.fits.values(), *others], key=search.score)
    if not search.is_noise(best):
        return list(fits)
    most = search.score(best) + (0.0 if at_noise else SLACK)
    return [replace(fit, limit=most - PENALTY * len(fit.model.free)) for fit in fits]


def jump(search: Search, fits: Sequence[Fit]) -> list[Fit]:
    """Try large changes of one parameter at a time, and fit again from better values.

    Thresholds and periods give chi2 many valleys, and derivatives do not see beyond one.
    """
    found = list(fits)
    for _ in range(2):
        todo = [i for i, f in enumerate(found) if search.leaves_much(f) and f.model.free]
        if not todo or not search.jumps:
            break
        runs = informative_runs(search.problem, found[todo[0]])
        # The first of each is the fit itself, seen on the same runs.
        tried = [[found[i].unfitted(), *_jumps_of(found[i])] for i in todo]
        flat = [s.fit for s in scan(search.problem, chain(*tried), runs)]
        chosen, starts = [], []
        for i, trials in zip(todo, tried, strict=True):
            (same, *seen), flat = flat[: len(trials)], flat[len(trials) :]
            best = sorted(seen, key=chi2_of)[: 1 if len(seen) < _DENSE else 6]
            better = [t for t in best if t.chi2 < 0.98 * same.chi2 or len(best) > 1]
            chosen += [i] * len(better)
            starts += better
        if not starts:
            break
        for i, trial in zip(chosen, fit_all(search.problem, starts, steps=search.steps),
                            strict=True):  # fmt: skip
            if trial.chi2 < found[i].chi2:
                found[i] = replace(trial, damping=found[i].damping, limit=found[i].limit)
    return found


def _jumps_of(fit: Fit) -> list[Fit]:
    trials = []
    for i, free in enumerate(fit.model.free):
        low, high = (np.log(v) if free.log else v for v in (free.low, free.high))
        unit = 1.0 if free.log else free.size
        known = fit.covariance.size and fit.covariance[i, i] < 1e4 * unit**2
        # A dense grid finds values that derivatives do not see at all.
        for change in _JUMPS if known else np.linspace(-0.4, 0.4, _DENSE):
            theta = fit.theta.copy()
            theta[i] = np.clip(theta[i] + change * unit, low, high)
            trials.append(fit.unfitted(theta))
    for i in range(len(fit.model.free) + len(fit.nuisances.uncertain), fit.theta.size):
        # A run's start that another model's fit has shifted may lie in a valley of its own.
        theta = fit.theta.copy()
        theta[i] = 0.0
        trials.append(fit.unfitted(theta))
    return trials
