"""Forces that no effect stands for, and that refute causes of the list."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.diagnosis.effects.catalogue import VARIABLES, own_variables
from locosweep.diagnosis.estimate.rest import RestForce
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.by_place import ALONG, BY_PLACE, by_place_ahead
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.select.search import Collection, Search

BY_ACCELERATION = "acceleration"
UNLISTED = (BY_PLACE, BY_ACCELERATION)
"""Variables of forces that no effect stands for: the position in either direction, as of a tether,
a magnet or a wall (but for a slope, whose law is `steady`), and the acceleration."""
BY_TIME = "push"
"""Variable of a force that no effect stands for, either: the time, other in each run."""


def unlisted_rival(
    search: Search, known: Collection, found: Fit, score: float, *, mismatch: bool
) -> tuple[str, Fit]:
    """Return the variable of a force that no effect stands for and that refutes a set, if any.

    And the model beside which it does that best.

    It has to do better than one of several effects beside the others; as well as all of them, or
    as another law of an effect, is enough, being one cause by a force as free. A single effect by
    its own formula is nearly a special case of such a force: that has to do better by what a
    wider law has to gain. Like is compared with like: where an effect has another law, a law of its
    variable in place of its formula counts, too; and a force by acceleration, which holds friction
    of either direction, has to do better than a law of any variable that effects act through.
    """
    names = frozenset(found.model.names)
    single = len(names) == 1 and not mismatch
    alone = -limits.WIDER_LAW_GAIN if single else limits.LEAST_GAIN
    variables = UNLISTED if single else (BY_PLACE,)
    sets = dict.fromkeys([frozenset[str](), *(names - {name} for name in names)])
    noise = noise_level(search.problem, found.residual)
    ahead, beside = {"": 0.0}, {"": search.none}
    for key in (key for key in sets if key in known.fits):
        fit = known.fits[key]
        margin = 0.0 if fit.model.names else alone
        terms = NonparametricCorrection(search.problem, fit)
        own = own_variables(names - key)
        if mismatch:
            score = min(score, search.score(fit) - terms.log_bayes_factor(own, noise) * noise)
        for variable in variables:
            if mismatch and variable in own:
                # It is that law.
                continue
            if (variable, own) == (BY_PLACE, [ALONG]) and by_place_ahead(terms, noise) <= 0:
                # It is such friction, or the two are one.
                continue
            gain = terms.log_bayes_factor([variable], noise) * noise
            if variable == BY_ACCELERATION and gain < _listed_gain(terms, noise):
                continue
            by = score + margin - (search.score(fit) - gain)
            if by >= ahead.get(variable, by):
                ahead[variable], beside[variable] = by, fit
    best = max(ahead, key=lambda variable: ahead[variable])
    if best:
        return best, beside[best]
    # What the rig does comes again in each run, so that one law is likelier than a force in each.
    pushed = RestForce(search.problem).log_bayes_factor(search.none.unfitted())
    ahead_by = pushed - (search.score(search.none) - score)
    likelier = ahead_by >= (limits.WIDER_LAW_GAIN if single else 0.0)
    return BY_TIME if likelier else "", search.none


def _listed_gain(terms: NonparametricCorrection, noise: float) -> float:
    """Return what a law has to gain, in chi2, to be likelier than one of any effect's variable."""
    listed = set(terms.variables) & set(VARIABLES.values())
    best = max((terms.log_bayes_factor([v], noise) for v in listed), default=0.0)
    return best * noise + limits.LEAST_GAIN
