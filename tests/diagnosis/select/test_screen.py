"""Screening of starts against dense least squares and by hand."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from diagnosis_search import fit_of, search_for
from locosweep.diagnosis.estimate.least_squares import evaluate, jacobian_of, start_fits
from locosweep.diagnosis.select.screen import (
    Screened,
    below_limit,
    cancelling_pairs,
    distinct,
    informative_runs,
    near_best,
    scaled,
    scan_beside,
)

SEARCH = search_for({"viscous_friction": {"c": 0.05}}, "viscous_friction", "drive_gain_error")


def starts(name: str, *values: float):
    model = SEARCH.model((name,))
    return start_fits(SEARCH.nuisances, model, np.array(values)[:, None])


def test_what_a_start_promises_is_a_linear_fit() -> None:
    base = fit_of(SEARCH, "drive_gain_error")
    model = SEARCH.model(("drive_gain_error", "viscous_friction"))
    (start,) = start_fits(SEARCH.nuisances, model, np.array([[base.parameters[0], 0.04]]))
    (seen,), leaves = scan_beside(SEARCH.problem, [start], [0, 1, 2], base)
    known, moved = evaluate(SEARCH.problem, [base.unfitted(), start], [0, 1, 2])
    columns = np.vstack(
        [moved.residual - known.residual, jacobian_of(SEARCH.problem, known, [0, 1, 2])]
    ).T
    sizes, *_ = np.linalg.lstsq(columns, -known.residual, rcond=None)
    beside, *_ = np.linalg.lstsq(columns[:, 1:], -known.residual, rcond=None)
    fall = np.sum((known.residual + columns[:, 1:] @ beside) ** 2)
    fall -= np.sum((known.residual + columns @ sizes) ** 2)
    assert leaves == pytest.approx(known.chi2)
    assert seen.factor == pytest.approx(sizes[0], rel=1e-6)
    assert seen.promised == pytest.approx(known.chi2 - fall, rel=1e-6)
    assert not seen.fit.residual.size


def test_pairs_that_cancel_most_are_those_of_all_least_squares() -> None:
    random = np.random.default_rng(1)
    names = ["viscous_friction"] * 2 + ["drive_gain_error"] * 2
    alone = [f for n in names for f in starts(n, 0.01)]
    changes, residual = random.standard_normal((4, 30)), random.standard_normal(30)
    found = cancelling_pairs(alone, changes, residual, np.zeros((0, 30)), 5)
    left = {}
    for i, j in combinations(range(4), 2):
        if names[i] != names[j]:
            sizes, rest, *_ = np.linalg.lstsq(changes[[i, j]].T, -residual, rcond=None)
            left[i, j] = float(rest[0]), sizes
    best = min(left, key=lambda pair: left[pair][0])
    ((i, j, sizes),) = found
    assert tuple(sorted((i, j))) == best
    np.testing.assert_allclose(np.array(sizes)[np.argsort((i, j))], left[best][1], atol=1e-9)


def test_a_scaled_start_is_as_many_times_stronger() -> None:
    (start,) = starts("viscous_friction", 0.02)
    assert scaled(start, 2.5).parameters[0] == pytest.approx(0.05)
    assert scaled(start, -1e9).parameters[0] == start.model.free[0].low
    assert scaled(start, 0.0).parameters[0] == pytest.approx(0.02)


def screened(fit, promised: float, chi2: float) -> Screened:
    from dataclasses import replace

    return Screened(replace(fit, chi2=chi2), promised)


def test_starts_below_a_limit_and_the_best_of_each_model_are_kept() -> None:
    a, b = starts("viscous_friction", 0.01, 0.02)
    (c,) = starts("drive_gain_error", 0.01)
    some = [screened(a, 5.0, 9.0), screened(b, 50.0, 60.0), screened(c, 50.0, 60.0)]
    assert below_limit(some, 10.0, every=False) == some[:1]
    assert below_limit(some, 10.0, every=True) == [some[0], some[2]]


def test_far_behind_the_best_of_a_model_is_left_out() -> None:
    a, b = starts("viscous_friction", 0.01, 0.02)
    near, far = screened(a, 0.0, 100.0).fit, screened(b, 0.0, 151.0).fit
    assert near_best([near, far]) == [near]
    assert near_best([near, screened(b, 0.0, 149.0).fit])[0] is near
    assert len(near_best([near, screened(b, 0.0, 149.0).fit])) == 2


def test_alike_starts_are_followed_once() -> None:
    size = SEARCH.model(("viscous_friction",)).free[0].size
    values = (0.1 * size, 0.1005 * size, 0.2 * size)
    some = [screened(fit, 0.0, 0.0) for fit in starts("viscous_friction", *values)]
    assert distinct(some, 3) == [some[0], some[2]]
    assert distinct(some, 1) == some[:1]


def test_runs_that_hold_most_of_what_is_left_are_informative() -> None:
    (fit,) = evaluate(SEARCH.problem, [SEARCH.none])
    e, count = fit.residual, 200
    left = [
        float(e[r * count : (r + 1) * count] @ e[r * count : (r + 1) * count]) for r in range(3)
    ]
    assert informative_runs(SEARCH.problem, fit) == sorted(np.argsort(left)[1:].tolist())
