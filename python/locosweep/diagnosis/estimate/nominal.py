"""The nominal model, fitted within the uncertainties that its file states."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import (
    Fit,
    Model,
    Nuisances,
    chi2_of,
    evaluate,
    fit_all,
)

if TYPE_CHECKING:
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.files.robot import Robot

_NOMINAL = 9
"""Starts of the nominal model that are followed."""


def fit_nominal(problem: Problem, nuisances: Nuisances, near: Fit | None = None) -> Fit:
    """Fit the nominal model: its uncertain values from several starts.

    With a fit to other data of the same runs, `near`, from its values and from those of the file.
    """
    uncertain = nuisances.uncertain
    spread = np.array([nuisances.spread[i] for i in uncertain])
    corners = np.array(list(product((0.0, -1.2, 1.2), repeat=len(uncertain))))
    if near is not None:
        corners = np.stack([corners[0], near.theta[: len(uncertain)] / spread])
    other = np.zeros(len(nuisances.moving) + len(nuisances.start_offsets))
    fits = [
        Fit(Model((), ()), nuisances, np.concatenate([corner * spread, other]))
        for corner in corners
    ]
    fits = sorted(evaluate(problem, fits), key=chi2_of)[:_NOMINAL]
    fits = sorted(fit_all(problem, fits, steps=8), key=chi2_of)[:2]
    return min(fit_all(problem, fits, steps=40), key=chi2_of)


def gaps_of(problem: Problem, nuisances: Nuisances) -> list[float]:
    """Return the squared whitened error a sample of the nominal model, fitted to all, by run."""
    every = list(range(len(problem.runs)))
    if nuisances.uncertain:
        e = fit_nominal(problem, replace(nuisances, start_offsets=())).residual
    else:
        e = problem.residuals([problem.plain()], every)[0]
    own = [e[problem.of_run(r, every)] for r in every]
    return [float(part @ part) / max(int(np.count_nonzero(part)), 1) for part in own]


def spread_of(robot: Robot) -> tuple[float, float, float, float]:
    """Return the deviations that the nominal file allows; 0 where its value is exact."""
    keys = ("mass", "mu_coulomb", "gain", "clock")
    found = [float(robot.other.get(f"uncertainty.{key}", 0.0)) for key in keys]
    return found[0], found[1], found[2], found[3]
