"""Errors on runs that a fit has not seen: the step of Gauss and Newton against fits without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import fit_of, search_of
from diagnosis_small import driven, measured
from locosweep.diagnosis.estimate import unseen
from locosweep.diagnosis.estimate.least_squares import evaluate, start_fits
from locosweep.diagnosis.estimate.unseen import groups_of, without_each, without_groups

HIDDEN = {"drive_gain_error": {"e": -0.01}}


def test_a_run_left_out_to_first_order_is_a_fit_without_it() -> None:
    runs = measured({**HIDDEN, "viscous_friction": {"c": 0.1}}, driven(4))
    search = search_of(runs, "viscous_friction")
    (whole,) = evaluate(search.problem, [fit_of(search, "viscous_friction").unfitted()])
    found = without_each(search.problem, whole, groups_of(search.problem, range(4)))
    for r in range(4):
        own = search_of(runs, "viscous_friction", held=(r,))
        exact = fit_of(own, "viscous_friction")
        assert found[r][0] == pytest.approx(exact.theta[0], rel=1e-3)
        assert abs(found[r][0] - exact.theta[0]) < 0.3 * abs(whole.theta[0] - exact.theta[0])


def test_a_start_speed_that_only_the_left_out_run_knows_stays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    runs = measured(HIDDEN, driven(2))
    search = search_of(runs, "viscous_friction")
    search = replace(search, nuisances=replace(search.nuisances, moving=(0,)))
    model = search.model(["viscous_friction"])
    (start,) = start_fits(search.nuisances, model, np.array([[0.1]]))
    (whole,) = evaluate(search.problem, [start])
    # Of the speed, in small units, the first run alone says something.
    random, own = np.random.default_rng(3), search.problem.of_run(0, search.problem.fitted)
    slopes = random.standard_normal((2, whole.residual.size))
    slopes[1, :] = 0.0
    slopes[1, own] = 1e6 * random.standard_normal(own.size)
    monkeypatch.setattr(unseen, "jacobian_of", lambda *_: slopes)
    first, second = without_each(search.problem, whole, [[0], [1]])
    assert first[1] == whole.theta[1]
    other = search.problem.of_run(1, search.problem.fitted)
    pull = slopes[0, own] @ whole.residual[own] / (slopes[0, other] @ slopes[0, other])
    low, high = model.free[0].low, model.free[0].high
    assert first[0] == pytest.approx(np.clip(whole.theta[0] + pull, low, high))
    assert second[1] != whole.theta[1]


def test_a_step_that_leads_astray_is_a_fit_without_the_group(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    runs = measured({**HIDDEN, "viscous_friction": {"c": 0.1}}, driven(4))
    search = search_of(runs, "viscous_friction")
    whole = fit_of(search, "viscous_friction")
    groups = groups_of(search.problem, range(4))
    first_order = without_each(search.problem, whole, groups)
    (same,) = without_groups(search.problem, [whole], groups)
    assert [a == b for a, b in zip(same, first_order, strict=True)] == [[True]] * 4
    for factor in (-1.0, 100.0):
        monkeypatch.setattr(
            unseen, "without_each",
            lambda _, fit, __, factor=factor: [
                fit.theta + factor * (theta - fit.theta) for theta in first_order
            ],
        )  # fmt: skip
        (found,) = without_groups(search.problem, [whole], groups)
        for theta, right in zip(found, first_order, strict=True):
            assert theta == pytest.approx(right, rel=1e-3)
            assert abs(theta[0] - right[0]) < 0.1 * abs(whole.theta[0] - right[0])
