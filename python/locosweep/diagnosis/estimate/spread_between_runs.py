"""How well a fit knows its parameters where it leaves more than noise: by how runs disagree."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import jacobian_of
from locosweep.diagnosis.estimate.unseen import groups_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

_BLOCKS = 12
"""Parts of one run: their spread is known to about a fifth, 1 / sqrt(2 (12 - 1)), and each lasts as
long as it can then. Not derived beyond that."""


def covariance_between_runs(problem: Problem, fit: Fit) -> Floats:
    """Return the covariance of a fit's parameters if what it leaves is no white noise.

    What each run pulls them by is taken as independent of the other runs, whatever it is within the
    run (the sandwich of Huber 1967 and White 1982); of one run, what each of `_BLOCKS` parts does.
    That is too little where what is left lasts longer than a part. No deviation is smaller than
    under white noise.
    """
    known = fit.covariance
    if not known.size:
        return known
    parts = [
        np.concatenate([problem.of_run(r, problem.fitted) for r in group])
        for group in groups_of(problem, problem.fitted)
    ]
    if len(parts) == 1:
        parts = np.array_split(parts[0], _BLOCKS)
    slopes = jacobian_of(problem, fit)
    pulls = np.array([slopes[:, own] @ fit.residual[own] for own in parts])
    scatter = pulls.T @ pulls * len(parts) / (len(parts) - 1)
    white = np.maximum(np.diag(known), 1e-300)
    wider = np.sqrt(np.maximum(np.diag(known @ scatter @ known) / white, 1.0))
    found: Floats = known * np.outer(wider, wider)
    return found
