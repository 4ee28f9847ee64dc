"""Forward steps of a search: single effects, one more beside those found, pairs."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import goes_with
from locosweep.diagnosis.estimate.least_squares import chi2_of, evaluate, fit_all, start_fits
from locosweep.diagnosis.select.descent import beyond_ridges, descend, follow_limit
from locosweep.diagnosis.select.effort import (
    FEW,
    LEAST_ERROR,
    PARTNERS,
    ROWS_REPLAYED,
    SHARE,
    SLACK,
)
from locosweep.diagnosis.select.score import stalled_above
from locosweep.diagnosis.select.screen import (
    Screened,
    along_valley,
    distinct,
    informative_runs,
    mean_square,
    pairs_beside,
    rows_beside,
    scaled,
    scan_beside,
    seen_along,
)
from locosweep.diagnosis.select.search import Collection, Found
from locosweep.diagnosis.select.thresholds import LEAST_GAIN_FITTED, TIE
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from collections.abc import Collection as Names
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.select.search import Search

    Floats = NDArray[np.float64]

_CHANGES = np.geomspace(1e-4, 0.5, 27)
"""Changes of a threshold that are tried, in sizes of the parameter or in its logarithm: from what
a sample resolves of a motion to all of its range, each a third larger than the last."""


def singles(search: Search) -> Collection:
    """Fit every effect alone, from several starts; the best ones again from around their ends."""
    known = Collection({frozenset(): search.none})
    found = extend(search, known, None, search.names)
    best = sorted(found.values(), key=chi2_of)[:FEW]
    near = [fit for fit in best if fit.chi2 < best[0].chi2 + SLACK]
    found |= {frozenset(fit.model.names): beyond_ridges(search, fit) for fit in near}
    return known.adding(found)


def extend(
    search: Search,
    known: Collection,
    base: Fit | None,
    partners: Sequence[str],
    *,
    beat: bool = False,
    rival: Fit | None = None,
) -> Found:
    """Fit `base` with each of `partners` beside it; only those that promise most after a scan.

    Without a base, effects are fitted alone. With `beat`, only those are fitted that promise to
    come near the best set of as many effects, and none if no effect promises half of a rest that is
    clearly more than noise; with a `rival`, those that promise half of what it gains. Returns the
    best fit of each set.
    """
    problem = search.problem
    held = base.model.names if base else ()
    partners = [p for p in partners if goes_with(p, held)]
    if not partners:
        return {}
    beside = base or search.none
    if not beside.residual.size:
        (beside,) = evaluate(problem, [beside])
    at_noise = search.is_noise(beside)
    # Beside what leaves but noise, only free runs are long enough to show anything.
    along = {} if at_noise else seen_along(search, beside, partners)
    before = mean_square(search, beside) if along else 0.0
    sure = along.keys() if before > LEAST_ERROR else set()
    if base is not None and sure:
        partners = _gaining(search, partners, along, before, rival)
    starts = _starts_beside(search, beside, partners, along, sure)
    runs = informative_runs(problem, beside)
    seen, leaves = scan_beside(problem, starts, runs, beside)
    if at_noise:
        seen = _below(seen, leaves - LEAST_GAIN_FITTED, every=base is None)
    groups = [[s for s in seen if s.fit.model.names[-1] == name] for name in partners]
    limit = _to_beat(search, known, len(held) + 1, runs) if beat else np.inf
    least = min((start.promised for start in seen), default=np.inf)
    if beat and not at_noise and least > stalled_above(leaves, *_noise_of(search, beside, runs)):
        return {}
    if rival is not None:
        least = min(least, evaluate(problem, [rival.unfitted()], runs)[0].chi2)
    # What promises less than half of the best one's gain is no rival of it.
    worth = max(leaves - SHARE * (leaves - least), least + TIE)
    if base is not None:
        limit = min(limit, worth)
    best = [min(group, key=lambda s: s.promised) for group in groups if group]
    followed: list[Fit] = []
    for start in sorted(best, key=lambda s: s.promised)[: PARTNERS if held else None]:
        if start.promised > limit:
            break
        if start.promised > worth:
            # An effect alone has a fit whatever it promises.
            followed.append(scaled(start.fit, start.factor))
            continue
        own = [s for s in seen if s.fit.model.names == start.fit.model.names]
        # What promises most, as strong as it promises it; and as it stands, the best start.
        most = 1 if start.fit.model.names[-1] in sure else FEW
        followed += [
            scaled(s.fit, s.factor) for s in distinct(sorted(own, key=lambda s: s.promised), most)
        ]
        if not at_noise:
            followed.append(min((s.fit for s in own), key=chi2_of))
    if base is None:
        likely = sorted(along, key=lambda name: along[name][0].chi2)[:FEW]
        followed += [end for name in likely for end in _valley_end(search, along[name][0], runs)]
    found = descend(
        search, known, followed, runs, beside, at_noise=at_noise, rival=rival, beat=beat
    )
    if base is None and not at_noise:
        found |= _thresholds_found(search, found, along)
    return found


def _noise_of(search: Search, beside: Fit, runs: list[int]) -> tuple[float, int]:
    """Return the chi2 of the noise in some runs, and the number of their residuals."""
    count = search.problem.degrees(runs)
    return count * noise_level(search.problem, beside.residual), count


def _gaining(
    search: Search,
    partners: Sequence[str],
    along: Mapping[str, Sequence[Fit]],
    before: float,
    rival: Fit | None,
) -> list[str]:
    """Leave out what gains less than half as much along the motion as the best one, or a rival.

    What the equation error does not see stays. `before` is the mean square of that error without.
    """
    size = search.along.measured.size if search.along else 1
    gained = {name: before - fits[0].chi2 / size for name, fits in along.items()}
    most = max(gained.values())
    if rival is not None:
        most = max(most, before - mean_square(search, rival))
    return [p for p in partners if p not in gained or gained[p] >= SHARE * most]


def _thresholds_found(search: Search, found: Found, along: Names[str]) -> Found:
    """Fit the best single effects that act at rest again, if none has come to noise."""
    if not found or search.is_noise(min(found.values(), key=chi2_of)):
        return {}
    unseen = sorted((f for names, f in found.items() if not names & set(along)), key=chi2_of)
    least = min(fit.chi2 for fit in found.values())
    return {frozenset(fit.model.names): _rescanned(search, fit, least) for fit in unseen[:FEW]}


def _rescanned(search: Search, fit: Fit, least: float) -> Fit:
    """Return a fit from other values of single parameters, near and far, if one comes further.

    A threshold of what acts at rest has no derivative: steps leave it where it was, and
    few runs may not show it. `least` is the chi2 of the best effect: values that show too
    little to come near it are not followed. A round has to make up a share of what the fit is
    behind it, such that all rounds could make up the whole, or it is the last one.
    """
    most = follow_limit(search.none, least)
    changes = np.outer(_CHANGES, (-1.0, 1.0)).ravel()
    for _ in range(PARTNERS):
        if search.is_noise(fit):
            break
        trials: list[Fit] = []
        thresholds: list[Fit] = []
        for i, free in enumerate(fit.model.free):
            found = _changed(fit, i, changes * (1.0 if free.log else free.size))
            trials += found
            thresholds += found if _is_unknown(fit, i) else []
        # The farthest of those that are as good: within a step of a threshold nothing changes.
        seen = evaluate(search.problem, trials[::-1], residuals=False)
        if thresholds:
            # The other parameters answer to a threshold, and hide what it would gain.
            seen += fit_all(search.problem, thresholds[::-1], steps=FEW)
        seen.sort(key=chi2_of)
        # What cannot come as far as another round asks for is not followed to its end.
        worth = fit.chi2 - max(fit.chi2 - least, 0.0) / PARTNERS
        starts = [replace(one.unfitted(), limit=worth) for one in seen[:FEW] if one.chi2 < most]
        end = min(fit_all(search.problem, starts, steps=search.steps), key=chi2_of, default=fit)
        if end.chi2 >= fit.chi2:
            break
        gain, fit = fit.chi2 - end.chi2, replace(end, limit=np.inf)
        if gain < (fit.chi2 - least) / PARTNERS:
            break
    return fit


def _changed(fit: Fit, i: int, changes: Floats) -> list[Fit]:
    """Return unfitted fits in which one parameter differs."""
    low, high = fit.bounds
    found = []
    for change in changes:
        theta = fit.theta.copy()
        theta[i] = np.clip(theta[i] + change, low[i], high[i])
        found.append(fit.unfitted(theta))
    return found


def _is_unknown(fit: Fit, i: int) -> bool:
    """Return whether derivatives say nothing of a parameter within its bounds."""
    low, high = fit.bounds
    return bool(fit.covariance.size and fit.covariance[i, i] > (high[i] - low[i]) ** 2)


def _valley_end(search: Search, fit: Fit, runs: Sequence[int]) -> list[Fit]:
    """Return the best end of starts along a fit's valley, if it has one.

    Each stands alone: beside better ones, slow steps along a valley that bends would end.
    """
    starts = along_valley(search.along, fit) if search.along else []
    ends = fit_all(search.problem, starts, runs=runs, steps=search.steps, least=None)
    return [min(ends, key=chi2_of).unfitted()] if ends else []


def _starts_beside(
    search: Search,
    beside: Fit,
    partners: Sequence[str],
    along: Mapping[str, Sequence[Fit]],
    sure: Names[str],
) -> list[Fit]:
    """Return starts of further effects beside the values of a fit.

    Those `along` the measured motion come first; few others are replayed beside them of the
    effects whose start they are `sure` of.
    """
    found: list[Fit] = []
    for name in partners:
        best = along.get(name, [])
        rows = rows_beside(search, name, beside)
        # All starts of an effect that is tried alone; else a few for each of its parameters.
        own = len(search.model((name,)).free)
        wide = own * ROWS_REPLAYED if beside.model.names else len(rows)
        most = ROWS_REPLAYED if name in sure else wide
        # With those at the ends: the strongest ones.
        spread = np.unique(np.linspace(0, len(rows) - 1, min(most, len(rows))).round().astype(int))
        starts = [fit.unfitted() for fit in best] + [rows[i] for i in spread]
        if best and search.along:
            starts += along_valley(search.along, best[0])
        model = starts[0].model
        for row in search.hinted(model):
            starts += start_fits(search.nuisances, model, row[None], beside.nuisance)
        if not beside.model.names and search.nuisances.uncertain:
            # The nominal model's uncertain values may be fitted to the gap.
            starts += [
                fit
                for one in starts
                for fit in start_fits(search.nuisances, model, one.parameters[None])
            ]
        found += starts
    return found


def _below(starts: Sequence[Screened], limit: float, *, every: bool) -> list[Screened]:
    """Pick the starts that may come below a limit; and the best one of `every` model."""
    best: dict[tuple[str, ...], Screened] = {}
    for start in starts:
        names = start.fit.model.names
        if names not in best or start.fit.chi2 < best[names].fit.chi2:
            best[names] = start
    some = set(best.values()) if every else set()
    return [start for start in starts if start.promised <= limit or start in some]


def _to_beat(search: Search, known: Collection, count: int, runs: list[int]) -> float:
    """Chi2 on some runs that a further set of so many effects has to promise."""
    alike = [fit for names, fit in known.fits.items() if len(names) == count]
    if count == 1 or not alike:
        return np.inf
    (same,) = evaluate(search.problem, [min(alike, key=chi2_of).unfitted()], runs)
    return (1.0 + SHARE) * same.chi2 + SLACK


def pairs(search: Search, known: Collection, along: Sequence[Fit]) -> Found:
    """Fit the pairs that leave least: neither effect need stand out alone.

    `along` are starts of those that leave the least equation error.
    """
    none = search.none
    runs = informative_runs(search.problem, none)
    found = [*along, *pairs_beside(search, known.of_size(1), runs)[:PARTNERS]]
    return descend(search, known, [fit.unfitted() for fit in found], runs, none, beat=True)
