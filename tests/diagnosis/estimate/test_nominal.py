"""The nominal model within its uncertainties, against SciPy's least squares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from diagnosis_small import ROBOT, measured, problem
from locosweep.diagnosis.estimate.least_squares import Nuisances
from locosweep.diagnosis.estimate.nominal import fit_nominal, gaps_of

MASS = 0.02
HEAVIER = replace(ROBOT, parameters={**ROBOT.parameters, "mass": 1.03 * ROBOT.parameters["mass"]})


def test_an_uncertain_mass_is_refitted_within_its_prior() -> None:
    own = problem(measured({}, robot=HEAVIER))

    def left(share: np.ndarray) -> np.ndarray:
        plain = own.plain()
        point = replace(plain, factors=np.array([1.0 + share[0], 1.0, 1.0, 0.0]))
        return np.append(own.residuals([point])[0], share[0] / MASS)

    other = least_squares(left, [0.0], diff_step=1e-5, x_scale=MASS, xtol=1e-12)
    fit = fit_nominal(own, Nuisances(spread=(MASS, 0.0, 0.0, 0.0)))
    assert fit.theta[0] == pytest.approx(other.x[0], rel=1e-3)
    assert fit.chi2 == pytest.approx(2.0 * other.cost, abs=0.05)


def test_exact_values_are_not_fitted() -> None:
    own = problem(measured({}, robot=HEAVIER))
    fit = fit_nominal(own, Nuisances())
    assert fit.theta.size == 0
    assert fit.chi2 > 2.0 * own.degrees()


def test_what_uncertain_values_explain_is_no_gap() -> None:
    own = problem(measured({}, robot=HEAVIER))
    exact = gaps_of(own, Nuisances())
    allowed = gaps_of(own, Nuisances(spread=(MASS, 0.0, 0.0, 0.0)))
    assert min(exact) > 2.0
    assert max(allowed) < 1.3
