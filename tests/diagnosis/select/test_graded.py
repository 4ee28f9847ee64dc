"""The graded verdict on rigs with a force that no effect stands for."""

from __future__ import annotations

from dataclasses import replace

import pytest

from diagnosis_rest import NAMES, rig
from diagnosis_search import search_of
from diagnosis_small import NOISE
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.graded import confirmed_on_kept, graded, predicts_kept, refitted


def verdict(runs, names=NAMES, most: int = 2):
    search = search_of(runs, *names)
    return search, graded(search, singles(search), most)


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


def test_of_a_gap_near_the_noise_nothing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    runs = rig({"viscous_friction": {"c": 0.0014}}, hidden=3.5e-5)
    _, found = verdict(runs)
    assert 2.0 * NOISE < found.none.error < limits.LEAST_GRADED * NOISE
    assert not found.causes
    monkeypatch.setattr(limits, "LEAST_GRADED", 1.0)
    assert verdict(runs)[1].causes


def test_a_noise_above_what_a_cause_leaves_makes_no_gap_small() -> None:
    """A log may show noise that no model leaves, as where readings are scaled."""
    runs = rig({"viscous_friction": {"c": 0.15}}, hidden=0.003)
    search = search_of(runs, *NAMES)
    error = graded(search, singles(search), 1).none.error
    noise = {"x": replace(search.problem.noise["x"], sd=0.5 * error)}
    search = replace(search, problem=replace(search.problem, known=noise))
    found = graded(search, singles(search), 1)
    assert found.none.error < limits.LEAST_GRADED * 0.5 * error
    (cause,) = found.causes
    assert "viscous_friction" in cause.names


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
