"""A force by place beside friction along the way: what tells the two apart, and where nothing does.

Only friction turns round with the motion.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import VARIABLES
from locosweep.diagnosis.estimate.least_squares import evaluate
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.stepwise import without
from locosweep.diagnosis.select.thresholds import FIRST_ORDER, LEAST_GAIN
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Search
    from locosweep.diagnosis.select.verdict import Choice

ALONG, BY_PLACE = "place", "terrain"
"""Variables of friction along the way, and of a force by place: of an uneven slope, or of what no
effect stands for."""

_PLACES = 20
"""Parts of the travel that are passed both ways or not, about as many as laws along it have
knots."""
_PASSED_TWICE = 0.01
"""Share of the moving samples that have to lie, in the rarer direction, where heads moved in both:
less is a jerk back at a stop. Of `locosweep blind-check --only outside --cases 150 --seed 11112`,
runs that are driven forward alone have up to 0.005 (cases 15 and 145), those that are driven both
ways 0.2 and more (48 and 117)."""


def by_place_ahead(terms: NonparametricCorrection, noise: float) -> float:
    """Return how much likelier a force by place is than friction along the way; 0 if they tie.

    As a chi2. Where the places that friction depends on are passed in one direction, the two are
    one.
    """
    along, place = (terms.log_bayes_factor([v], noise) * noise for v in (ALONG, BY_PLACE))
    ahead = place - along
    return ahead if abs(ahead) >= max(LEAST_GAIN, FIRST_ORDER * place) else 0.0


def is_one_by_place(search: Search, choice: Choice) -> bool:
    """Return whether friction along the way is named and a force by place would do the same."""
    problem = search.problem
    # Of what is unexplained, nothing is named.
    names = choice.fit.model.names if choice.classes else ()
    for name, alike in zip(names, choice.classes, strict=True):
        if any(VARIABLES.get(other) == ALONG for other in alike):
            (base,) = evaluate(problem, [without(search, choice.fit, name)])
            terms = NonparametricCorrection(problem, base)
            return by_place_ahead(terms, noise_level(problem, base.residual)) == 0.0
    return False


def passes_both_ways(problem: Problem) -> bool:
    """Return whether heads have come back over a part of their way.

    Only then does friction along it, which turns round with the motion, differ from a force by
    place.
    """
    motions = problem.motions
    low, high = min(m.x.min() for m in motions), max(m.x.max() for m in motions)
    edges = np.linspace(low, max(high, low + 1e-300), _PLACES + 1)
    ways = np.array(
        [
            sum(np.histogram(m.x[way * m.v > m.resting_speed], edges)[0] for m in motions)
            for way in (1.0, -1.0)
        ]
    )
    return bool(ways.min(axis=0).sum() > _PASSED_TWICE * ways.sum())
