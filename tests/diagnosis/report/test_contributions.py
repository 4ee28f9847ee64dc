"""What each cause takes away, added to those before it."""

from __future__ import annotations

from functools import partial

import pytest

from diagnosis_search import fit_of, search_of
from diagnosis_small import driven, measured
from locosweep.diagnosis.report.comparison import compare_whole_runs
from locosweep.diagnosis.report.contributions import chain_of, contributions, remaining
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


def test_what_is_left() -> None:
    gap = {"before": 2e-3, "after": 5e-4, "noise_floor": 1e-5}
    found = remaining(gap, [])
    assert found == {"share": 0.25, "rmse": 5e-4, "noise_floors": 50.0, "shape": []}
    gap = {"before": None, "after": None, "noise_floor": 1e-5}
    assert remaining(gap, [])["share"] is None
