"""Models beside a rest: which take part, once each."""

from __future__ import annotations

from diagnosis_rest import NAMES, rig
from diagnosis_search import search_of
from locosweep.diagnosis.estimate.rest import RestForce
from locosweep.diagnosis.select.beside_rest import compare_beside_rest
from locosweep.diagnosis.select.extension import singles


def test_a_model_from_two_starts_to_one_end_is_compared_once() -> None:
    runs = rig({"viscous_friction": {"c": 0.15}}, hidden=0.003)
    search = search_of(runs, "viscous_friction", "coulomb_error")
    known = singles(search)
    starts = [fit.unfitted() for names, fit in known.fits.items() if names]
    twice = [*starts, *(fit.unfitted(1.01 * fit.theta) for fit in starts)]
    found = compare_beside_rest(search, RestForce(search.problem), search.none, twice)
    names = [one.fit.model.names for one in found.others]
    assert sorted(names) == [("coulomb_error",), ("viscous_friction",)]
    assert found.base.fit.model.names == ()


def test_what_lowers_the_error_too_little_where_it_was_fitted_is_left() -> None:
    """Drag makes the gap: a reading that drifts takes next to nothing of it."""
    search = search_of(rig({"viscous_friction": {"c": 0.15}}, hidden=0.003), *NAMES)
    fits = [fit.unfitted() for names, fit in singles(search).fits.items() if names]
    rest, none = RestForce(search.problem), search.none
    some, left = (
        [
            one.fit.model.names[0]
            for one in compare_beside_rest(search, rest, none, fits, error).others
        ]
        for error in (None, 1e3)
    )
    assert 0 < len(some) < len(fits) == len(NAMES)
    assert "viscous_friction" in some
    assert left == []
