"""Models of all runs, those that are kept from fits among them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import Fit, fit_all

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Search


def with_all_starts(problem: Problem, fit: Fit) -> Fit:
    """Return an unfitted model that has the start speeds of the runs kept from fits as well."""
    moving = fit.nuisances.moving
    late = tuple(r for r in problem.starts.moving if r in problem.held and r not in moving)
    at = len(fit.model.free) + len(fit.nuisances.uncertain) + len(moving)
    nuisances = replace(fit.nuisances, moving=(*moving, *late))
    return Fit(fit.model, nuisances, np.insert(fit.theta, [at] * len(late), 0.0))


def fitted_to_all(search: Search, fits: Sequence[Fit]) -> list[Fit]:
    """Return models fitted to all runs, each from its values for some of them."""
    problem = search.problem
    starts = [with_all_starts(problem, fit) for fit in fits]
    return fit_all(problem.of_all_runs, starts, steps=search.steps, least=None)
