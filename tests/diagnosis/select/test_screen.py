"""Screening of starts against dense least squares and by hand."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from diagnosis_search import fit_of, search_for, search_of
from diagnosis_small import driven, measured
from locosweep.diagnosis.estimate.least_squares import evaluate, jacobian_of, start_fits
from locosweep.diagnosis.select.screen import (
    along_valley,
    cancelling_pairs,
    informative_runs,
    pairs_along,
    pairs_beside,
    scaled,
    scan_beside,
    seen_along,
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


def test_a_start_far_too_strong_is_evaluated_as_weak_as_it_promises_most() -> None:
    strong, fair = starts("viscous_friction", 5.0, 0.04)
    seen, leaves = scan_beside(SEARCH.problem, [strong, fair], [0, 1, 2], SEARCH.none)
    first, second, weaker = seen
    assert first.fit.parameters[0] == pytest.approx(5.0)
    assert second.fit.parameters[0] == pytest.approx(0.04)
    assert weaker.fit.parameters[0] == pytest.approx(5.0 * first.factor)
    # The line through the strong one misses: it sticks where the others slide.
    assert weaker.promised < min(first.promised, leaves)


def test_pairs_that_cancel_most_are_those_of_all_least_squares() -> None:
    random = np.random.default_rng(1)
    names = ["viscous_friction"] * 2 + ["drive_gain_error"] * 2
    alone = [f for n in names for f in starts(n, 0.01)]
    changes, residual = random.standard_normal((4, 30)), random.standard_normal(30)
    found = cancelling_pairs(alone, changes, residual, 5)
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


def test_starts_leave_the_least_equation_error_at_the_truth() -> None:
    found = seen_along(SEARCH, SEARCH.none, SEARCH.names)
    best = found["viscous_friction"][0]
    assert best.parameters[0] == pytest.approx(0.05, rel=0.02)
    assert best.chi2 < 0.5 * found["drive_gain_error"][0].chi2


def test_what_acts_at_rest_is_not_seen() -> None:
    blind = ("presliding_compliance", "sensor_drift")
    search = search_for({}, *blind, "sensor_scale")
    assert list(seen_along(search, search.none, search.names)) == ["sensor_scale"]
    assert seen_along(search, search.none, blind) == {}
    assert seen_along(replace(search, along=None), search.none, search.names) == {}


def test_pairs_of_the_equation_error_are_the_true_one_first() -> None:
    both = {"viscous_friction": {"c": 0.06}, "drive_lag": {"T": 0.03}}
    search = search_for(both, *both, "drive_gain_error", "coulomb_error", "sensor_scale")
    best = pairs_along(search, 3)[0]
    assert set(best.model.names) == set(both)
    assert best.named()["drive_lag"]["T"] == pytest.approx(0.03, rel=0.05)


def test_pairs_of_replays_are_the_true_one_first_at_its_strengths() -> None:
    """The gap is small, so that the equation error is noise."""
    true = {"viscous_friction": 0.004, "sensor_drift": -1e-4}
    effects = {"viscous_friction": {"c": 0.004}, "sensor_drift": {"b": -1e-4}}
    search = search_for(effects, *true, "drive_gain_error", "slope_error", "quadratic_drag")
    alone = [fit_of(search, name) for name in search.names]
    first, *others = pairs_beside(search, alone, [0, 1, 2])
    assert set(first.model.names) == set(true)
    for name, value in zip(first.model.names, first.parameters, strict=True):
        assert value == pytest.approx(true[name], rel=0.1)
    assert [fit.chi2 for fit in others] == sorted(fit.chi2 for fit in others)
    assert first.chi2 < others[0].chi2


def test_a_valley_is_walked_where_a_parameter_is_hardly_known() -> None:
    assert SEARCH.along is not None
    (sure,) = starts("viscous_friction", 0.05)
    assert along_valley(SEARCH.along, sure) == []
    model = SEARCH.model(("stribeck_friction",))
    level = model.free[0].off
    (unsure,) = start_fits(SEARCH.nuisances, model, np.array([[1.01 * level, 0.01, 1.0]]))
    further = along_valley(SEARCH.along, unsure)
    assert len(further) == 4
    for fit in further:
        for free, value in zip(model.free, fit.parameters, strict=True):
            assert free.low * (1 - 1e-9) <= value <= free.high * (1 + 1e-9)


def test_runs_that_hold_most_of_what_is_left_are_informative() -> None:
    (fit,) = evaluate(SEARCH.problem, [SEARCH.none])
    e, count = fit.residual, 200
    left = [
        float(e[r * count : (r + 1) * count] @ e[r * count : (r + 1) * count]) for r in range(3)
    ]
    assert informative_runs(SEARCH.problem, fit) == sorted(np.argsort(left)[1:].tolist())


def test_of_many_runs_a_quarter_is_informative() -> None:
    runs = driven(12, seconds=0.5)
    search = search_of(measured({"viscous_friction": {"c": 0.05}}, runs), "viscous_friction")
    chosen = informative_runs(search.problem, search.none)
    # What is left of the starts stands behind the readings.
    parts = np.split(search.none.residual[: 12 * runs[0].t.size], 12)
    left = [float(part @ part) for part in parts]
    assert chosen == sorted(np.argsort(left)[-3:].tolist())
