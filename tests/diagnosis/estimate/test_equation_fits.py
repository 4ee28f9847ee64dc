"""Fits to the equation error: they come near those to replays, for a fraction of the work."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis_search import fit_of, search_for
from locosweep.diagnosis.estimate.equation_fits import evaluated, refined, uncertainties
from locosweep.diagnosis.estimate.least_squares import start_fits

BOTH = {"viscous_friction": {"c": 0.06}, "drive_lag": {"T": 0.03}}
SEARCH = search_for(BOTH, *BOTH)
MODEL = SEARCH.model(tuple(BOTH))


def start(c: float, lag: float):
    (fit,) = start_fits(SEARCH.nuisances, MODEL, np.array([[c, lag]]))
    return fit


def test_both_parameters_are_found_without_a_replay() -> None:
    assert SEARCH.along is not None
    before = SEARCH.problem.meter.samples
    (fit,) = refined(SEARCH.along, [start(0.01, 0.01)])
    assert SEARCH.problem.meter.samples == before
    replayed = fit_of(SEARCH, *BOTH, values=(0.05, 0.02))
    np.testing.assert_allclose(fit.parameters, replayed.parameters, rtol=0.05)
    (begin,) = evaluated(SEARCH.along, [start(0.01, 0.01)])
    assert fit.chi2 < 0.1 * begin.chi2


def test_chi2_is_that_of_the_displacements_and_what_is_known_before() -> None:
    along = SEARCH.along
    assert along is not None
    fit = start(0.05, 0.02)
    (found,) = evaluated(along, [fit])
    (row,) = along.displacements([fit])
    priors = [u / s for u, s in zip(fit.nuisance, SEARCH.nuisances.spread, strict=False) if s]
    assert found.chi2 == pytest.approx(
        np.square(along.measured - row).sum() + np.square(priors).sum()
    )


def test_derivatives_agree_with_wider_differences() -> None:
    assert SEARCH.along is not None
    here = start(0.05, 0.02)
    rows = SEARCH.along.jacobian(here)
    for j, width in enumerate((1e-4, 1e-4)):
        there, back = (here.theta.copy() for _ in range(2))
        there[j] += width
        back[j] -= width
        above, below = SEARCH.along.displacements([here.unfitted(there), here.unfitted(back)])
        wide = (above - below) / (2.0 * width)
        np.testing.assert_allclose(rows[j], wide, atol=0.02 * np.abs(wide).max())


def test_what_is_well_known_has_no_valley() -> None:
    assert SEARCH.along is not None
    assert uncertainties(SEARCH.along, start(0.06, 0.03)) is None
    assert uncertainties(SEARCH.along, SEARCH.none) is None


def test_fits_do_not_hang_on_their_neighbours() -> None:
    assert SEARCH.along is not None
    starts = [start(0.01, 0.01), start(0.2, 0.05), start(0.03, 0.002)]
    together = refined(SEARCH.along, starts)
    for one, fit in zip(starts, together, strict=True):
        (alone,) = refined(SEARCH.along, [one])
        assert alone.parameters == pytest.approx(fit.parameters, rel=1e-9)
