"""A force by place and friction along the way: one in one direction, two in both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import fit_of, search_of
from diagnosis_small import driven, measured
from locosweep.diagnosis.select.by_place import by_place_ahead, is_one_by_place, passes_both_ways
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.search import Collection, Search
from locosweep.diagnosis.select.verdict import Choice
from locosweep.diagnosis.select.whiteness import whiteness_test

ROUGH = {"position_dependent_friction": {"a": 0.01, "L": 0.05, "p": 0.3}}


def rough(*, forward: bool) -> Search:
    """A search over runs on a rough way that is passed forward, or both ways."""
    runs = driven()
    if forward:
        runs = [replace(run, drive=np.abs(run.drive)) for run in runs]
    return search_of(measured(ROUGH, runs), *ROUGH)


@pytest.mark.parametrize("forward", [True, False])
def test_friction_does_better_than_a_force_by_place_where_heads_come_back(forward: bool) -> None:
    search = rough(forward=forward)
    assert passes_both_ways(search.problem) == (not forward)
    ahead = by_place_ahead(NonparametricCorrection(search.problem, search.none), 1.0)
    assert ahead == 0.0 if forward else ahead < -100.0


@pytest.mark.parametrize("forward", [True, False])
def test_friction_that_is_named_is_one_with_a_force_by_place_in_one_direction(
    forward: bool,
) -> None:
    search = rough(forward=forward)
    fit = fit_of(search, *ROUGH)
    white = whiteness_test(search.problem, fit.residual)
    named = Choice(
        "explained", fit, Collection({frozenset(): search.none}), white, classes=[[*ROUGH]]
    )
    assert is_one_by_place(search, named) == forward
    assert not is_one_by_place(search, replace(named, classes=[["viscous_friction"]]))
    assert not is_one_by_place(search, replace(named, status="unexplained", classes=[]))
