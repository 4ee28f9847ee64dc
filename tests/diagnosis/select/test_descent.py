"""Fits from many starts: the best end of each set."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import fit_of, search_for
from locosweep.diagnosis.estimate.least_squares import evaluate, fit_all, start_fits
from locosweep.diagnosis.select import descent
from locosweep.diagnosis.select.descent import (
    _with_limits,
    apart,
    beyond_ridges,
    descend,
    takes_place,
)
from locosweep.diagnosis.select.effort import SLACK
from locosweep.diagnosis.select.score import stalled_beside
from locosweep.diagnosis.select.search import Collection
from locosweep.diagnosis.select.thresholds import LEAST_GAIN_FITTED, PENALTY, TIE

NAMES = ("viscous_friction", "drive_delay")


def test_each_set_comes_to_its_best_end() -> None:
    search = search_for({"viscous_friction": {"c": 0.06}}, *NAMES)
    starts = []
    for name, values in zip(NAMES, ((0.001, 0.5), (0.001, 0.02)), strict=True):
        starts += start_fits(search.nuisances, search.model((name,)), np.array(values)[:, None])
    known = Collection({frozenset(): search.none})
    found = descend(search, known, starts, [0, 1], search.none)
    assert list(found) == [frozenset({name}) for name in NAMES]
    best = found[frozenset({"viscous_friction"})]
    assert best.parameters[0] == pytest.approx(0.06, rel=0.02)
    assert best.chi2 == pytest.approx(fit_of(search, "viscous_friction").chi2, abs=0.1)
    assert known.fits == {frozenset(): search.none}


def test_what_shows_little_after_the_first_steps_gets_no_more() -> None:
    names = ("viscous_friction", "sensor_drift")
    search = search_for({"viscous_friction": {"c": 0.06}}, *names)
    starts = [
        start
        for name, value in zip(names, (0.05, 1e-5), strict=True)
        for start in start_fits(search.nuisances, search.model((name,)), np.array([[value]]))
    ]
    known = Collection({frozenset(): search.none})
    found = descend(search, known, starts, [0], search.none)
    far, alone = found[frozenset({"sensor_drift"})], fit_of(search, "sensor_drift")
    # Its first steps saw one run: over all of them it is no end yet.
    assert far.seen == (search.problem, search.problem.chosen(None))
    assert far.chi2 > alone.chi2 + 10.0
    assert found[frozenset({"viscous_friction"})].chi2 < 0.5 * far.chi2


def test_a_start_that_lies_behind_after_one_step_on_all_runs_is_followed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Steps on few runs may lead away from where all runs lead."""
    search = search_for({"viscous_friction": {"c": 0.06}}, *NAMES)
    model = search.model(("viscous_friction",))
    slow, good = start_fits(search.nuisances, model, np.array([[0.2], [0.4]]))
    after = {1: (1000.0, 2000.0), search.steps: (900.0, 100.0)}

    def fitted(problem, fits, *, runs=None, steps=12, **_):
        chosen = after.get(steps, (1500.0, 1500.0)) if runs is None else (500.0, 500.0)
        found = []
        for fit in fits:
            is_good = float(fit.theta[0]) == float(good.theta[0])
            found.append(replace(fit, chi2=chosen[is_good], seen=(problem, problem.chosen(runs))))
        return found

    monkeypatch.setattr(descent, "fit_all", fitted)
    known = Collection({frozenset(): replace(search.none, chi2=1e4)})
    found = descend(search, known, [slow, good], [0, 1], search.none)
    assert found[frozenset({"viscous_friction"})].chi2 == 100.0


def test_fits_on_all_runs_end_by_the_tolerance_of_a_search(monkeypatch: pytest.MonkeyPatch) -> None:
    search = replace(search_for({"viscous_friction": {"c": 0.06}}, *NAMES), tolerance=1.0)
    ended = []

    def fitted(problem, fits, **given):
        if given.get("steps") == search.steps:
            ended.append(given["tolerance"])
        return fit_all(problem, fits, **given)

    monkeypatch.setattr(descent, "fit_all", fitted)
    starts = start_fits(search.nuisances, search.model(NAMES[:1]), np.array([[0.2], [0.4]]))
    descend(search, Collection({frozenset(): search.none}), starts, [0, 1], search.none)
    assert ended == [1.0, 1.0]


def test_a_known_fit_that_is_better_stays() -> None:
    search = search_for({"viscous_friction": {"c": 0.06}}, *NAMES)
    best = fit_of(search, "viscous_friction")
    key = frozenset({"viscous_friction"})
    known = Collection({frozenset(): search.none, key: best})
    starts = start_fits(search.nuisances, best.model, np.array([[0.5]]))
    found = descend(search, known, starts, [0, 1], search.none)
    assert found[key].chi2 <= best.chi2
    assert descend(search, known, [], [0, 1], search.none) == {}


