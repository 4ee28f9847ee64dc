"""Predictions of runs that a fit has not seen: whether they err by more than they may."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import jacobian_of, point_of
from locosweep.diagnosis.estimate.validation import validation_residuals
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.whiteness import whiteness_test

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.select.search import Search

    Floats = NDArray[np.float64]


def misses(search: Search, fit: Fit) -> bool:
    """Return whether a fit leaves much of a gap, or more than noise, in the validation data.

    Of whole runs, what its parameters are uncertain by counts as error of the prediction.
    """
    problem = search.problem
    if not search.judges:
        return False
    points = [point_of(problem, one) for one in (search.none, fit)]
    before, after = validation_residuals(problem, points)
    most = limits.HELD_OUT_NOISE * np.count_nonzero(after)
    if after @ after > max(limits.HELD_OUT_REST * float(before @ before), most):
        return True
    if not problem.held:
        return False
    slopes = jacobian_of(problem, fit, problem.held)[:, : after.size]
    values, vectors = np.linalg.eigh(fit.covariance)
    unsure = (np.sqrt(np.maximum(values, 0.0)) * vectors).T @ slopes
    return whiteness_test(problem, over_deviations(after, unsure), problem.held).rejected


def over_deviations(e: Floats, unsure: Floats) -> Floats:
    """Return errors, of noise 1, over their deviations where a prediction is unsure as well.

    `unsure` has a row for each direction in which it may be off, a standard deviation long.
    """
    _, size, along = np.linalg.svd(unsure, full_matrices=False)
    found: Floats = e - ((1.0 - 1.0 / np.hypot(1.0, size)) * (along @ e)) @ along
    return found
