"""What each cause takes away, added to those before it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from diagnosis_rest import NAMES, rig
from diagnosis_search import fit_of, search_of
from diagnosis_small import driven, measured
from locosweep.diagnosis.report.comparison import compare_whole_runs
from locosweep.diagnosis.report.contributions import (
    chain_of,
    contributions,
    graded_contributions,
    remaining,
)
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.graded import graded
from locosweep.diagnosis.select.search import Collection

BOTH = {"viscous_friction": {"c": 0.2}, "sensor_scale": {"e": 0.02}}


@pytest.fixture(scope="module")
def rows():
    search = search_of(measured(BOTH, driven(5)), *BOTH, held=(1, 3))
    whole = fit_of(search, *BOTH)
    chain = chain_of(search, Collection({}), whole, [["viscous_friction", "x"], ["sensor_scale"]])
    compare = partial(compare_whole_runs, search.problem)
    return contributions(search.problem, search.problem.plain(), chain, compare, "x", seed=0)


def test_shares_add_up_to_the_whole_fall(rows) -> None:
    assert sum(row["share"] for row in rows) > 0.99
    assert rows[0]["share"] == rows[0]["alone"] > rows[1]["share"] > 0.0
    assert [row["effects"] for row in rows] == [["viscous_friction", "x"], ["sensor_scale"]]


def test_shares_lie_within_their_intervals(rows) -> None:
    for row in rows:
        low, high = row["share_ci"]
        assert low <= row["share"] <= high


def test_shares_beside_a_rest_hold_for_as_many_new_runs() -> None:
    """Whole runs vary, not their blocks: half of a run's blocks say nothing of another run."""
    search = search_of(rig({"viscous_friction": {"c": 0.15}}, hidden=0.003, count=6), *NAMES)
    found = graded(search, singles(search), 1)
    none, after = np.ones(12), np.repeat([0.01, 0.04, 0.01, 0.04, 0.09, 0.01], 2)
    (cause,) = found.causes
    before, chosen = replace(found.none, squares=none), replace(cause.chosen, squares=after)
    known = replace(found, none=before, causes=[replace(cause, before=before, chosen=chosen)])
    (row,) = graded_contributions(known, 0)
    assert row["share"] == pytest.approx(1.0 - np.sqrt(after.mean()))
    low, high = row["share_ci"]
    # The errors that are left of single runs are 0.1 to 0.3.
    assert 0.6 < low < row["share"] - 0.03
    assert row["share"] + 0.03 < high < 0.95


def test_what_is_left() -> None:
    gap = {"before": 2e-3, "after": 5e-4, "noise_floor": 1e-5}
    found = remaining(gap, [])
    assert found == {"share": 0.25, "rmse": 5e-4, "noise_floors": 50.0, "shape": []}
    gap = {"before": None, "after": None, "noise_floor": 1e-5}
    assert remaining(gap, [])["share"] is None
