"""Sets of several effects: forward, exchange and backward steps."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import Fit, evaluate, fit_all
from locosweep.diagnosis.select.descent import takes_place
from locosweep.diagnosis.select.effort import LEAST_ERROR, LEVEL_WORK, PARTNERS
from locosweep.diagnosis.select.extension import extend, pairs
from locosweep.diagnosis.select.score import gains, remaining, stalled_beside, total
from locosweep.diagnosis.select.screen import pairs_along
from locosweep.diagnosis.select.thresholds import LEAST_GAIN, PENALTY, TIE
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from locosweep.diagnosis.select.search import Collection, Found, Search


def forward(
    search: Search, known: Collection, level: Sequence[Fit], found: Fit, *, rest: bool
) -> Collection:
    """Fit one effect more beside the best few if there is a rest, else beside the best.

    Returns what is known then.

    Parameters
    ----------
    search, known : Search, Collection
        What is searched, and what was found before.
    level : sequence of Fit
        Sets of as many effects as `found`, the best of them; best first.
    rest : bool
        Whether `found` leaves more than noise. Then effects of a pair are exchanged too; with
        more there are too many.
    """
    if not rest:
        return known.adding(extend(search, known, found, search.names, beat=True))
    pair = len(found.model.names) == 1
    along = pairs_along(search, PARTNERS) if pair else []
    larger = pairs(search, known, along) if pair else {}
    if larger and (
        _is_hopeless(search, found, along) or not remaining(search.problem, _best(search, larger))
    ):
        # What may do as well as the best pair is looked for where its effects are exchanged.
        return known.adding(larger)
    end = search.problem.meter.work + LEVEL_WORK * search.problem.count
    for base in _seeds(level):
        larger |= extend(search, known.adding(larger), base, search.names, beat=True)
        least = _best(search, larger).chi2 if larger else np.inf
        if least > stalled_beside(search.problem, found):
            # Of causes that are in the list, one takes away most of the rest by now.
            return known.adding(larger)
        if search.problem.meter.work > end:
            break
    known = known.adding(larger)
    return exchanged(search, known, _best(search, larger))[1] if pair and larger else known


def _is_hopeless(search: Search, found: Fit, along: Sequence[Fit]) -> bool:
    """Return whether no pair of effects makes the forces that the measured motion shows.

    `along` are the pairs that leave the least equation error, `found` is a fit whose residual shows
    the noise. What acts at rest changes no such error: a pair with such an effect leaves no less.
    `locosweep screen` prints these errors. Of the pairs of `locosweep blind-check --cases 1000
    --seed 17171` with `d_name` from 8 on, and of the practice cases, the best left a mean square of
    2.1 at most.
    """
    if search.along is None or not along:
        return False
    noise = noise_level(search.problem, found.residual) * search.along.measured.size
    return along[0].chi2 > LEAST_ERROR * noise


def _seeds(level: Sequence[Fit]) -> list[Fit]:
    """Fits to which a further effect is added."""
    seeds: list[Fit] = []
    for fit in level:
        # Twins of a seed give the same further fits.
        if all(abs(fit.chi2 - s.chi2) > 1e-3 * s.chi2 + TIE for s in seeds):
            seeds.append(fit)
    return seeds


def _best(search: Search, found: Mapping[frozenset[str], Fit]) -> Fit:
    return min(found.values(), key=lambda fit: total(search, fit))


def exchanged(search: Search, known: Collection, best: Fit) -> tuple[Fit, Collection]:
    """Exchange each effect of a set for every other one, while that helps.

    Returns the best set, and what is known then: rivals of that set among it, which differ from
    it by one effect.
    """
    end = search.problem.meter.work + LEVEL_WORK * search.problem.count
    known = known.adding({frozenset(best.model.names): best})
    while True:
        swaps: Found = {}
        names = frozenset(best.model.names)
        for name in best.model.names:
            if names - {name} in known.extended or search.problem.meter.work > end:
                continue
            base = without(search, best, name)
            # The same effect too: beside the others as they are, it may have another valley.
            swaps |= extend(search, known.adding(swaps), base, search.names, rival=best)
            known = known.having_extended(names - {name})
        known = known.adding(swaps)
        best = known.fits[names]
        new = _best(search, {names: best, **swaps})
        if not _takes_the_place(search, best, new):
            return best, known
        best = new


def _takes_the_place(search: Search, old: Fit, new: Fit) -> bool:
    """Return whether a set does so much better than another one that rivals are those of it.

    One with fewer parameters does if it scores better at all.
    """
    if remaining(search.problem, old):
        return new.chi2 < takes_place(search, old)
    margin = 0.0 if len(new.model.free) < len(old.model.free) else TIE
    return total(search, new) < total(search, old) - margin


def backward(search: Search, known: Collection, found: Fit) -> tuple[Fit, Collection]:
    """Leave out effects that a set does not need any more; return it, and what is known then."""
    for name in found.model.names if len(found.model.names) > 1 else ():
        (fewer,) = evaluate(search.problem, [without(search, found, name)])
        # Whatever the kept runs say of it, it does as well only below that.
        most = total(search, found) + LEAST_GAIN - PENALTY * len(fewer.model.free)
        (fewer,) = fit_all(search.problem, [replace(fewer, limit=most)], steps=30)
        fewer = replace(fewer, limit=np.inf)
        key = frozenset(fewer.model.names)
        if key not in known.fits or fewer.chi2 < known.fits[key].chi2:
            known = known.adding({key: fewer})
        if not gains(search, known.fits[key], found):
            return backward(search, known, known.fits[key])
    return found, known


def without(search: Search, found: Fit, name: str) -> Fit:
    """Return a set with one effect less, at the values it has, unfitted."""
    names = tuple(n for n in found.model.names if n != name)
    keep = [i for i, f in enumerate(found.model.free) if f.effect != name]
    others = list(range(len(found.model.free), found.theta.size))
    return Fit(search.model(names), found.nuisances, found.theta[keep + others])
