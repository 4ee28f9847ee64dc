"""Forward steps of a search, and that they return what they add."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import fit_of, ranked, search_for, search_of
from diagnosis_small import measured
from locosweep.diagnosis.estimate.least_squares import Fit, evaluate
from locosweep.diagnosis.select import extension
from locosweep.diagnosis.select.effort import PARTNERS
from locosweep.diagnosis.select.extension import (
    _gaining,
    _rescanned,
    extend,
    pairs,
    singles,
)
from locosweep.diagnosis.select.screen import mean_square, pairs_along, seen_along
from locosweep.diagnosis.select.search import Collection

NAMES = ("viscous_friction", "drive_gain_error", "sensor_drift")
BOTH = {"viscous_friction": {"c": 0.06}, "sensor_drift": {"b": 2e-3}}


def test_single_effects_are_ranked_by_their_fit() -> None:
    search = search_for({"viscous_friction": {"c": 0.06}}, *NAMES)
    known = singles(search)
    best = ranked({k: f for k, f in known.fits.items() if k})[0]
    assert best.model.names == ("viscous_friction",)
    assert best.parameters[0] == pytest.approx(0.06, rel=0.02)
    assert len(known.fits) == 4


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


def test_what_gains_far_less_along_the_motion_than_a_rival_is_not_fitted() -> None:
    """An effect that the equation error does not see, as a bristle's, is replayed all the same."""
    names = ("viscous_friction", "slope_error", "drive_saturation", "presliding_compliance")
    search = search_for({"viscous_friction": {"c": 0.06}}, *names)
    known = singles(search)
    others = names[1:]
    free = extend(search, known, search.none, others)
    held = extend(search, known, search.none, others, rival=known.single("viscous_friction"))
    assert frozenset({"drive_saturation"}) in free
    assert frozenset({"drive_saturation"}) not in held
    along = seen_along(search, search.none, names)
    before = mean_square(search, search.none)
    assert _gaining(search, names, along, before, None) == [names[0], names[3]]


def test_pairs_need_no_part_that_stands_out_alone() -> None:
    both = {"viscous_friction": {"c": 0.06}, "drive_lag": {"T": 0.03}}
    search = search_for(both, *both, "drive_gain_error", "coulomb_error")
    known = Collection({frozenset(): search.none})
    best = ranked(pairs(search, known, pairs_along(search, 8)))[0]
    assert set(best.model.names) == set(both)
    assert best.named()["drive_lag"]["T"] == pytest.approx(0.03, rel=0.01)


def test_nothing_is_fitted_beside_a_set_where_no_effect_promises_half_of_the_rest() -> None:
    """Beside viscous friction, a scale of the drive takes little of a sensor's drift."""
    search = search_for(BOTH, *NAMES)
    base = fit_of(search, "viscous_friction")
    known = Collection({frozenset(): search.none})
    assert extend(search, known, base, ("drive_gain_error",), beat=True) == {}
    assert extend(search, known, base, ("drive_gain_error",))
    found = extend(search, known, base, NAMES, beat=True)
    assert frozenset(BOTH) in found


def test_a_period_is_found_wherever_it_lies() -> None:
    """Friction along the way has a valley for every period: the best one is not next door."""
    for length in (0.02, 0.05):
        true = {"a": 0.3, "L": length, "p": 0.7}
        name = "position_dependent_friction"
        search = search_for({name: true}, name, "viscous_friction")
        fit = singles(search).fits[frozenset({name})]
        assert fit.parameters[1] == pytest.approx(length, rel=0.02)
        assert fit.chi2 < 1.2 * search.problem.degrees()


def test_without_slides_starts_are_replayed() -> None:
    search = search_for(BOTH, *NAMES)
    blind = singles(replace(search, along=None))
    for key, fit in singles(search).fits.items():
        np.testing.assert_allclose(blind.fits[key].chi2, fit.chi2, rtol=0.02)


def test_a_threshold_is_tried_again_where_that_shows_enough() -> None:
    search = search_for({"drive_deadzone": {"d": 0.1}}, "drive_deadzone")
    stuck = fit_of(search, "drive_deadzone", values=[0.0]).unfitted(np.zeros(1))
    (stuck,) = evaluate(search.problem, [stuck])
    # Where the best effect leaves so little, nothing that a value shows comes near it.
    assert _rescanned(search, stuck, -10.0 * search.none.chi2) is stuck
    found = _rescanned(search, stuck, stuck.chi2)
    assert found.chi2 < 0.1 * stuck.chi2
    assert found.parameters[0] == pytest.approx(0.1, rel=0.02)


def test_a_threshold_is_followed_with_what_answers_to_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A grip that breaks late and slides easily, or at once and slides hard: a valley each."""
    slip = {"anchor_slip": {"mu_static": 0.155, "mu_coulomb": 0.1}}
    search = search_of(measured(slip, channels=("x", "x_rear")), "anchor_slip")
    stuck = fit_of(search, "anchor_slip", values=[0.13, 0.13])
    found = _rescanned(search, stuck, stuck.chi2)
    assert found.parameters == pytest.approx([0.155, 0.1], rel=0.02)
    monkeypatch.setattr(extension, "_is_unknown", lambda *_: False)
    alone = _rescanned(search, stuck, stuck.chi2)
    assert alone.chi2 > 2.0 * found.chi2


@pytest.mark.parametrize(("behind", "rounds"), [(1e6, 1), (8.0, PARTNERS), (-1.0, PARTNERS)])
def test_a_threshold_that_comes_no_nearer_is_given_up(
    behind: float, rounds: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two less of chi2 a round: too little for a million, enough for eight, or for the best."""
    search = search_for({"drive_deadzone": {"d": 0.1}}, "drive_deadzone")
    stuck = fit_of(search, "drive_deadzone", values=[0.0]).unfitted(np.zeros(1))
    (stuck,) = evaluate(search.problem, [stuck])
    made: list[float] = []

    def a_bit_better(*_: object, **__: object) -> list[Fit]:
        made.append(stuck.chi2 - 2.0 * (len(made) + 1))
        return [replace(stuck, chi2=made[-1])]

    monkeypatch.setattr(extension, "fit_all", a_bit_better)
    _rescanned(search, stuck, stuck.chi2 - behind)
    assert len(made) == rounds


def test_a_threshold_is_followed_only_where_it_may_gain_another_round(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = search_for({"drive_deadzone": {"d": 0.1}}, "drive_deadzone")
    stuck = fit_of(search, "drive_deadzone", values=[0.0]).unfitted(np.zeros(1))
    (stuck,) = evaluate(search.problem, [stuck])
    limits: list[float] = []

    def left(_: object, starts: list[Fit], **__: object) -> list[Fit]:
        limits.extend(start.limit for start in starts)
        return [replace(start, chi2=np.inf) for start in starts]

    monkeypatch.setattr(extension, "fit_all", left)
    behind = 0.5 * stuck.chi2
    assert _rescanned(search, stuck, stuck.chi2 - behind) is stuck
    assert limits == pytest.approx([stuck.chi2 - behind / PARTNERS] * len(limits))
    assert limits
