"""The choice among a few effects: causes, classes, and how sure it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import fit_of, search_for, search_of
from diagnosis_small import driven, measured, tethered, uneven
from locosweep.diagnosis.estimate.least_squares import evaluate
from locosweep.diagnosis.select import law_mismatch, verdict
from locosweep.diagnosis.select.law_mismatch import (
    OtherLaw,
    best_with_other_law,
    score_with_other_law,
)
from locosweep.diagnosis.select.score import remaining
from locosweep.diagnosis.select.search import Collection
from locosweep.diagnosis.select.verdict import choose, kept_may_show_a_gap

NAMES = ("viscous_friction", "sensor_drift", "coulomb_error")


def test_noise_needs_no_effect() -> None:
    choice = choose(search_for({}, *NAMES), 3)
    assert (choice.status, choice.fit.model.names) == ("none", ())
    assert 0.5 < choice.probability <= 0.98
    assert not choice.whiteness.rejected
    assert choice.tied == [choice.fit]


def test_a_cause_is_explained() -> None:
    choice = choose(search_for({"viscous_friction": {"c": 0.03}}, *NAMES), 3)
    assert (choice.status, choice.classes) == ("explained", [["viscous_friction"]])
    assert choice.fit.parameters[0] == pytest.approx(0.03, rel=0.03)
    assert choice.weight(choice.fit) > 0.9
    assert sum(weight for _, weight in choice.ranked) == pytest.approx(1.0)


def test_an_uneven_slope_is_named_and_a_tether_is_not() -> None:
    """Both are forces by place; that of the slope stays near its mean."""
    names = ("slope_error", "viscous_friction", "friction_drift")
    choice = choose(search_of(uneven(), *names), 2)
    assert (choice.classes, choice.law_mismatch) == ([["slope_error"]], True)
    choice = choose(search_of(tethered(), *names), 2)
    assert (choice.status, choice.classes) == ("unexplained", [])


def test_two_causes_are_both_named() -> None:
    both = {"viscous_friction": {"c": 0.01}, "sensor_drift": {"b": 1e-4}}
    choice = choose(search_for(both, *NAMES), 3)
    assert (choice.status, set(choice.fit.model.names)) == ("explained", set(both))
    assert set(choice.known.fits) > {frozenset(both), frozenset()}


@pytest.mark.parametrize("of_the_effect", [True, False])
def test_a_law_that_is_none_of_its_effect_is_no_reason_against_two_causes(
    monkeypatch: pytest.MonkeyPatch, of_the_effect: bool
) -> None:
    """Two causes leave but noise, and what one bends to is about as likely."""
    both = {"viscous_friction": {"c": 0.01}, "sensor_drift": {"b": 1e-4}}
    search = search_for(both, *NAMES)
    drag = fit_of(search, "viscous_friction")
    monkeypatch.setattr(
        verdict, "best_with_other_law", lambda *_: OtherLaw(0.0, drag, of_none=False)
    )
    monkeypatch.setattr(verdict, "several_do_better", lambda *_: False)
    monkeypatch.setattr(verdict, "is_law_of", lambda *_: of_the_effect)
    choice = choose(search, 3)
    assert choice.law_mismatch == of_the_effect
    assert (set(choice.fit.model.names) == set(both)) is not of_the_effect


@pytest.mark.parametrize("of_none", [True, False])
def test_where_a_law_of_no_effect_leaves_but_noise_nothing_is_named(
    monkeypatch: pytest.MonkeyPatch, of_none: bool
) -> None:
    search = search_for({"quadratic_drag": {"c2": 0.05}}, "viscous_friction")
    found = best_with_other_law(search, [fit_of(search, "viscous_friction")])
    assert found is not None
    assert not found.of_none
    law = replace(found, of_none=of_none)
    monkeypatch.setattr(verdict, "best_with_other_law", lambda *_: law)
    choice = choose(search, 1)
    assert choice.status == ("unexplained" if of_none else "explained")
    assert (choice.outdone, choice.law_of_none) == (of_none, of_none)


@pytest.mark.parametrize(("ahead", "named"), [(-100.0, True), (0.0, False)])
def test_a_law_of_no_effect_refutes_several_effects_that_do_no_better(
    monkeypatch: pytest.MonkeyPatch, ahead: float, named: bool
) -> None:
    both = ("sensor_drift", "viscous_friction")
    search = search_for({"viscous_friction": {"c": 0.01}, "sensor_drift": {"b": 1e-4}}, *both)
    pair = fit_of(search, *both)
    law = OtherLaw(search.score(pair) - ahead, fit_of(search, both[0]), of_none=True)
    monkeypatch.setattr(verdict, "best_with_other_law", lambda *_: law)
    choice = choose(search, 2)
    assert choice.status == ("explained" if named else "unexplained")
    assert (not choice.classes, choice.outdone) == (not named, not named)
    assert choice.unlisted == ("" if named else "clock")


@pytest.mark.parametrize(("share", "named"), [(0.6, True), (0.1, False)])
def test_a_law_that_only_its_likelihood_speaks_for_has_no_rival_in_another_variable(
    monkeypatch: pytest.MonkeyPatch, share: float, named: bool
) -> None:
    search = search_for({"quadratic_drag": {"c2": 0.05}}, "viscous_friction")
    monkeypatch.setattr(verdict, "classes_of",
                        lambda *_: ([["viscous_friction", "drive_lag"]], []))  # fmt: skip
    monkeypatch.setattr(law_mismatch, "formula_share", lambda *_: share)
    monkeypatch.setattr(law_mismatch, "_is_likeliest", lambda *_: True)
    choice = choose(search, 1)
    assert choice.status == ("ambiguous" if named else "unexplained")
    assert choice.law_mismatch is named


def test_a_set_that_leaves_little_more_than_noise_is_followed_out_of_its_valley(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    both = {"viscous_friction": {"c": 0.01}, "sensor_drift": {"b": 1e-4}}
    search = search_for(both, *NAMES)
    fit = fit_of(search, *both)
    theta = fit.theta + 10.0 * np.sqrt(np.diag(fit.covariance))
    (aside,) = evaluate(search.problem, [fit.unfitted(theta)])
    aside = replace(aside, covariance=fit.covariance)
    assert not search.is_noise(aside)
    assert aside.chi2 < 2.0 * search.problem.degrees()
    known = Collection({frozenset(one.model.names): one for one in (search.none, aside)})
    monkeypatch.setattr(verdict, "_grown", lambda *_: verdict._Grown(known, [aside], aside))
    choice = choose(search, 3)
    assert (choice.status, set(choice.fit.model.names)) == ("explained", set(both))


def test_a_law_of_one_cause_stands_where_several_effects_leave_more_than_noise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Drag by the square of the speed, told as viscous friction beside a drift: neither formula."""
    search = search_for({"quadratic_drag": {"c2": 0.05}}, "viscous_friction", "sensor_drift")
    law = fit_of(search, "viscous_friction")
    pair = fit_of(search, "viscous_friction", "sensor_drift")
    assert remaining(search.problem, pair)
    score = score_with_other_law(search, law)
    assert score is not None
    known = Collection({frozenset(one.model.names): one for one in (search.none, law, pair)})
    accepted = OtherLaw(score, law, of_none=False)
    for other, told in ((accepted, ["viscous_friction"]), (None, [])):
        grown = verdict._Grown(known, [pair], pair, law=other)
        monkeypatch.setattr(verdict, "_grown", lambda *_, found=grown: found)
        choice = choose(search, 2)
        assert [name for alike in choice.classes for name in alike] == told
        assert choice.law_mismatch == bool(told)
        assert (choice.status == "unexplained") == (not told)