def test_a_set_of_two_has_to_gain_over_the_best_one_and_an_exchange_over_its_rival() -> None:
    """Drag makes the gap: a second effect beside a delay is of no use short of half of the rest."""
    both = {"viscous_friction": {"c": 0.06}, "sensor_drift": {"b": 2e-4}}
    search = search_for(both, *NAMES, "sensor_drift")
    one = fit_of(search, "viscous_friction")
    assert not search.is_noise(one)
    known = Collection({frozenset(): search.none, frozenset({"viscous_friction"}): one})
    model = search.model(("drive_delay", "sensor_drift"))
    (start,) = start_fits(search.nuisances, model, np.array([[0.001, 1e-5]]))
    (limited,) = _with_limits(search, known, [start], at_noise=False)
    gaining = search.score(one) - LEAST_GAIN_FITTED - 2.0 * PENALTY
    assert limited.limit == gaining
    (limited,) = _with_limits(search, known, [start], at_noise=False, beat=True)
    assert limited.limit == stalled_beside(search.problem, one) < gaining
    small = replace(one, chi2=0.9 * search.problem.degrees())
    near = Collection({frozenset(): search.none, frozenset({"viscous_friction"}): small})
    (limited,) = _with_limits(search, near, [start], at_noise=False, beat=True)
    assert limited.limit == search.score(small) - LEAST_GAIN_FITTED - 2.0 * PENALTY
    (exchanged,) = _with_limits(search, known, [start], at_noise=False, rival=one)
    # One parameter more has its price.
    assert exchanged.limit == pytest.approx(takes_place(search, one) - PENALTY)
    noise = search.problem.degrees()
    assert takes_place(search, one) - noise == pytest.approx(0.5 * (one.chi2 - noise), rel=0.05)
    pair = fit_all(search.problem, [replace(start, theta=start.theta * 1.1)], steps=3)
    known = known.adding({frozenset(model.names): pair[0]})
    (better,) = _with_limits(search, known, [start], at_noise=False)
    assert better.limit <= search.score(pair[0]) - 2.0 * PENALTY


def test_several_effects_have_to_come_near_another_law_that_leaves_but_noise() -> None:
    both = {"viscous_friction": {"c": 0.06}, "sensor_drift": {"b": 2e-4}}
    search = search_for(both, *NAMES, "sensor_drift")
    one = fit_of(search, "viscous_friction")
    noise = float(search.problem.degrees())
    assert one.chi2 > noise + 2.0 * SLACK
    known = Collection({frozenset(): search.none, frozenset({"viscous_friction"}): one}, law=noise)
    model = search.model(("drive_delay", "sensor_drift"))
    (start,) = start_fits(search.nuisances, model, np.array([[0.001, 1e-5]]))
    for rival in (None, one):
        (limited,) = _with_limits(search, known, [start], at_noise=False, rival=rival)
        assert limited.limit == noise + SLACK - 2.0 * PENALTY


def test_what_leaves_less_than_noise_gives_its_place_only_to_what_leaves_still_less() -> None:
    search = search_for({"viscous_friction": {"c": 0.06}}, *NAMES)
    best = fit_of(search, "viscous_friction")
    low = replace(best, chi2=0.5 * search.problem.degrees())
    assert takes_place(search, low) == low.chi2 - TIE


def test_of_fits_that_came_to_one_end_one_is_followed() -> None:
    search = search_for({"viscous_friction": {"c": 0.06}}, *NAMES)
    model = search.model(NAMES[:1])
    starts = start_fits(search.nuisances, model, np.array([[0.05], [0.07], [0.5]]))
    assert len(apart(starts)) == 3
    ends = fit_all(search.problem, starts[:2], steps=20)
    # The first steps from far away lead to no end.
    ends += fit_all(search.problem, starts[2:], steps=1)
    assert apart(ends) == [ends[0], ends[2]]


def test_a_fit_that_ended_beside_the_best_valley_is_taken_there() -> None:
    search = search_for({"viscous_friction": {"c": 0.06}}, *NAMES)
    best = fit_of(search, "viscous_friction")
    assert beyond_ridges(search, best) is best
    (beside,) = evaluate(search.problem, [best.unfitted(best.theta + 6.0 * best.stds)])
    stuck = replace(beside, covariance=best.covariance)
    assert stuck.chi2 > best.chi2 + 10.0
    found = beyond_ridges(search, stuck)
    assert found.chi2 == pytest.approx(best.chi2, abs=0.1)
    assert beyond_ridges(search, stuck, lambda _: best.chi2 - 1.0) is stuck
    (free,) = best.model.free
    at_the_end = replace(stuck, theta=np.array([free.low]))
    assert not free.log
    assert beyond_ridges(search, at_the_end).theta[0] >= free.low
