"""What a fit is worth, beside others and by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.diagnosis.select.nonparametric import Flexible
from locosweep.diagnosis.select.whiteness import lack_of, noise_level

if TYPE_CHECKING:
    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Search

__all__ = ["GAIN", "gains", "rest_of", "total"]

GAIN = 20.0
"""What an effect has to gain in chi2 beside the price of its parameters.

With 25 candidates of one to three parameters, noise alone gains as much in fewer
than one of two hundred sets of runs.
"""
_OWN = 6.0
"""What of that it has to gain on the runs that it is fitted to."""


def total(search: Search, fit: Fit) -> float:
    """Score of a fit, with its prediction of what it has not seen where that counts."""
    return search.score(fit) + search.unseen_chi2(fit)


def gains(search: Search, old: Fit, new: Fit) -> bool:
    """Whether more effects are worth it, on the runs that are fitted too.

    A prediction alone does not say so: that of the simpler model may be off by no
    more than its parameters are uncertain.
    """
    whole = total(search, old) - total(search, new)
    return whole >= GAIN and search.score(old) - search.score(new) >= _OWN


def rest_of(problem: Problem, fit: Fit) -> list[tuple[str, float]]:
    """Return what a fit leaves beyond noise, by the variables that would carry it."""
    terms = Flexible(problem, fit)
    found = terms.found(noise=noise_level(problem, fit.residual))
    if not found and lack_of(problem, fit.residual).is_there:
        return [("none of these", 0.0)]
    return found
