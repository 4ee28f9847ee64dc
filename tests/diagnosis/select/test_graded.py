"""The graded verdict on rigs with a force that no effect stands for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import search_of
from diagnosis_small import driven, measured
from locosweep.diagnosis.estimate.rest import RestForce
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.graded import (
    Candidate,
    _compared,
    _confirmed,
    _narrower,
    confirmed_on_kept,
    graded,
    predicts_kept,
    refitted,
)

NAMES = ("viscous_friction", "drive_gain_error", "drive_lag", "sensor_scale", "coulomb_error")


def rig(effects, *, hidden: float, count: int = 5):
    """Runs with an effect and with a force of their own, another one in each run."""
    runs = driven(count)
    random = np.random.default_rng(11)
    knots = np.linspace(0.0, 2.0, 8)
    real = [
        replace(run, drive=run.drive + np.interp(run.t, knots, hidden * random.standard_normal(8)))
        for run in runs
    ]
    return [
        replace(run, drive=told.drive)
        for run, told in zip(measured(effects, real), runs, strict=True)
    ]


def verdict(runs, names=NAMES, most: int = 2):
    search = search_of(runs, *names)
    return search, graded(search, singles(search), most)


def test_a_model_from_two_starts_to_one_end_is_compared_once() -> None:
    runs = rig({"viscous_friction": {"c": 0.15}}, hidden=0.003)
    search = search_of(runs, "viscous_friction", "coulomb_error")
    known = singles(search)
    starts = [fit.unfitted() for names, fit in known.fits.items() if names]
    twice = [*starts, *(fit.unfitted(1.01 * fit.theta) for fit in starts)]
    found = _compared(search, RestForce(search.problem), search.none, twice)
    names = [one.fit.model.names for one in found.others]
    assert sorted(names) == [("coulomb_error",), ("viscous_friction",)]
    assert found.base.fit.model.names == ()


def test_what_lowers_the_error_too_little_where_it_was_fitted_is_left() -> None:
    """Drag makes the gap: a reading that drifts takes next to nothing of it."""
    search = search_of(rig({"viscous_friction": {"c": 0.15}}, hidden=0.003), *NAMES)
    fits = [fit.unfitted() for names, fit in singles(search).fits.items() if names]
    some, none = (
        [
            one.fit.model.names[0]
            for one in _compared(search, RestForce(search.problem), search.none, fits, error).others
        ]
        for error in (None, 1e3)
    )
    assert 0 < len(some) < len(fits) == len(NAMES)
    assert "viscous_friction" in some
    assert none == []


def test_the_cause_is_named_beside_a_rest() -> None:
    _, found = verdict(rig({"viscous_friction": {"c": 0.15}}, hidden=0.003))
    assert [cause.names for cause in found.causes] == [("viscous_friction",)]
    (cause,) = found.causes
    assert cause.agrees
    assert cause.chosen.error < 0.5 * cause.before.error
    assert abs(cause.fit.named()["viscous_friction"]["c"] - 0.15) < 0.02


def test_a_force_of_every_runs_own_is_no_cause() -> None:
    _, found = verdict(rig({}, hidden=0.05))
    assert not found.causes
    assert not found.unlisted


def test_what_takes_little_away_is_no_first_cause_but_a_further_one() -> None:
    """A seventh less error in each block of unseen runs, and surely likelier."""
    search = search_of(measured({}), *NAMES)
    known = singles(search)
    one, other = known.single("viscous_friction"), known.single("coulomb_error")
    compared = _compared(search, RestForce(search.problem), search.none, [])
    errors = np.linspace(1.0, 1.1, 8)
    after = Candidate(one, 0.0, (0.86 * errors) ** 2)
    for before, named in ((search.none, False), (other, True)):
        base = Candidate(before, 500.0, errors**2)
        now = replace(compared, base=base, inflation=1.0)
        assert _confirmed(now, after, base) == named


@pytest.mark.parametrize(("left", "named"), [(0.4, True), (0.6, False)])
def test_what_is_correlated_in_the_rest_does_not_count_against_what_halves_unseen_errors(
    left: float, named: bool
) -> None:
    search = search_of(rig({}, hidden=0.002), *NAMES)
    one = singles(search).single("viscous_friction")
    errors = np.linspace(1.0, 1.1, 8)
    base = Candidate(search.none, 50.0, errors**2)
    compared = _compared(search, RestForce(search.problem), search.none, [])
    now = replace(compared, base=base, inflation=3.0)
    after = Candidate(one, 0.0, (left * errors) ** 2)
    assert _confirmed(now, after, base) == named
    assert _confirmed(replace(now, inflation=1.0), after, base)


def test_two_causes_in_the_order_of_what_they_take_away() -> None:
    both = {"viscous_friction": {"c": 0.2}, "sensor_scale": {"e": 0.08}}
    _, found = verdict(rig(both, hidden=0.002))
    assert {cause.names[0] for cause in found.causes} == set(both)
    assert found.causes[0].chosen.error > found.causes[1].chosen.error


def test_what_no_run_tells_apart_is_one_class() -> None:
    runs = rig({"viscous_friction": {"c": 0.15}}, hidden=0.003)
    _, found = verdict(runs, ("viscous_friction", "back_emf", "drive_lag"))
    assert {frozenset(cause.names) for cause in found.causes} == {
        frozenset({"viscous_friction", "back_emf"})
    }


def test_models_are_fitted_again_to_other_runs() -> None:
    runs = rig({"viscous_friction": {"c": 0.15}}, hidden=0.003)
    _, found = verdict(runs)
    fits = refitted(search_of(runs, *NAMES, held=(4,)), found)
    fit = fits[frozenset({"viscous_friction"})]
    assert abs(fit.named()["viscous_friction"]["c"] - 0.15) < 0.03
    assert 4 not in fit.seen[1]


def test_causes_that_the_kept_runs_do_not_show_are_left_out() -> None:
    runs = rig({"viscous_friction": {"c": 0.15}}, hidden=0.003)
    _, found = verdict(runs)
    own = search_of(runs, *NAMES, held=(4,))
    fits = refitted(own, found)
    assert confirmed_on_kept(own, found, fits).causes == found.causes
    none_kept = search_of(runs, *NAMES)
    assert confirmed_on_kept(none_kept, found, fits).causes == found.causes
    assert predicts_kept(own, fits[frozenset({"viscous_friction"})])
    # Without the effect in the kept run, nothing is left of it.
    other = [*runs[:4], rig({}, hidden=0.003)[4]]
    own = search_of(other, *NAMES, held=(4,))
    assert not confirmed_on_kept(own, found, fits).causes
    assert not predicts_kept(own, fits[frozenset({"viscous_friction"})])


def test_likelihood_beside_the_rest_goes_before_the_error_of_free_runs() -> None:
    """The free run of one long run is mostly the rest's: a drag of another law bends to it."""
    runs = rig({"viscous_friction": {"c": 0.15}}, hidden=0.003, count=2)
    _, found = verdict(runs, ("viscous_friction", "quadratic_drag", "sensor_scale"), 1)
    (cause,) = found.causes
    assert cause.names == ("viscous_friction",)
    assert abs(cause.fit.named()["viscous_friction"]["c"] - 0.15) < 0.01


def test_a_limit_that_predicts_as_well_stands_for_its_wider_law() -> None:
    def candidate(error: float) -> Candidate:
        return Candidate(None, 0.0, np.array([error**2]))  # type: ignore[arg-type]

    wide = {"supply_sag": candidate(1.0)}
    able = wide | {"drive_gain_error": candidate(1.2), "viscous_friction": candidate(1.0)}
    assert set(_narrower(wide, able)) == {"drive_gain_error"}
    assert not _narrower(wide, wide | {"drive_gain_error": candidate(1.3)})
    assert not _narrower(wide, wide)
