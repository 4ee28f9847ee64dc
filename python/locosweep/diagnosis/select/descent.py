"""Fits of one search from many starts: those that may come near the best to their end."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import chi2_of, evaluate, fit_all
from locosweep.diagnosis.select.effort import FEW, PARTNERS, SHARE, SLACK
from locosweep.diagnosis.select.score import stalled_beside, total
from locosweep.diagnosis.select.thresholds import (
    LEAST_GAIN_FITTED,
    PENALTY,
    STALLED,
    TIE,
)
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.select.search import Collection, Found, Search


_ALONG = np.outer(np.geomspace(1.0, 32.0, 16), (-1.0, 1.0)).ravel()
"""Deviations along an axis of a fit's covariance that are tried: from where chi2 rises by 1 to
where it rises by 1000, each a quarter larger than the last. With seed 9417 of `blind-check --cases
200 --gap-free 100`, steps of a factor of two passed over the best valley of a gap (case 131)."""


def descend(
    search: Search,
    known: Collection,
    starts: Sequence[Fit],
    runs: list[int],
    beside: Fit,
    *,
    at_noise: bool = False,
    rival: Fit | None = None,
    beat: bool = False,
) -> Found:
    """Fit from starts, the first steps on `runs`, and follow those that may come near the best.

    The starts extend the model of the fit `beside`. With `at_noise` it leaves but noise: then
    nothing ties. With a `rival`, they have to come near that one; with `beat`, to take half of what
    the best smaller set leaves. Returns the best fit of each set among the starts, or the known one
    where that is better.
    """
    problem, steps, tolerance = search.problem, search.steps, search.tolerance
    fits, far = list(starts), []
    if not at_noise:
        # The first steps from poor starts need not see all runs.
        fits = apart(_near_best(fit_all(problem, fits, runs=runs, steps=FEW)))
        (before,) = evaluate(problem, [beside.unfitted()], runs, residuals=False)
        most = follow_limit(before, min((fit.chi2 for fit in fits), default=np.inf))
        far = evaluate(problem, [fit for fit in fits if fit.chi2 > most], residuals=False)
        fits = [fit for fit in fits if fit.chi2 <= most]
    fits = evaluate(problem, fits, residuals=False)
    fits = _with_limits(search, known, fits, at_noise=at_noise, rival=rival, beat=beat)
    fits = apart(sorted(fit_all(problem, fits, steps=1), key=chi2_of))
    least = rival.chi2 if rival else np.inf
    first = fit_all(problem, fits[:FEW], steps=steps, tolerance=tolerance, least=least)
    least = min([least, *(fit.chi2 for fit in first)])
    others = _with_limits(
        search, known, fits[FEW:], first, at_noise=at_noise, rival=rival, beat=beat
    )
    others = apart(fit_all(problem, others, steps=FEW, tolerance=tolerance, least=least))
    least = min([least, *(fit.chi2 for fit in others)])
    most = follow_limit(beside, least)
    near = [fit for fit in others if fit.chi2 < most]
    if beside.model.names:
        # Of larger sets only those count that may come to the best one.
        near = [replace(fit, limit=min(fit.limit, least + SLACK)) for fit in near]
    near = fit_all(problem, near, steps=steps, tolerance=tolerance, least=least)
    ends = [*first, *near, *others, *far]
    found: Found = {}
    for fit in ends:
        key = frozenset(fit.model.names)
        best = found.get(key, known.fits.get(key))
        found[key] = fit if best is None or fit.chi2 < best.chi2 else best
    return found


def follow_limit(beside: Fit, least: float) -> float:
    """Return the chi2 above which a fit gains less than half of what one with `least` does."""
    return float(max(beside.chi2 - SHARE * (beside.chi2 - least), least + SLACK))


def takes_place(search: Search, fit: Fit) -> float:
    """Return the chi2 below which another set takes the place of one that leaves too much."""
    noise = search.problem.degrees() * noise_level(search.problem, fit.residual)
    return float(min(noise + STALLED * (fit.chi2 - noise), fit.chi2 - TIE))


def beyond_ridges(
    search: Search, fit: Fit, least: Callable[[Fit], float] = lambda fit: fit.chi2 - 1.0
) -> Fit:
    """Return a fit from points along the axes of its covariance, if one comes further.

    Contacts that open and close give chi2 many valleys: steps end in the first of them. `least`
    says below which chi2 the end of another valley counts.
    """
    for _ in range(PARTNERS if fit.covariance.size else 0):
        sizes, axes = np.linalg.eigh(fit.covariance)
        steps = np.sqrt(np.maximum(sizes, 0.0)) * axes
        thetas = [fit.theta + by * step for by in _ALONG for step in steps.T]
        low, high = fit.bounds
        trials = [fit.unfitted(u) for u in thetas if ((low <= u) & (u <= high)).all()]
        seen = sorted(evaluate(search.problem, trials, residuals=False), key=chi2_of)
        # What comes back to where it is already is not followed to its end.
        most = least(fit)
        starts = [replace(one.unfitted(), limit=most) for one in seen[:FEW]]
        begun = sorted(fit_all(search.problem, starts, steps=FEW), key=chi2_of)
        end = min(fit_all(search.problem, begun[:1], steps=search.steps), key=chi2_of, default=fit)
        if end.chi2 > most:
            break
        fit = replace(end, limit=np.inf)
    return fit


def apart(fits: Sequence[Fit]) -> list[Fit]:
    """Leave out what has come to the same end as a fit of its model that stands before it.

    It has, where chi2 differs by less than 1 and no parameter by more than its deviation.
    """
    kept: list[Fit] = []
    for fit in fits:
        count = len(fit.model.free)
        spread = np.sqrt(np.diag(fit.covariance)[:count]) if fit.covariance.size else None
        if spread is None or not any(
            one.model.names == fit.model.names
            and abs(one.chi2 - fit.chi2) < 1.0
            and bool((np.abs(one.theta[:count] - fit.theta[:count]) <= spread).all())
            for one in kept
        ):
            kept.append(fit)
    return kept


def _near_best(fits: Sequence[Fit]) -> list[Fit]:
    """Leave out what lies far behind the best fit of the same model."""
    best: dict[tuple[str, ...], float] = {}
    for fit in fits:
        names = fit.model.names
        best[names] = min(best.get(names, np.inf), fit.chi2)
    return [f for f in fits if f.chi2 < 1.3 * best[f.model.names] + 20.0]


def _with_limits(
    search: Search,
    known: Collection,
    fits: Sequence[Fit],
    others: Sequence[Fit] = (),
    *,
    at_noise: bool,
    rival: Fit | None = None,
    beat: bool = False,
) -> list[Fit]:
    """Return fits with the chi2 that they have to reach to change a verdict.

    Where some fit leaves little but noise, that is about what it leaves: beside a model that is
    `at_noise` itself nothing ties, so a further effect has to gain. Far above the noise it is what
    the best set of as many effects leaves or, of an exchange for a `rival`, what takes its place;
    and what another law of one effect leaves, where one leaves but noise.
    Sets of several effects that are no exchange have to gain over the best smaller one, and with
    `beat` to take half of its rest.
    """
    best = min([*known.fits.values(), *others], key=search.score)
    count = min((len(fit.model.names) for fit in fits), default=0)
    if search.is_noise(best):
        tie = TIE if rival is not None else SLACK
        most = search.score(best) + (0.0 if at_noise else tie)
    elif rival is not None:
        most = takes_place(search, rival) + PENALTY * len(rival.model.free)
    else:
        # Single effects are all ranked, whatever the best one leaves.
        alike = known.of_size(count) if count > 1 else []
        most = min(map(search.score, alike), default=np.inf)
    most = min(most, known.law + SLACK)
    stalled = np.inf
    if rival is None:
        fewer = [fit for names, fit in known.fits.items() if 0 < len(names) < count]
        if fewer:
            smaller = min(fewer, key=lambda fit: total(search, fit))
            most = min(most, search.score(smaller) - LEAST_GAIN_FITTED)
            stalled = stalled_beside(search.problem, smaller) if beat else np.inf
    return [replace(fit, limit=min(most - PENALTY * len(fit.model.free), stalled)) for fit in fits]
