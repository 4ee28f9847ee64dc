"""Forward steps of a search, and that they return what they add."""

from __future__ import annotations

from dataclasses import replace

import pytest

from diagnosis_search import fit_of, search_for
from locosweep.diagnosis.select.extension import (
    extend,
    extend_each,
    pairs,
    refit_from,
    retried_singles,
    singles,
)
from locosweep.diagnosis.select.search import Collection, ranked

NAMES = ("viscous_friction", "drive_gain_error", "sensor_drift")
BOTH = {"viscous_friction": {"c": 0.06}, "sensor_drift": {"b": 2e-3}}


def test_single_effects_are_ranked_by_their_fit() -> None:
    search = search_for({"viscous_friction": {"c": 0.06}}, *NAMES)
    known = singles(search)
    best = ranked({k: f for k, f in known.fits.items() if k})[0]
    assert best.model.names == ("viscous_friction",)
    assert best.parameters[0] == pytest.approx(0.06, rel=0.02)
    assert len(known.fits) == 4
    assert known.effort == search.problem.meter.samples
    again = retried_singles(search, known)
    assert all(again.fits[key].chi2 <= fit.chi2 for key, fit in known.fits.items())


def test_one_more_effect_is_added() -> None:
    search = search_for(BOTH, *NAMES)
    known = singles(search)
    base = known.fits[frozenset({"viscous_friction"})]
    found = extend(search, known, base, NAMES)
    assert frozenset(BOTH) in found
    assert all(len(key) == 2 and "viscous_friction" in key for key in found)
    assert frozenset(BOTH) not in known.fits
    best = ranked(found)[0]
    assert set(best.model.names) == set(BOTH)
    assert best.named()["sensor_drift"]["b"] == pytest.approx(2e-3, rel=0.05)


def test_pairs_need_no_part_that_stands_out_alone() -> None:
    search = search_for(BOTH, *NAMES)
    known = Collection({frozenset(): search.none}, 1)
    best = ranked(pairs(search, known, 3))[0]
    assert set(best.model.names) == set(BOTH)


def test_a_level_is_extended_while_the_budget_lasts() -> None:
    search = search_for(BOTH, *NAMES)
    known = singles(search)
    bases = [known.fits[frozenset({name})] for name in NAMES[:2]]
    replayed = []
    for effort in (0, 1_000_000_000):
        before = search.problem.meter.samples
        found = extend_each(search, replace(known, effort=effort), bases)
        assert frozenset(BOTH) in found
        replayed.append(search.problem.meter.samples - before)
    # Without a budget the first is extended all the same.
    assert 0 < replayed[0] < replayed[1]


def test_fits_to_other_runs_are_starts() -> None:
    search, other = search_for(BOTH, *NAMES), search_for(BOTH, *NAMES)
    start = fit_of(other, *BOTH, values=(0.05, 1e-3))
    found = refit_from(search, Collection({frozenset(): search.none}), [start])
    (fit,) = found.values()
    assert fit.chi2 == pytest.approx(start.chi2, abs=0.1)
