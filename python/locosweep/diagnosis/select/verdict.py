"""The choice: which set of effects, what else fits as well, how sure that is."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import VARIABLES
from locosweep.diagnosis.estimate.least_squares import Fit, point_of
from locosweep.diagnosis.select.law_mismatch import (
    UNLISTED,
    bent_from,
    carried_by,
    carries,
    elsewhere,
)
from locosweep.diagnosis.select.nonparametric import Flexible
from locosweep.diagnosis.select.score import GAIN, gains, rest_of, total
from locosweep.diagnosis.select.stepwise import deepened, hopeless, pruned, without
from locosweep.diagnosis.select.whiteness import blocks_of, lack_of, noise_level
from locosweep.diagnosis.select.window_search import WindowSearches

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.diagnosis.select.search import Search
    from locosweep.diagnosis.select.whiteness import Lack

__all__ = ["Choice", "choose"]

TIE = 12.0
"""Difference in chi2 below which two explanations tie: effects that lie 2 deviations
apart differ by less in 99 of 100 sets of runs."""
_LEFT, _FAR_OFF = 0.05, 9.0
"""Share of the squares of a gap, and squares over those of noise, that an explanation does
not leave."""
_STAYS = 0.3
"""Share of what a gap has beyond noise that no explanation leaves where that is seen."""
_MOST_ALIKE = 3
"""Causes that may tie where none of them has the law that was met: more than these say
that no variable in particular carries it."""
_WIDER = 6.0
"""What a wider law has to gain in chi2 by each of its further parameters before it rivals
its own limit."""
_FEWER = 6.0
"""What several effects have to gain in chi2 over another law of one cause."""
_OTHER_LAW = 0.55
"""Probability of a cause by another law than its formula: right in 13 of 22, 2 of 8 and, once this
was set, 8 of 15 verdicts of the blind check. It bends to what else pushes along the way as well."""
TEMPER = 1.5
"""Differences in chi2 count for this much less than noise alone would have it."""


@dataclass
class Choice:
    """What the fits say.

    `fit` is the chosen one; `classes` holds for each of its effects all that tie
    with it; `sets` other complete explanations of the same size.
    """

    status: str
    fit: Fit
    lack: Lack
    classes: list[list[str]] = field(default_factory=list)
    sets: list[list[str]] = field(default_factory=list)
    law_mismatch: bool = False
    probability: float = 1.0
    ranked: list[tuple[Fit, float]] = field(default_factory=list)
    shape: list[tuple[str, float]] = field(default_factory=list)
    near: float = 0.0
    """What the best further effect would gain: not enough, or not where it is fitted."""

    unlisted: str = ""
    """A variable that no listed effect acts through, and that does as well as several of them."""

    missed: bool = False
    """Whether the fit leaves of the runs kept from it what the others do not show."""

    @property
    def refuted(self) -> bool:
        """Whether the runs kept from the fit ask for more than the others do."""
        return self.status != "unexplained" and (self.near >= GAIN or self.missed)


def choose(search: Search, most: int) -> Choice:
    """Search for the smallest set of effects that leaves only noise.

    Parameters
    ----------
    search : Search
        Fits of one set of runs.
    most : int
        Effects at once, at most.
    """
    problem = search.problem
    none = search.none
    search.report("single effects")
    singles = search.singles()
    windows = None
    if singles and search.leaves_much(singles[0]):
        windows = WindowSearches(search)
        windows.singles()
        singles = search.leaped()
    singles.sort(key=lambda fit: total(search, fit))
    best = singles[0] if singles else none
    if not gains(search, none, best):
        rest = rest_of(problem, none)
        status = "unexplained" if rest else "none"
        lack, near = lack_of(problem, none.residual), total(search, none) - total(search, best)
        choice = Choice(status, none, lack, shape=rest, near=near)
        return _with_ranks(search, choice, [none, *singles])
    level = singles
    mismatch = False
    before, found = none, best
    near = score = 0.0
    for count in range(2, most + 2):
        rest = rest_of(problem, found)
        # Other laws of several effects at once could be bent to anything.
        carried = carried_by(search, level) if rest and count == 2 else None
        deeper: list[Fit] = []
        if count <= most and not (count > 2 and hopeless(problem, before, found)):
            search.report(f"{count} effects at once")
            wide = bool(rest) and count == 2 and not carried
            deeper = deepened(
                search, level, found, rest=bool(rest), wide=wide, windows=windows if wide else None
            )
            near = total(search, found) - total(search, deeper[0]) if deeper else 0.0
            deeper = [fit for fit in deeper if gains(search, found, fit)]
        if carried and not (deeper and search.score(deeper[0]) < carried[0] - _FEWER):
            # What further effects would gain is what the law does not fit.
            (score, found), mismatch, near = carried, True, 0.0
            break
        if not deeper:
            break
        before, level, found, near = found, deeper, pruned(search, deeper[0]), 0.0
        if len(found.model.names) < count and not rest_of(problem, found):
            break
    rest = [] if mismatch else rest_of(problem, found)
    lack = lack_of(problem, found.residual)
    if rest:
        choice = Choice("unexplained", found, lack, shape=rest)
        return _with_ranks(search, choice, [none, *singles, *level])
    score = score if mismatch else search.score(found)
    if (mismatch or len(found.model.names) > 1) and elsewhere(search, found, score):
        choice = Choice("unexplained", found, lack, unlisted=UNLISTED)
        return _with_ranks(search, choice, [none, *singles, *level])
    search.report("rivals")
    rivals = _rivals(search, found)
    classes, sets = _classes(search, found, rivals, mismatch)
    bent = bent_from(search, found, classes)
    if bent:
        found, mismatch, near = bent, True, 0.0
        lack = lack_of(problem, found.residual)
        rivals = _rivals(search, found)
        classes, sets = _classes(search, found, rivals, mismatch)
    if mismatch and any(len({VARIABLES.get(n, n) for n in c}) > _MOST_ALIKE for c in classes):
        choice = Choice("unexplained", found, lack, shape=rest_of(problem, found))
        return _with_ranks(search, choice, [none, *singles, *level, *rivals])
    status = "explained" if all(len(c) == 1 for c in classes) and not sets else "ambiguous"
    missed = (not mismatch or bent is not None) and _misses(search, found)
    choice = Choice(status, found, lack, classes, sets, mismatch, near=near, missed=missed)
    return _with_ranks(search, choice, [none, *singles, *level, *rivals])


def _misses(search: Search, fit: Fit) -> bool:
    """Whether a fit leaves much of a gap, and more than noise, where it has not seen it."""
    if not search.judges:
        return False
    problem = search.problem
    squares = []
    for one in (search.none, fit):
        e = problem.unseen([point_of(problem, one)])[0]
        squares.append(float(e @ e))
    before, after = squares
    if after > max(_LEFT * before, _FAR_OFF * e.size):
        return True
    if not problem.held or not lack_of(problem, e, problem.held).is_there:
        return False
    counted = sum(values.size for _, _, values in blocks_of(problem, e, problem.held))
    floor = counted * noise_level(problem, fit.residual)
    return bool(before > floor and after - floor > _STAYS * (before - floor))


def _rivals(search: Search, found: Fit) -> list[Fit]:
    """Refit with every other effect in place of each one of the set."""
    rivals: dict[frozenset[str], Fit] = {}
    for name in found.model.names:
        if len(found.model.names) > 1:
            base = without(search, found, name)
            swaps = search.extend(base, [n for n in search.names if n != name])
        else:
            swaps = [search.fits[frozenset({n})] for n in search.names]
        for fit in swaps:
            rivals[frozenset(fit.model.names)] = fit
    # What was fitted on the way to the set counts as well.
    names = frozenset(found.model.names)
    for key, fit in search.fits.items():
        if len(key) == len(names) and len(key & names) == len(names) - 1:
            rivals[key] = fit
    rivals.pop(names, None)
    return sorted(rivals.values(), key=lambda fit: total(search, fit))


def is_limit(fit: Fit, name: str) -> bool:
    """Whether an effect's shape has gone to an end of its range.

    Then it is another effect's limit, not a rival of its own. An effect of one parameter has
    no shape: at the end of its range it is next to nothing, or as much as it can be.
    """
    if sum(f.effect == name for f in fit.model.free) < 2:
        return False
    for i, f in enumerate(fit.model.free):
        if f.effect != name or not f.log:
            continue
        low, high = np.log(f.low), np.log(f.high)
        edge = 0.02 * (high - low)
        if fit.theta[i] < low + edge or fit.theta[i] > high - edge:
            return True
    return False


def _classes(
    search: Search, found: Fit, rivals: Sequence[Fit], mismatch: bool
) -> tuple[list[list[str]], list[list[str]]]:
    names = found.model.names
    reference = total(search, found)
    tie = TIE
    if mismatch:
        # A law that does not fit leaves more than noise, and so may its rivals.
        own = list(dict.fromkeys(VARIABLES[n] for n in names if n in VARIABLES))
        left = Flexible(search.problem, found).left(own)
        tie += 0.25 * (found.chi2 - float(left @ left))
    classes = [[name] for name in names]
    sets: list[list[str]] = []
    for rival in rivals:
        if total(search, rival) - reference > tie:
            continue
        new = [n for n in rival.model.names if n not in names]
        gone = [n for n in names if n not in rival.model.names]
        if len(new) != 1 or len(gone) != 1 or is_limit(rival, new[0]):
            continue
        place = names.index(gone[0])
        mine = sum(f.effect == gone[0] for f in found.model.free)
        theirs = sum(f.effect == new[0] for f in rival.model.free)
        narrower = theirs > mine and found.chi2 - rival.chi2 < _WIDER * (theirs - mine)
        if narrower and _contains(rival, new[0], mine):
            continue
        other = VARIABLES.get(new[0]) not in {VARIABLES.get(n) for n in names}
        if mismatch and other and carries(search, rival) is None:
            continue
        if new[0] not in classes[place]:
            classes[place].append(new[0])
    for key, fit in search.fits.items():
        if len(key) != len(names) or key == frozenset(names):
            continue
        if len(key & set(names)) >= len(names) - 1 and len(names) > 1:
            continue
        if len(names) > 1 and total(search, fit) - reference <= tie:
            sets.append(sorted(key))
    return classes, sets


def _contains(rival: Fit, name: str, few: int) -> bool:
    """Whether the rival has freedom that the data do not use.

    A wider law that ties is the narrower one's limit when its parameters can all be
    seen; where part of it cannot be seen at all it is a rival.
    """
    rows = [i for i, f in enumerate(rival.model.free) if f.effect == name]
    spread = np.sqrt(np.diag(rival.covariance)) if rival.covariance.size else np.zeros(0)
    if not spread.size:
        return True
    seen = sum(spread[i] < rival.model.free[i].size for i in rows)
    return bool(seen > few)


def _with_ranks(search: Search, choice: Choice, fits: Sequence[Fit]) -> Choice:
    """Order the fits, and weigh them against each other."""
    unique = {frozenset(f.model.names): f for f in fits}
    unique[frozenset(choice.fit.model.names)] = choice.fit
    ranked = sorted(unique.values(), key=lambda fit: total(search, fit))
    scores = np.array([total(search, fit) for fit in ranked])
    # Sets that leave more than noise are no explanations, however they rank.
    weights = np.exp(-0.5 * (scores - scores.min()) / TEMPER)
    weights /= weights.sum()
    choice.ranked = list(zip(ranked, weights.tolist(), strict=True))
    choice.probability = _probability(search, choice)
    return choice


def _probability(search: Search, choice: Choice) -> float:
    none = total(search, search.none)
    if choice.status == "none":
        best = min((total(search, f) for f, _ in choice.ranked if f.model.names), default=none)
        missed = 0.5 * np.exp(-0.5 * max(GAIN - (none - best), 0.0) / 4.0)
        return float(np.clip(1.0 - missed - 0.02, 0.5, 0.98))
    if choice.status == "unexplained":
        sure = choice.lack.deviations
        return float(np.clip(1.0 - 0.4 * np.exp(-(sure - 5.0) / 4.0) - 0.05, 0.5, 0.95))
    if choice.law_mismatch:
        # Scores weigh formulas that do not fit: they say nothing about the cause.
        return _OTHER_LAW
    inside = 0.0
    allowed = [set(c) for c in choice.classes]
    sets = [set(s) for s in choice.sets]
    for fit, weight in choice.ranked:
        names = set(fit.model.names)
        if names != set(choice.fit.model.names) and any(is_limit(fit, n) for n in names):
            # Another effect's limit speaks for that effect.
            inside += weight
            continue
        fits_class = len(names) == len(allowed) and all(names & c for c in allowed)
        # Wider laws and supersets of the chosen one are not against it.
        if fits_class or names in sets or names >= set(choice.fit.model.names):
            inside += weight
    gain = none - total(search, choice.fit)
    found = 1.0 - 0.5 * np.exp(-0.5 * max(gain - GAIN, 0.0) / 4.0)
    # A further effect that nearly gains what is asked for may well be there.
    found /= 1.0 + np.exp(min((choice.near - GAIN) / 4.0, 50.0))
    return float(np.clip(0.98 * inside * found, 0.01, 0.98))
