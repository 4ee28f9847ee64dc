"""Fits of models to the equation error: many at once, the steps made in the core."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.equation_error import EquationError
    from locosweep.diagnosis.estimate.least_squares import Fit

    Floats = NDArray[np.float64]

_STEPS, _TOLERANCE = 8, 0.1
"""Steps of a fit, at most, and the fall of chi2 that ends it: what it finds is a start for
replays, whose steps have all digits."""
_BENT, _WIDEST = 0.02, 1.0
"""Deviation of a fit, in sizes of its parameters, from which its valley may bend, and the most
that is taken for one."""


def refined(along: EquationError, fits: Sequence[Fit], steps: int = _STEPS) -> list[Fit]:
    """Return fits whose parameters leave the least equation error near their starts, with chi2."""
    threads = along.problem.threads
    found = along.core.fit(list(fits), steps, _TOLERANCE, threads)
    return [
        replace(fit, theta=np.concatenate([theta, fit.theta[theta.size :]]), chi2=chi2)
        for fit, (theta, chi2) in zip(fits, found, strict=True)
    ]


def evaluated(along: EquationError, fits: Sequence[Fit]) -> list[Fit]:
    """Return fits with the chi2 of their equation error."""
    return refined(along, fits, steps=0)


def uncertainties(along: EquationError, fit: Fit) -> Floats | None:
    """Return the deviation along which a fit is known least; None where that is a small change.

    It changes the entries of theta that are not about the start of a run.
    """
    if not fit.model.free:
        return None
    jacobian = along.jacobian(fit)
    spread = (fit.nuisances.spread[i] for i in fit.nuisances.uncertain)
    size = np.array([*(free.size for free in fit.model.free), *spread])
    scaled = jacobian * size[:, None]
    values, vectors = np.linalg.eigh(scaled @ scaled.T)
    deviation = min(1.0 / np.sqrt(max(float(values[0]), 1e-12)), _WIDEST)
    return None if deviation < _BENT else size * vectors[:, 0] * deviation
