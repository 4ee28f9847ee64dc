"""What a search knows, and the collection of what it has found."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from diagnosis_search import fit_of, search_for, search_of
from diagnosis_small import measured
from locosweep.diagnosis.estimate.least_squares import point_of
from locosweep.diagnosis.estimate.validation import validation_residuals
from locosweep.diagnosis.select.search import Collection
from locosweep.diagnosis.select.thresholds import PENALTY

NAMES = ("viscous_friction", "coulomb_error")


def test_a_search_cannot_be_changed() -> None:
    search = search_for({}, *NAMES)
    with pytest.raises(FrozenInstanceError):
        search.names = ()  # type: ignore[misc]


def test_every_free_parameter_has_its_price() -> None:
    search = search_for({}, *NAMES)
    fit = fit_of(search, *NAMES)
    assert search.score(fit) == fit.chi2 + 2 * PENALTY
    assert search.score(search.none) == search.none.chi2


def test_what_fits_have_not_seen_is_replayed_once() -> None:
    search = search_of(measured({"coulomb_error": {"d_mu": 0.01}}), *NAMES, held=(1,))
    e = validation_residuals(search.problem, [point_of(search.problem, search.none)])[0]
    before = search.problem.meter.samples
    assert search.unseen_chi2(search.none) == pytest.approx(float(e @ e))
    assert search.unseen_chi2(search.none) == pytest.approx(float(e @ e))
    assert search.problem.meter.samples - before == 200
    assert replace(search, judges=False).unseen_chi2(search.none) == 0.0


def test_noise_is_told_from_a_gap() -> None:
    quiet, loud = search_for({}), search_for({"coulomb_error": {"d_mu": 0.05}})
    assert quiet.is_noise(quiet.none)
    assert not loud.is_noise(loud.none)


def test_hints_are_given_in_the_order_of_the_model() -> None:
    search = search_for({}, *NAMES)
    fit = fit_of(search, *NAMES)
    told = replace(search, hints={frozenset(NAMES): fit})
    (row,) = told.hinted(search.model(NAMES[::-1]))
    np.testing.assert_array_equal(row, fit.parameters[::-1])
    assert told.hinted(search.model(NAMES[:1])) == []


def test_a_collection_grows_into_another_one() -> None:
    search = search_for({"viscous_friction": {"c": 0.05}}, *NAMES)
    known = Collection({frozenset(): search.none})
    single = fit_of(search, "viscous_friction")
    more = known.adding({frozenset({"viscous_friction"}): single})
    assert known.single("viscous_friction") is None
    assert more.single("viscous_friction") is single
    assert list(more.fits.values()) == [search.none, single]
