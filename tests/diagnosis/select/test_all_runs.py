"""Models of all runs, those that are kept from fits among them."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis_search import fit_of, search_of
from diagnosis_small import measured
from locosweep.diagnosis.estimate.least_squares import evaluate
from locosweep.diagnosis.select.all_runs import fitted_to_all, with_all_starts

DRAG = {"viscous_friction": {"c": 0.05}}


def test_a_fit_to_all_runs_is_one_with_none_kept() -> None:
    runs = measured(DRAG)
    kept, whole = search_of(runs, *DRAG, held=(2,)), search_of(runs, *DRAG)
    some, every = fit_of(kept, *DRAG), fit_of(whole, *DRAG)
    (found,) = fitted_to_all(kept, [some])
    assert found.parameters == pytest.approx(every.parameters, rel=1e-4)
    assert found.chi2 == pytest.approx(every.chi2, abs=0.02)
    assert some.parameters != pytest.approx(every.parameters, rel=1e-5)


def test_all_runs_hold_the_readings_of_those_kept() -> None:
    search = search_of(measured(DRAG), *DRAG, held=(2,))
    whole = search.problem.of_all_runs
    assert (search.problem.fitted, whole.fitted) == ([0, 1], [0, 1, 2])
    same = with_all_starts(search.problem, search.none)
    # Runs that begin at rest have no speed to fit.
    np.testing.assert_array_equal(same.theta, search.none.theta)
    (same,) = evaluate(whole, [same])
    assert same.chi2 > search.none.chi2
