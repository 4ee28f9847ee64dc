"""Fits against SciPy's least squares, and that they are values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from diagnosis_search import search_for
from locosweep.diagnosis.estimate.least_squares import (
    Nuisances,
    evaluate,
    fit_all,
    jacobian_of,
    point_of,
    start_fits,
)

TRUE = {"viscous_friction": {"c": 0.08}, "drive_gain_error": {"e": -0.03}}


def started():
    search = search_for(TRUE)
    model = search.model(tuple(TRUE))
    (start,) = start_fits(search.nuisances, model, np.array([[0.01, 0.0]]))
    return search.problem, start


def test_a_fit_is_that_of_another_least_squares() -> None:
    problem, start = started()

    def left(theta: np.ndarray) -> np.ndarray:
        return problem.residuals([point_of(problem, start.unfitted(theta))])[0]

    other = least_squares(left, start.theta, x_scale=[0.1, 0.1], diff_step=1e-4, xtol=1e-12)
    (fit,) = fit_all(problem, [start], steps=30, tolerance=1e-6)
    assert fit.chi2 == pytest.approx(2.0 * other.cost, abs=0.01)
    np.testing.assert_allclose(fit.parameters, other.x, atol=0.02 * fit.stds.min())
    spread = np.sqrt(np.diag(np.linalg.inv(other.jac.T @ other.jac)))
    np.testing.assert_allclose(fit.stds, spread, rtol=0.05)
    found = fit.named()
    for name, values in TRUE.items():
        for key, value in values.items():
            assert found[name][key] == pytest.approx(value, abs=5.0 * spread.max())


def test_fits_are_not_changed_by_what_is_done_with_them() -> None:
    problem, start = started()
    theta = start.theta.copy()
    (seen,) = evaluate(problem, [start])
    (fitted,) = fit_all(problem, [seen])
    assert start.chi2 == np.inf
    assert fitted.chi2 < seen.chi2 < np.inf
    np.testing.assert_array_equal(start.theta, theta)
    np.testing.assert_array_equal(seen.theta, theta)


def test_a_fit_out_of_reach_of_its_limit_is_left() -> None:
    problem, start = started()
    (seen,) = evaluate(problem, [start])
    left, followed = fit_all(problem, [replace(seen, limit=1.0), seen], steps=20)
    assert left.chi2 > followed.chi2 + 20.0


def test_a_fit_that_stands_alone_goes_on_beside_a_better_one() -> None:
    search = search_for(TRUE)
    none = search.none.nuisance
    slow = search.model(("stribeck_friction",))
    (poor,) = start_fits(search.nuisances, slow, np.array([[0.5, 0.02, 2.0]]), none)
    (best,) = fit_all(search.problem, [started()[1]], steps=30)
    (end,) = fit_all(search.problem, [poor], steps=20)
    left = fit_all(search.problem, [poor, best], steps=20)[0]
    alone = fit_all(search.problem, [poor, best], steps=20, least=None)[0]
    assert left.chi2 > end.chi2 + 1.0
    assert alone.chi2 == end.chi2
    np.testing.assert_array_equal(alone.theta, end.theta)


def test_the_jacobian_is_that_of_central_differences() -> None:
    problem, start = started()
    (fit,) = evaluate(problem, [start])
    rows = jacobian_of(problem, fit)
    for j, step in enumerate((1e-5, 1e-5)):
        sides = []
        for sign in (1.0, -1.0):
            theta = fit.theta.copy()
            theta[j] += sign * step
            sides.append(problem.residuals([point_of(problem, fit.unfitted(theta))])[0])
        central = (sides[0] - sides[1]) / (2.0 * step)
        assert np.linalg.norm(rows[j] - central) < 0.02 * np.linalg.norm(central)


def test_bounds_hold() -> None:
    problem, start = started()
    free = tuple(replace(f, low=0.0, high=0.02) if f.name == "c" else f for f in start.model.free)
    (fit,) = fit_all(problem, [replace(start, model=replace(start.model, free=free))], steps=20)
    assert fit.parameters[0] == pytest.approx(0.02)


def test_what_a_bound_holds_is_not_inside() -> None:
    search = search_for({}, "drive_saturation", "quadratic_drag")
    model = search.model(search.names)
    limit = model.free[0]
    rows = np.array([[limit.high, 0.0], [0.5 * limit.high, 0.1]])
    nuisances = Nuisances(moving=(0,))
    ends, between = start_fits(nuisances, model, rows)
    assert ends.inside.tolist() == [False, False, True]
    assert between.inside.all()
    low, high = ends.bounds
    assert (low[-1], high[-1]) == (-np.inf, np.inf)
    assert (low[:2] <= ends.theta[:2]).all()
    assert (ends.theta[:2] <= high[:2]).all()


def test_what_is_known_before_has_its_derivatives() -> None:
    problem, start = started()
    nuisances = replace(start.nuisances, spread=(0.02, 0.0, 0.0, 0.001))
    (fit,) = evaluate(problem, start_fits(nuisances, start.model, start.parameters[None]))
    rows = jacobian_of(problem, fit)
    assert rows.shape == (4, fit.residual.size)
    np.testing.assert_allclose(rows[:, -2:], [[0, 0], [0, 0], [50, 0], [0, 1000]])


def test_residuals_that_were_not_kept_are_worked_out_when_asked_for() -> None:
    problem, start = started()
    (kept,), (left,) = (evaluate(problem, [start], [0, 2], residuals=on) for on in (True, False))
    assert "residual" not in vars(left)
    np.testing.assert_array_equal(left.residual, kept.residual)
    assert left.chi2 == pytest.approx(kept.residual @ kept.residual, rel=1e-12)
    assert not left.without_residual().residual.size


def test_chi2_of_other_runs_is_not_taken_for_that_of_these() -> None:
    problem, start = started()
    (few,) = evaluate(problem, [start], [0])
    (whole,) = evaluate(problem, [start])
    (untouched,) = fit_all(problem, [few], steps=0)
    assert untouched.chi2 == whole.chi2 > few.chi2
