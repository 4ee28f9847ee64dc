"""Errors on runs that a fit has not seen: the step of Gauss and Newton against fits without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import fit_of, search_of
from diagnosis_small import driven, measured
from locosweep.diagnosis.estimate.least_squares import evaluate
from locosweep.diagnosis.estimate.unseen import groups_of, unseen_squares, without_each

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


def test_errors_are_those_of_the_position_in_its_unit() -> None:
    runs = measured({"viscous_friction": {"c": 0.1}}, driven(4))
    search = search_of(runs, "viscous_friction")
    fits = evaluate(search.problem, [search.none, fit_of(search, "viscous_friction").unfitted()])
    squares, counts = unseen_squares(search.problem, fits, groups_of(search.problem, range(4)))
    assert counts.tolist() == [run.t.size for run in runs]
    plain = search.problem.replay([search.problem.plain()])["x"][0] - search.problem.measured["x"]
    total = [float(np.sum(part**2)) for part in np.split(plain, search.problem.starts_at[1:-1])]
    assert squares[0] == pytest.approx(total, rel=0.01)
    assert np.sqrt(squares[1].sum() / counts.sum()) == pytest.approx(1e-5, rel=0.1)


def test_a_gap_in_the_readings_does_not_count() -> None:
    runs = measured({}, driven(2))
    x = runs[0].channels["x"].copy()
    x[50:80] = np.nan
    runs = [replace(runs[0], channels={"x": x}), runs[1]]
    search = search_of(runs, "viscous_friction")
    _, counts = unseen_squares(search.problem, [search.none], [[0], [1]])
    assert counts.tolist() == [runs[0].t.size - 30, runs[1].t.size]
