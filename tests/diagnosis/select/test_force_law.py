"""The law that a model lacks: its curve and its formula."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import fit_of, search_of
from diagnosis_small import STIFFNESS, driven, measured, tethered, uneven
from locosweep.diagnosis.select import force_law as module
from locosweep.diagnosis.select.force_law import force_law, is_monotone, is_steady


def test_a_tether_pulls_back_in_proportion_to_the_way() -> None:
    search = search_of(tethered(), "viscous_friction", held=(3,))
    law = force_law(search.problem, search.none, "terrain")
    assert law is not None
    off = law.size + STIFFNESS * law.at
    assert np.all(np.abs(off) < 6.0 * law.deviation)
    assert law.found is not None
    assert np.allclose(law.found.at(law.at), -STIFFNESS * law.at, atol=2e-5)


def test_friction_that_grows_with_the_speed_is_a_positive_resistance() -> None:
    search = search_of(measured({"quadratic_drag": {"c2": 0.002}}, driven(4)), "quadratic_drag")
    law = force_law(search.problem, search.none, "speed")
    assert law is not None
    assert law.at.min() >= 0.0
    assert law.found is not None
    fast = law.at > 0.5 * law.at.max()
    assert np.allclose(law.found.at(law.at)[fast], 0.002 * law.at[fast] ** 2, rtol=0.1)


def test_what_a_fit_explains_is_no_law() -> None:
    search = search_of(measured({"viscous_friction": {"c": 0.05}}, driven(4)), "viscous_friction")
    law = force_law(search.problem, fit_of(search, "viscous_friction"), "speed")
    assert law is None or law.found is None


@pytest.mark.parametrize("variable", ["change", "history"])
def test_some_variables_have_no_curve(variable: str) -> None:
    search = search_of(measured({}, driven(2)), "viscous_friction")
    assert force_law(search.problem, search.none, variable) is None


def test_a_law_that_rises_takes_no_less_than_a_curve_and_one_that_swings_less() -> None:
    rising = measured({"quadratic_drag": {"c2": 0.002}}, driven(4))
    search = search_of(rising, "quadratic_drag")
    assert is_monotone(search.problem, search.none, "speed")
    wave = {"position_dependent_friction": {"a": 0.001, "L": 0.05, "p": 0.0}}
    search = search_of(measured(wave, driven(4)), "position_dependent_friction")
    assert not is_monotone(search.problem, search.none, "place")


def test_a_large_gap_may_be_told_by_a_law_that_rises_as_far_as_first_order_says(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A drive that falls by a tenth in the middle of a run moves heads beyond first order."""
    runs = driven(4)
    real = [replace(r, drive=r.drive * (0.95 - 0.05 * np.tanh((r.t - 1.0) / 0.1))) for r in runs]
    told = [replace(one, drive=r.drive) for one, r in zip(measured({}, real), runs, strict=True)]
    search = search_of(told, "supply_sag")
    assert is_monotone(search.problem, search.none, "sag")
    monkeypatch.setattr(module, "FIRST_ORDER", 0.0)
    assert not is_monotone(search.problem, search.none, "sag")


def test_an_uneven_slope_stays_near_its_mean_and_a_tether_does_not() -> None:
    for runs, steady in ((uneven(), True), (tethered(), False)):
        search = search_of(runs, "slope_error")
        assert is_steady(search.problem, search.none, "terrain") == steady


def test_the_formula_of_what_changes_at_once_jumps() -> None:
    """A drive that acts less from the middle of a run on, and one that acts ever less."""
    runs = driven(4)
    for falls, jumps in ((lambda t: 1.0 * (t > 1.0), True), (lambda t: 0.5 * t, False)):
        real = [replace(run, drive=run.drive * (1.0 - 2e-4 * falls(run.t))) for run in runs]
        read = measured({}, real)
        told = [replace(one, drive=run.drive) for one, run in zip(read, runs, strict=True)]
        search = search_of(told, "supply_sag")
        assert is_monotone(search.problem, search.none, "sag")
        law = force_law(search.problem, search.none, "sag")
        assert law is not None
        assert law.found is not None
        assert law.found.may_jump == jumps
