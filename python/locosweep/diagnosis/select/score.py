"""Score of a fit, beside others and by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.thresholds import (
    CLEAR_REST,
    LEAST_GAIN,
    LEAST_GAIN_FITTED,
    STALLED,
)
from locosweep.diagnosis.select.whiteness import noise_level, whiteness_test

if TYPE_CHECKING:
    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Search


def total(search: Search, fit: Fit) -> float:
    """Score of a fit, with its prediction of what it has not seen where that counts."""
    return search.score(fit) + search.unseen_chi2(fit)


def gains(search: Search, old: Fit, new: Fit) -> bool:
    """Return whether more effects gain enough, on the fitted runs too.

    A prediction alone does not say so: it may be off by the uncertainty of the parameters.
    """
    whole = total(search, old) - total(search, new)
    return whole >= LEAST_GAIN and search.score(old) - search.score(new) >= LEAST_GAIN_FITTED


def stalled_above(before: float, noise: float, count: int) -> float:
    """Return the chi2 above which a further effect leaves most of what is clearly more than noise.

    `before` is chi2 without it, `noise` that of noise in so many residuals. Infinite where the rest
    may be noise.
    """
    rest = before - noise
    clear = CLEAR_REST * noise * np.sqrt(2.0 / max(count, 1))
    return float(noise + STALLED * rest) if rest > clear else np.inf


def stalled_beside(problem: Problem, fit: Fit) -> float:
    """Return the chi2 above which a further effect leaves most of what a fit leaves."""
    count = problem.degrees()
    return stalled_above(fit.chi2, count * noise_level(problem, fit.residual), count)


def remaining(problem: Problem, fit: Fit) -> list[tuple[str, float]]:
    """Return what a fit leaves beyond noise, by the variables that would carry it."""
    terms = NonparametricCorrection(problem, fit)
    found = terms.significant(noise=noise_level(problem, fit.residual))
    if not found and whiteness_test(problem, fit.residual).rejected:
        return [("none of these", 0.0)]
    return found
