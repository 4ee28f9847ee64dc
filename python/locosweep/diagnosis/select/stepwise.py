"""Sets of several effects: forward, exchange and backward steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.diagnosis.estimate.least_squares import Fit, evaluate, fit_all
from locosweep.diagnosis.select.effort import LEVEL_WORK
from locosweep.diagnosis.select.extension import extend, extend_each, pairs
from locosweep.diagnosis.select.score import gains, remaining, total
from locosweep.diagnosis.select.thresholds import STALLED, TIE
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Collection, Found, Search


def is_stalled(problem: Problem, before: Fit, after: Fit) -> bool:
    """Return whether the last effect has left more than half of a rest far above the noise."""
    noise = problem.degrees() * noise_level(problem, after.residual)
    return after.chi2 - noise > max(STALLED * (before.chi2 - noise), noise)


def forward(
    search: Search, known: Collection, level: Sequence[Fit], found: Fit, *, rest: bool
) -> Found:
    """Fit one effect more beside the best few if there is a rest, else beside the best.

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
        return extend_each(search, known, [found])
    first = len(found.model.names) == 1
    larger = pairs(search, known) if first else {}
    if larger and not remaining(search.problem, _best(search, larger)):
        # Beside the best of them, what may do as well.
        seeds = [fit for fit in level if fit.model.names[0] in _best(search, larger).model.names]
        return larger | extend_each(search, known.adding(larger), seeds)
    larger |= extend_each(search, known.adding(larger), _seeds(level))
    return larger | _exchanged(search, known, larger) if first and larger else larger


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


def _exchanged(search: Search, known: Collection, level: Found) -> Found:
    """Exchange each effect of the best set for every other one, while that helps much."""
    level = dict(level)
    end = search.problem.meter.work + LEVEL_WORK * search.problem.count
    while True:
        best = _best(search, level)
        if not remaining(search.problem, best):
            break
        for name in best.model.names:
            if search.problem.meter.work > end:
                break
            base = without(search, best, name)
            others = [n for n in search.names if n != name]
            level |= extend(search, known.adding(level), base, others, beat=True, rival=best)
        if _best(search, level).chi2 > 0.5 * best.chi2:
            break
    return level


def backward(search: Search, known: Collection, found: Fit) -> tuple[Fit, Collection]:
    """Leave out effects that a set does not need any more; return it, and what is known then."""
    for name in found.model.names if len(found.model.names) > 1 else ():
        (fewer,) = evaluate(search.problem, [without(search, found, name)])
        (fewer,) = fit_all(search.problem, [fewer], steps=30)
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