def test_what_the_runs_cannot_tell_apart_is_a_class() -> None:
    """Back-EMF and viscous friction are one force where the drive force is not measured."""
    search = search_for({"viscous_friction": {"c": 0.03}}, "viscous_friction", "back_emf")
    choice = choose(search, 2)
    assert choice.status == "ambiguous"
    assert {*choice.classes[0]} == {"viscous_friction", "back_emf"}
    assert [fit.model.names[0] for fit in choice.tied] == choice.classes[0]


def test_what_no_candidate_accounts_for_is_unexplained() -> None:
    runs = driven()
    pushed = measured({"position_dependent_friction": {"a": 0.02, "L": 0.03, "p": 0.0}}, runs)
    for names, most in ((("sensor_drift", "drive_gain_error"), 1), (("viscous_friction",), 2)):
        choice = choose(search_of(pushed, *names), most)
        assert choice.status == "unexplained"
        assert choice.whiteness.rejected
        assert choice.shape


def test_a_kept_run_with_a_gap_asks_for_fits_to_all() -> None:
    sound, pushed = measured({}), measured({"viscous_friction": {"c": 0.03}})
    last = len(sound) - 1
    for runs, more in ((sound, False), ([*sound[:-1], pushed[-1]], True)):
        search = search_of(runs, "viscous_friction", held=(last,))
        choice = choose(search, 1)
        assert choice.status == "none"
        assert kept_may_show_a_gap(search, choice) == more


def test_a_kept_run_may_show_the_cause_of_a_rest_that_no_effect_takes() -> None:
    rough = {"position_dependent_friction": {"a": 0.002, "L": 0.03, "p": 0.0}}
    runs, late = measured(rough), measured({"sensor_delay": {"T": 0.02}})
    last = len(runs) - 1
    search = search_of([*runs[:-1], late[-1]], "sensor_delay", held=(last,))
    choice = choose(search, 1)
    assert (choice.status, choice.fit.model.names) == ("unexplained", ())
    assert kept_may_show_a_gap(search, choice)


def test_a_single_effect_is_outdone_by_a_force_that_no_effect_stands_for() -> None:
    """A weak spring to the middle of the way: friction that drifts leaves but noise, too."""
    runs = driven()
    ways = [run.channels["x"] for run in measured({}, runs)]
    pulled = [
        replace(run, drive=run.drive - 1e-3 * (x - 0.5 * x.max()))
        for run, x in zip(runs, ways, strict=True)
    ]
    drift = {"friction_drift": {"a": 2e-3, "T": 1.0}}
    for found, unlisted in ((measured({}, pulled), "terrain"), (measured(drift, runs), "")):
        given = [replace(one, drive=run.drive) for one, run in zip(found, runs, strict=True)]
        choice = choose(search_of(given, "friction_drift", "direction_dependent_friction"), 1)
        assert (choice.unlisted, choice.outdone) == (unlisted, bool(unlisted))
        assert choice.status == ("unexplained" if unlisted else "explained")
        assert not choice.whiteness.rejected
        assert choice.fit.chi2 < search_of(given).none.chi2 - 30.0
