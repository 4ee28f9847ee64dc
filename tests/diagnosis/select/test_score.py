"""When an effect gains enough, and what a fit leaves."""

from __future__ import annotations

from dataclasses import replace

import pytest

from diagnosis_search import fit_of, search_for, search_of
from diagnosis_small import measured
from locosweep.diagnosis.select.score import gains, remaining, stalled_above, stalled_beside, total
from locosweep.diagnosis.select.thresholds import LEAST_GAIN, PENALTY


def test_the_gain_asked_for_is_beside_the_price_of_the_parameters() -> None:
    search = search_for({}, "viscous_friction")
    one = fit_of(search, "viscous_friction")
    enough = replace(one, chi2=search.none.chi2 - PENALTY - LEAST_GAIN)
    assert gains(search, search.none, enough)
    assert not gains(search, search.none, replace(enough, chi2=enough.chi2 + 0.01))


def test_held_out_runs_count_but_do_not_decide_alone() -> None:
    search = search_of(measured({"viscous_friction": {"c": 0.02}}), "viscous_friction", held=(1,))
    one = fit_of(search, "viscous_friction")
    assert total(search, one) == pytest.approx(search.score(one) + search.unseen_chi2(one))
    assert gains(search, search.none, one)
    bent = replace(one, chi2=search.none.chi2 - PENALTY - 1.0)
    assert total(search, search.none) - total(search, bent) > LEAST_GAIN
    assert not gains(search, search.none, bent)


def test_a_gap_is_left_in_the_variable_of_its_cause() -> None:
    search = search_for({"quadratic_drag": {"c2": 0.3}})
    assert dict(remaining(search.problem, search.none))["speed"] > 0.5
    truth = search_for({})
    assert remaining(truth.problem, truth.none) == []


@pytest.mark.parametrize(("rest", "left", "stalled"), [
    (1000.0, 600.0, True), (1000.0, 400.0, False), (150.0, 140.0, False), (200.0, 190.0, True),
])  # fmt: skip
def test_an_effect_stalls_that_leaves_most_of_a_clear_rest(
    rest: float, left: float, stalled: bool
) -> None:
    """Of 800 residuals, chi2 deviates by 40: four of these are clear."""
    assert (800.0 + left > stalled_above(800.0 + rest, 800.0, 800)) is stalled


def test_an_effect_beside_a_fit_has_to_take_half_of_its_rest() -> None:
    search = search_for({})
    noise = search.problem.degrees()
    assert stalled_beside(search.problem, search.none) == float("inf")
    far = replace(search.none, chi2=19.0 * noise)
    assert stalled_beside(search.problem, far) == pytest.approx(10.0 * noise, rel=0.1)
