"""What a report says of laws beside the listed formulas."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from diagnosis_search import fit_of, search_of
from diagnosis_small import driven, measured, tethered
from locosweep.diagnosis.report import laws_found
from locosweep.diagnosis.report.assemble import Findings
from locosweep.diagnosis.report.laws_found import laws_of_causes, unlisted_entry
from locosweep.diagnosis.select.search import Collection
from locosweep.diagnosis.select.verdict import Choice
from locosweep.diagnosis.select.whiteness import whiteness_test

if TYPE_CHECKING:
    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.force_law import ForceLaw
    from locosweep.diagnosis.select.search import Search


def findings(search: Search, status: str, fit: Fit, unlisted: str = "", **changes: Any) -> Findings:
    """What a diagnosis would have found."""
    known = Collection({frozenset(): search.none})
    whiteness = whiteness_test(search.problem, fit.residual)
    choice = Choice(status, fit, known, whiteness, unlisted=unlisted, **changes)
    return Findings(search, choice, search.problem, None, None, False, {}, {}, (), (), unlisted)


@pytest.fixture(scope="module")
def spring() -> Search:
    """Runs that a spring pulls back."""
    return search_of(tethered(), "viscous_friction", held=(3,))


def test_a_force_that_outdoes_every_effect_has_formula_and_share(spring: Search) -> None:
    row = unlisted_entry(findings(spring, "unexplained", spring.none, "terrain"))
    assert row is not None
    assert row["outdoes"]
    assert row["formula"].endswith("mN/m of x")
    assert row["share"] > 0.6
    assert len(row["curve"]["at"]) == len(row["curve"]["value"])


def test_a_push_of_each_run_has_none(spring: Search) -> None:
    row = unlisted_entry(findings(spring, "unexplained", spring.none, "push"))
    assert row is not None
    assert (row["formula"], row["share"], row["curve"]) == (None, None, None)


def test_a_gap_that_nothing_accounts_for_is_said_to_look_like_something(spring: Search) -> None:
    row = unlisted_entry(findings(spring, "unexplained", spring.none))
    assert row is not None
    assert not row["outdoes"]
    assert row["variable"] == "place"
    assert unlisted_entry(findings(spring, "none", spring.none)) is None


def test_along_a_way_passed_in_one_direction_a_gap_looks_like_a_force_by_place(
    spring: Search, monkeypatch: pytest.MonkeyPatch
) -> None:
    chosen = laws_found.force_law(spring.problem, spring.none, "terrain")
    assert chosen is not None
    along = replace(chosen, variable="place", log_factor=chosen.log_factor + 1.0)
    # As if friction along the way were the likeliest law.
    law = laws_found.force_law

    def likeliest(problem: Problem, fit: Fit, variable: str) -> ForceLaw | None:
        return law(problem, fit, variable) if variable == "terrain" else along

    monkeypatch.setattr(laws_found, "force_law", likeliest)
    for both, variable in ((True, "odd"), (False, "even")):
        monkeypatch.setattr(laws_found, "passes_both_ways", lambda _, both=both: both)
        row = unlisted_entry(findings(spring, "unexplained", spring.none))
        assert row is not None
        assert row["parity"] == variable


def test_noise_looks_like_nothing() -> None:
    search = search_of(measured({}, driven(3)), "viscous_friction")
    assert unlisted_entry(findings(search, "unexplained", search.none)) is None


def test_the_whole_law_of_a_cause_is_shown_not_what_it_has_more_than_the_formula() -> None:
    search = search_of(measured({"quadratic_drag": {"c2": 0.002}}, driven(4)), "viscous_friction")
    fit = fit_of(search, "viscous_friction")
    assert laws_of_causes(findings(search, "explained", fit)) == []
    (row,) = laws_of_causes(findings(search, "explained", fit, law_mismatch=True))
    assert (row["effect"], row["variable"], row["parity"]) == ("viscous_friction", "speed", "odd")
    assert row["formula"].endswith("as its power 2")
    at, by = (np.array(row["curve"][key]) for key in ("at", "by_formula"))
    assert np.allclose(by[-1], 0.002 * at[-1] ** 2, rtol=0.1)
