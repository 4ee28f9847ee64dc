"""Forward, exchange and backward steps on gaps of two causes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import fit_of, ranked, search_for, search_of
from diagnosis_small import driven, measured
from locosweep.diagnosis.estimate.least_squares import fit_all
from locosweep.diagnosis.select import stepwise
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.score import total
from locosweep.diagnosis.select.search import Collection
from locosweep.diagnosis.select.stepwise import (
    _takes_the_place,
    backward,
    exchanged,
    forward,
    without,
)
from locosweep.diagnosis.select.thresholds import LEAST_GAIN, PENALTY, TIE

NAMES = ("viscous_friction", "drive_gain_error", "sensor_drift")
BOTH = {"viscous_friction": {"c": 0.06}, "sensor_drift": {"b": 2e-3}}


def test_a_forward_step_finds_the_second_cause() -> None:
    search = search_for(BOTH, *NAMES)
    known = singles(search)
    level = ranked({key: fit for key, fit in known.fits.items() if key})
    found = forward(search, known, level, level[0], rest=True)
    best = ranked(found.fits)[0]
    assert set(best.model.names) == set(BOTH)
    assert set(found.fits) > set(known.fits)
    assert all(len(key) < 2 for key in known.fits)


@pytest.mark.parametrize(("strength", "tried"), [(0.01, True), (1.0, False)])
def test_no_pair_is_completed_where_none_makes_the_forces_of_the_motion(
    strength: float, tried: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A hum that no effect stands for, weaker and far stronger than noise."""
    runs = driven()
    hum = [replace(r, drive=r.drive + strength * np.sin(40.0 * r.t)) for r in runs]
    given = [replace(m, drive=r.drive) for m, r in zip(measured({}, hum), runs, strict=True)]
    search = search_of(given, *NAMES)
    known = singles(search)
    level = ranked({key: fit for key, fit in known.fits.items() if key})
    called = []
    extended = stepwise.extend
    monkeypatch.setattr(
        stepwise,
        "extend",
        lambda *args, **how: called.append(args) or extended(*args, **how),
    )
    found = forward(search, known, level, level[0], rest=True)
    assert bool(called) == tried
    # The pairs that promise most are fitted all the same: causes beside a rest start there.
    assert any(len(key) == 2 for key in found.fits)


def test_a_wrong_pair_is_exchanged_for_the_true_one_and_its_rivals_are_known() -> None:
    search = search_for(BOTH, *NAMES, "back_emf")
    known = singles(search)
    wrong = fit_of(search, "drive_gain_error", "sensor_drift")
    best, known = exchanged(search, known, wrong)
    assert set(best.model.names) in ({*BOTH}, {"back_emf", "sensor_drift"})
    names = frozenset(best.model.names)
    assert known.extended >= {names - {name} for name in names}
    assert {frozenset(BOTH), frozenset({"back_emf", "sensor_drift"})} <= set(known.fits)
    # Nothing is fitted twice.
    again, after = exchanged(search, known, best)
    assert again is best
    assert after.fits == known.fits


def test_a_set_gives_way_to_a_smaller_one_at_once_and_to_others_by_more_than_a_tie() -> None:
    true = {"viscous_friction": {"c": 0.01}, "sensor_drift": {"b": 1e-4}}
    search = replace(search_for(true, *NAMES), judges=False)
    both = fit_of(search, *BOTH)
    # A third effect that gains less than its price.
    wide = replace(fit_of(search, *NAMES, values=(0.01, 0.0, 1e-4)), chi2=both.chi2 - 1.0)
    alike = replace(both, chi2=both.chi2 + 0.5 * TIE)
    assert _takes_the_place(search, wide, both)
    assert not _takes_the_place(search, alike, both)
    assert _takes_the_place(search, replace(both, chi2=both.chi2 + 1.5 * TIE), both)
    # Where a rest is left, only what halves it leads further.
    rest = fit_of(search, "sensor_drift", "drive_gain_error")
    assert not _takes_the_place(search, rest, replace(rest, chi2=0.6 * rest.chi2))
    assert _takes_the_place(search, rest, both)


def test_a_backward_step_leaves_out_what_is_not_needed() -> None:
    search = search_for({"viscous_friction": {"c": 0.06}}, *NAMES)
    wide = fit_of(search, *NAMES)
    left, known = backward(search, Collection({frozenset(): search.none}), wide)
    assert left.model.names == ("viscous_friction",)
    assert frozenset({"viscous_friction"}) in known.fits


def test_a_set_that_is_needed_stays_whole() -> None:
    search = search_for(BOTH, *NAMES)
    both = fit_of(search, *BOTH)
    known = Collection({frozenset(): search.none})
    assert backward(search, known, both)[0] is both
    assert list(known.fits) == [frozenset()]


def test_a_smaller_set_is_fitted_no_further_than_it_may_do_as_well(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = search_for(BOTH, *NAMES)
    both = fit_of(search, *BOTH)
    limits = []

    def fitted(problem, fits, **given):
        limits.extend(fit.limit for fit in fits)
        return fit_all(problem, fits, **given)

    monkeypatch.setattr(stepwise, "fit_all", fitted)
    _, known = backward(search, Collection({frozenset(): search.none}), both)
    assert limits == [total(search, both) + LEAST_GAIN - PENALTY] * 2
    assert all(np.isinf(known.single(name).limit) for name in BOTH)


def test_one_effect_less_has_the_values_of_the_others() -> None:
    search = search_for(BOTH, *NAMES)
    both = fit_of(search, *BOTH)
    fewer = without(search, both, "viscous_friction")
    assert fewer.model.names == ("sensor_drift",)
    np.testing.assert_array_equal(fewer.parameters, both.parameters[1:])
    assert fewer.chi2 == np.inf


def test_every_set_of_a_level_is_extended_until_one_has_stalled(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = search_for(BOTH, *NAMES)
    known = singles(search)
    level = ranked({key: fit for key, fit in known.fits.items() if key})
    called: list[str] = []
    extended = stepwise.extend

    def extend(*args: object, **how: object) -> object:
        if how.get("beat"):
            called.extend(args[2].model.names)  # type: ignore[attr-defined]
        return extended(*args, **how)  # type: ignore[arg-type]

    monkeypatch.setattr(stepwise, "extend", extend)
    monkeypatch.setattr(stepwise, "pairs", lambda *_: {})
    for limit in (np.inf, 0.0):
        called.clear()
        monkeypatch.setattr(stepwise, "stalled_beside", lambda *_, limit=limit: limit)
        found = forward(search, known, level, level[0], rest=True)
        assert frozenset(BOTH) in found.fits
        names = [name for fit in level for name in fit.model.names]
        assert called == (names if limit == np.inf else names[:1])
