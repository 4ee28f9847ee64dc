"""Another law of the same cause, and causes that are in no list."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import VARIABLES
from locosweep.diagnosis.estimate.least_squares import Fit, evaluate, fit_all
from locosweep.diagnosis.select.nonparametric import Flexible
from locosweep.diagnosis.select.score import GAIN
from locosweep.diagnosis.select.whiteness import lack_of, noise_level

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Search

__all__ = ["UNLISTED", "bent_from", "carried_by", "carries", "elsewhere"]

_CARRIED = 6
"""Fits whose own variables are tried on what they leave."""
_MOST_CARRIED = 10
"""Such fits at most, with those by other variables."""
_MOST_WORTH = 3
"""Variables beside a fit whose effects are tried next."""
_AS_WELL = 12.0
"""How much less than another variable the own one may be worth."""
_ONE_LAW = 25.0
"""How much less than a law of its own in each run one for all may be worth: each of those bends
to what the formula's refit leaves in its run."""
UNLISTED = "terrain"
"""A force by the place alone, whichever way the head goes: a tether, a magnet, a bump."""
_STRANGE = 3
"""Fewer than one run in so many may go another way than the others foretell."""
_BEYOND = 4.0
"""Deviations by which what the other runs foretell may miss, all in all."""
_BENT = 0.02
"""Share of a gap below which an effect through another one's variable is no cause of its own."""


def carried_by(search: Search, level: Sequence[Fit]) -> tuple[float, Fit] | None:
    """Find the fit that its own effects' variables bring down to noise, and furthest.

    Tried are the best fits, and what acts through the variables that would carry most beside
    them: far off by its own formula, a cause may stand behind many others.

    Returns it with its score, a price on every term included.
    """
    tried = list(level[:_CARRIED])
    found = []
    for i, fit in enumerate(tried):
        score, others = _carried(search, fit)
        if score is not None:
            found.append((score, i))
        # No effect acts through some: a force by the place alone, an acceleration.
        others = [v for v in others if v in VARIABLES.values()]
        for variable in others[:_MOST_WORTH]:
            new = (f for f in level if variable in _variables(f) and all(f is not g for g in tried))
            tried += islice(new, int(len(tried) < _MOST_CARRIED))
    if not found:
        return None
    score, i = min(found)
    return score, tried[i]


def carries(search: Search, fit: Fit) -> float | None:
    """Score of a fit with other laws of its effects; none where those do not do.

    They have to carry what is left as well as any other variable would: what is small
    enough to fit into everything says nothing about its cause.
    """
    return _carried(search, fit)[0] if _variables(fit) else None


def _variables(fit: Fit) -> list[str]:
    return list(dict.fromkeys(VARIABLES[n] for n in fit.model.names if n in VARIABLES))


def _carried(search: Search, fit: Fit) -> tuple[float | None, list[str]]:
    """Score of a fit with other laws, and what carries something beside it, the most first."""
    own = _variables(fit)
    problem = search.problem
    terms = Flexible(problem, fit)
    left = terms.left(own)
    noise = noise_level(problem, left)
    worth = terms.worth(own, noise)
    others = {v: terms.worth([v], noise) for v in terms.variables if v not in own}
    most = sorted((v for v in others if others[v] > 0.0), key=lambda v: -others[v])
    if not own or worth < max(others.values(), default=0.0) - _AS_WELL:
        return None, most
    if lack_of(problem, left).is_there or terms.found(own, noise):
        return None, most
    if terms.foreseen(own, noise) <= 0.0 or not _holds(problem, fit, own, noise):
        return None, most
    return search.score(fit) - worth * noise, most


def _holds(problem: Problem, fit: Fit, own: Sequence[str], noise: float) -> bool:
    """Whether another law, known from the other runs, leaves but noise in a run.

    Noise, and what those runs cannot tell of it. It has to in those that were kept from the
    fit, taken together, and in most of the others: none of the rest may go where one went.
    Where none was kept, in all together. And one law for all runs has to be worth as much
    as one of its own in each: what no run confirms is no law.
    """
    whole = copy(problem)
    whole.held, whole.fitted = (), list(range(len(problem.runs)))
    # Runs kept from the fit may start in motion, too.
    moving = fit.nuisances.moving
    late = tuple(r for r in problem.starting if r in problem.held and r not in moving)
    at = len(fit.model.free) + len(fit.nuisances.shares) + len(moving)
    same = Fit(
        fit.model,
        replace(fit.nuisances, moving=(*moving, *late)),
        np.insert(fit.theta, [at] * len(late), 0.0),
    )
    if late:
        fit_all(whole, [same], steps=8)
    else:
        evaluate(whole, [same])
    terms = Flexible(whole, same)
    if terms.worth(own, noise) < terms.worth_apart(own, noise) - _ONE_LAW:
        return False
    left = terms.foretold(own, noise)
    strange = sum(lack_of(whole, e, [r]).is_there for r, e in enumerate(left))
    kept = list(problem.held) or whole.fitted
    together = _together(whole, [left[r] for r in kept], kept)
    beyond = lack_of(whole, together, kept).deviations
    return _STRANGE * strange < len(left) and beyond < _BEYOND


def _together(
    problem: Problem, parts: Sequence[NDArray[np.float64]], runs: Sequence[int]
) -> NDArray[np.float64]:
    """Join residuals of single runs: channel by channel, run by run."""
    rows = []
    for c in range(len(problem.channels)):
        for part, r in zip(parts, runs, strict=True):
            n = int(problem.lengths[r])
            rows.append(part[c * n : (c + 1) * n])
    return np.concatenate(rows)


def elsewhere(search: Search, found: Fit, score: float) -> bool:
    """Whether one force along the way would do as well as several effects or another law.

    It has to do better than one of them beside the others; as well as all of them is
    enough, being one cause in place of several.
    """
    names = frozenset(found.model.names)
    sets = dict.fromkeys([frozenset[str](), *(names - {name} for name in names)])
    noise = noise_level(search.problem, found.residual)
    for fit in (search.fits[key] for key in sets if key in search.fits):
        worth = Flexible(search.problem, fit).worth([UNLISTED], noise)
        margin = 0.0 if fit.model.names else GAIN
        if search.score(fit) - worth * noise < score + margin:
            return True
    return False


def bent_from(search: Search, found: Fit, classes: Sequence[Sequence[str]]) -> Fit | None:
    """Find the set without an effect that only bends the law of another one.

    Two effects through one variable, of which one adds next to nothing: that is one
    cause, by another law than its formula.
    """
    names = found.model.names
    for name, alike in zip(names, classes, strict=True):
        rest = frozenset(names) - {name}
        fewer = search.fits.get(rest)
        if not rest or fewer is None:
            continue
        through = {VARIABLES.get(n) for n in rest} - {None}
        gain, whole = fewer.chi2 - found.chi2, search.none.chi2 - found.chi2
        if through & {VARIABLES.get(n) for n in alike} and gain < min(_BENT * whole, 5.0 * GAIN):
            return fewer
    return None
