"""Which causes unseen runs confirm, and which of them are alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_rest import NAMES, rig
from diagnosis_search import fit_of, search_of
from diagnosis_small import measured
from locosweep.diagnosis.estimate.rest import RestForce
from locosweep.diagnosis.select.beside_rest import Candidate, compare_beside_rest
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.next_cause import (
    Cause,
    _narrower,
    is_confirmed,
    motion_size,
    next_cause,
    one_for_two,
)


def test_what_takes_little_away_is_no_first_cause_but_a_further_one() -> None:
    """A seventh less error in each block of unseen runs, and surely likelier."""
    search = search_of(measured({}), *NAMES)
    known = singles(search)
    one, other = known.single("viscous_friction"), known.single("coulomb_error")
    compared = compare_beside_rest(search, RestForce(search.problem), search.none, [])
    errors = np.linspace(1.0, 1.1, 8)
    after = Candidate(one, 0.0, (0.86 * errors) ** 2)
    for before, named in ((search.none, False), (other, True)):
        base = Candidate(before, 500.0, errors**2)
        now = replace(compared, base=base, inflation=1.0)
        assert is_confirmed(now, after, base) == named


@pytest.mark.parametrize(("left", "named"), [(0.4, True), (0.6, False)])
def test_what_is_correlated_in_the_rest_does_not_count_against_what_halves_unseen_errors(
    left: float, named: bool
) -> None:
    search = search_of(rig({}, hidden=0.002), *NAMES)
    one = singles(search).single("viscous_friction")
    errors = np.linspace(1.0, 1.1, 8)
    base = Candidate(search.none, 50.0, errors**2)
    compared = compare_beside_rest(search, RestForce(search.problem), search.none, [])
    now = replace(compared, base=base, inflation=3.0)
    after = Candidate(one, 0.0, (left * errors) ** 2)
    assert is_confirmed(now, after, base) == named
    assert is_confirmed(replace(now, inflation=1.0), after, base)


def test_a_limit_that_predicts_as_well_stands_for_its_wider_law() -> None:
    def candidate(error: float) -> Candidate:
        return Candidate(None, 0.0, np.array([error**2]))  # type: ignore[arg-type]

    wide = {"supply_sag": candidate(1.0)}
    able = wide | {"drive_gain_error": candidate(1.2), "viscous_friction": candidate(1.0)}
    assert set(_narrower(wide, able)) == {"drive_gain_error"}
    assert not _narrower(wide, wide | {"drive_gain_error": candidate(1.4)})
    assert not _narrower(wide, wide)


@pytest.mark.parametrize(("error", "named"), [(1.05, True), (1.2, False)])
def test_two_causes_are_the_one_effect_whose_limits_they_are(error: float, named: bool) -> None:
    both = ("slope_error", "coulomb_error")
    search = search_of(measured({}), *both, "viscous_friction", "direction_dependent_friction")

    def candidate(error: float, *names: str) -> Candidate:
        return Candidate(fit_of(search, *names), 0.0, np.array([error**2]))

    none = Candidate(search.none, 0.0, np.array([9.0]))
    first, second = candidate(2.0, both[0]), candidate(1.0, *both)
    causes = [
        Cause((both[0],), first, none, agrees=True, weight=0.5),
        Cause(("viscous_friction", both[1]), second, first, agrees=True, weight=0.5),
    ]
    wide = candidate(error, "direction_dependent_friction")
    found = one_for_two(causes, [first, wide], search.problem)
    assert (found is not None) == named
    if found:
        assert (found.names, found.chosen, found.before) == (wide.fit.model.names, wide, none)
        assert found.weight == 0.25
    # Neither one alone, nor two that are limits of no one effect, nor three.
    assert one_for_two(causes[:1], [wide], search.problem) is None
    assert one_for_two([causes[0], causes[0]], [wide], search.problem) is None
    assert one_for_two([*causes, causes[1]], [wide], search.problem) is None


@pytest.mark.parametrize(
    ("size", "likely", "named"),
    [
        (0.3, False, ("viscous_friction",)),
        (0.3, True, ("coulomb_error",)),
        (0.05, False, ()),
    ],
)
def test_beside_a_rest_that_nobody_knows_what_halves_the_error_need_not_be_likely(
    size: float, likely: bool, named: tuple[str, ...]
) -> None:
    """Unless something that halves it is: that stands in its place."""
    search = search_of(rig({}, hidden=0.002), "viscous_friction", "coulomb_error")
    known = singles(search)
    now = compare_beside_rest(search, RestForce(search.problem), search.none, [])
    error = size * motion_size(now.problem) * np.ones(8)
    base = Candidate(search.none, 0.0, error**2)
    others = [
        Candidate(known.single("viscous_friction"), 500.0, (0.3 * error) ** 2),
        Candidate(known.single("coulomb_error"), -500.0, ((0.45 if likely else 0.9) * error) ** 2),
    ]
    cause = next_cause(replace(now, base=base, others=others, inflation=1.0), search.none, base)
    assert (cause.names if cause else ()) == named


@pytest.mark.parametrize(
    ("size", "named"),
    [(0.05, ("drive_lag",)), (0.3, ("viscous_friction", "stribeck_friction"))],
)
def test_of_large_errors_prediction_says_what_is_alike(size: float, named: tuple[str, ...]) -> None:
    """The likeliest beside the rest errs 40 % more: of small errors it is named all the same."""
    search = search_of(rig({}, hidden=0.002), "viscous_friction", "drive_lag", "stribeck_friction")
    known = singles(search)
    now = compare_beside_rest(search, RestForce(search.problem), search.none, [])
    error = size * motion_size(now.problem) * np.ones(8)
    base = Candidate(search.none, 5000.0, (4.0 * error) ** 2)
    errors = {
        "drive_lag": (0.0, 1.4),
        "viscous_friction": (900.0, 1.05),
        "stribeck_friction": (500.0, 1.0),
    }
    others = [
        Candidate(known.single(name), deviance, (part * error) ** 2)
        for name, (deviance, part) in errors.items()
    ]
    cause = next_cause(replace(now, base=base, others=others, inflation=1.0), search.none, base)
    assert cause is not None
    assert cause.names == named
    assert 0.5 < cause.weight <= 1.0


@pytest.mark.parametrize(("more", "named"), [(1.2, 2), (1.4, 1)])
def test_fewer_parameters_are_as_good_with_somewhat_more_error(more: float, named: int) -> None:
    search = search_of(rig({}, hidden=0.002), "viscous_friction", "stribeck_friction")
    known = singles(search)
    now = compare_beside_rest(search, RestForce(search.problem), search.none, [])
    error = 0.3 * motion_size(now.problem) * np.ones(8)
    base = Candidate(search.none, 5000.0, (4.0 * error) ** 2)
    others = [
        Candidate(known.single("stribeck_friction"), 0.0, error**2),
        Candidate(known.single("viscous_friction"), 0.0, (more * error) ** 2),
    ]
    cause = next_cause(replace(now, base=base, others=others, inflation=1.0), search.none, base)
    assert cause is not None
    assert len(cause.names) == named
    assert cause.names[0] == ("viscous_friction" if named == 2 else "stribeck_friction")


@pytest.mark.parametrize("size", [0.05, 0.3])
def test_of_two_ends_of_one_effect_the_better_one_is_named(size: float) -> None:
    search = search_of(rig({}, hidden=0.002), "viscous_friction")
    fit = singles(search).single("viscous_friction")
    now = compare_beside_rest(search, RestForce(search.problem), search.none, [])
    error = size * motion_size(now.problem) * np.ones(8)
    base = Candidate(search.none, 5000.0, (4.0 * error) ** 2)
    better = Candidate(fit, 0.0, error**2)
    worse = Candidate(fit, 5.0, (1.05 * error) ** 2)
    for others in ([better, worse], [worse, better]):
        cause = next_cause(replace(now, base=base, others=others, inflation=1.0), search.none, base)
        assert cause is not None
        assert cause.chosen is better
