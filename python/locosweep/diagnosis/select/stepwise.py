"""Sets of several effects: one more, one in place of another, one less."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.diagnosis.estimate.least_squares import Fit, evaluate, fit_all
from locosweep.diagnosis.select.score import gains, rest_of, total
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Search
    from locosweep.diagnosis.select.window_search import WindowSearches

__all__ = ["deepened", "hopeless", "pruned", "without"]

_ALIKE = 12.0
"""Difference in chi2 below which seeds are taken for twins."""
_FAR = 30.0
"""Single effects that leave this many times more than the best are no part of a pair."""
_WIDE = 12
"""Single effects that are tried as part of a pair."""
_PAIRS = 24
"""Pairs that are tried where neither effect need stand out alone."""
_SWAPS = 2
"""Times that effects of a set that leaves a rest are put in place of each other."""
_BUDGET = 6.0
"""Replays beyond which they are not, in those of the singles."""


def _seeds(level: Sequence[Fit], count: int) -> list[Fit]:
    """Fits to which a further effect is added."""
    seeds: list[Fit] = []
    for fit in level:
        # Twins of a seed give the same further fits.
        if all(abs(fit.chi2 - s.chi2) > 1e-3 * s.chi2 + _ALIKE for s in seeds):
            seeds.append(fit)
        if len(seeds) == count:
            break
    return seeds


def hopeless(problem: Problem, before: Fit, after: Fit) -> bool:
    """Whether the last effect has left more than half of a rest far above the noise.

    One more would not bring it down to noise either.
    """
    noise = problem.degrees() * noise_level(problem, after.residual)
    return after.chi2 - noise > max(0.5 * (before.chi2 - noise), noise)


def deepened(
    search: Search,
    level: Sequence[Fit],
    found: Fit,
    *,
    rest: bool,
    wide: bool,
    windows: WindowSearches | None,
) -> list[Fit]:
    """Fit one effect more beside the best few if there is a rest, else beside the best.

    Beside many where `wide` and those few do not do; also in `windows`, if given. Effects of
    a pair are put in place of each other too; with more there are too many. Best first.
    """
    seeds = _seeds(level, 4 if rest else 1)
    deeper = sorted(search.deepen(seeds, len(seeds)), key=lambda fit: total(search, fit))
    if windows and deeper and search.leaves_much(deeper[0]):
        deeper = _unique(search, [*deeper, *windows.deepened(seeds)])
    if rest and deeper and len(found.model.names) == 1:
        deeper = _swapped(search, deeper)
    if wide and deeper and rest_of(search.problem, deeper[0]):
        # The parts of a pair need not stand first when each is tried alone.
        deeper = _swapped(search, _unique(search, [*deeper, *search.together(_PAIRS)]))
    if wide and deeper and rest_of(search.problem, deeper[0]):
        more = [s for s in _seeds(level, _WIDE) if s not in seeds and s.chi2 < _FAR * found.chi2]
        deeper = _unique(search, [*deeper, *search.deepen(more, len(more))])
    return deeper


def _unique(search: Search, fits: Sequence[Fit]) -> list[Fit]:
    """Return the best fit of each set; best first."""
    sets = dict.fromkeys(frozenset(fit.model.names) for fit in fits)
    return sorted((search.fits[key] for key in sets), key=lambda fit: total(search, fit))


def _swapped(search: Search, level: list[Fit]) -> list[Fit]:
    """Put every other effect in place of each one of the best set, while that helps much.

    What stood first alone may have stood in for what is there.
    """
    for _ in range(_SWAPS):
        best = level[0]
        if not rest_of(search.problem, best):
            break
        for name in best.model.names:
            if search.problem.meter.samples > _BUDGET * search.spent:
                break
            base = without(search, best, name)
            others = [n for n in search.names if n != name]
            level += search.extend(base, others, beat=True)
        level = _unique(search, level)
        if level[0].chi2 > 0.5 * best.chi2:
            break
    return level


def pruned(search: Search, found: Fit) -> Fit:
    """Leave out what a set, found one by one, does not need any more."""
    for name in found.model.names if len(found.model.names) > 1 else ():
        fewer = without(search, found, name)
        evaluate(search.problem, [fewer])
        fit_all(search.problem, [fewer], steps=30)
        key = frozenset(fewer.model.names)
        if key not in search.fits or fewer.chi2 < search.fits[key].chi2:
            search.fits[key] = fewer
        if not gains(search, search.fits[key], found):
            return pruned(search, search.fits[key])
    return found


def without(search: Search, found: Fit, name: str) -> Fit:
    """Return a set with one effect less, at the values it has."""
    names = tuple(n for n in found.model.names if n != name)
    keep = [i for i, f in enumerate(found.model.free) if f.effect != name]
    tail = list(range(len(found.model.free), found.theta.size))
    return Fit(search.model(names), found.nuisances, found.theta[keep + tail])
