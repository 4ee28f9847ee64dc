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
from locosweep.diagnosis.report.improvement import share_interval
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


@pytest.fixture(scope="module")
def beside_rest():
    search = search_of(rig({"viscous_friction": {"c": 0.15}}, hidden=0.003, count=6), *NAMES)
    return graded(search, singles(search), 1)


def beside(found, none, before, chosen):
    """The row of a cause whose models leave some mean squares, in two blocks of each run."""
    (cause,) = found.causes
    models = [replace(found.none, squares=np.repeat(one, 2)) for one in (none, before)]
    if before is none:
        models[1] = models[0]
    after = replace(cause.chosen, squares=np.repeat(chosen, 2))
    known = replace(cause, before=models[1], chosen=after)
    of_run = np.repeat(np.arange(len(none)), 2)
    (row,) = graded_contributions(replace(found, none=models[0], causes=(known,), of_run=of_run), 0)
    return row


def test_shares_beside_a_rest_hold_for_as_many_new_runs(beside_rest) -> None:
    """Whole runs vary, not their blocks: half of a run says nothing of another run."""
    none, after = np.ones(6), np.array([0.01, 0.04, 0.01, 0.04, 0.09, 0.01])
    row = beside(beside_rest, none, none, after)
    assert row["share"] == pytest.approx(1.0 - np.sqrt(after.mean()))
    low, high = row["share_ci"]
    # The errors that are left of single runs are 0.1 to 0.3.
    assert 0.6 < low < row["share"] - 0.08
    assert row["share"] + 0.08 < high < 0.95


def test_runs_that_all_say_the_same_leave_no_doubt(beside_rest) -> None:
    scale = np.array([1.0, 2.0, 3.0, 4.0])
    first = beside(beside_rest, scale, scale, 0.25 * scale)
    second = beside(beside_rest, scale, 0.25 * scale, 0.0625 * scale)
    for row, share in ((first, 0.5), (second, 0.25)):
        assert row["share"] == pytest.approx(share)
        assert row["share_ci"] == pytest.approx([share, share], abs=1e-6)


def test_two_runs_say_nothing_of_others(beside_rest) -> None:
    none = np.ones(2)
    assert beside(beside_rest, none, none, 0.1 * none)["share_ci"] is None


def test_the_interval_of_a_second_cause_holds_for_new_runs() -> None:
    """Drawn from a known distribution: 90 of 100 new sets of runs have their share inside."""
    random = np.random.default_rng(4)

    def runs() -> np.ndarray:
        fallen = np.exp(random.normal(-1.0, 0.3, 6)), np.exp(random.normal(-0.7, 0.2, 6))
        none = np.exp(random.normal(0.0, 0.5, 6))
        return np.stack([none, none * fallen[0], none * fallen[0] * fallen[1]], axis=1)

    def share(table: np.ndarray) -> float:
        none, before, after = np.sqrt(table.mean(axis=0))
        return float((before - after) / none)

    inside = 0
    for _ in range(200):
        known = runs()
        low, high = share_interval(known, share(known), random)
        inside += low <= share(runs()) <= high
    assert 0.85 <= inside / 200 <= 0.97


def test_what_is_left() -> None:
    gap = {"before": 2e-3, "after": 5e-4, "noise_floor": 1e-5}
    found = remaining(gap, [])
    assert found == {"share": 0.25, "rmse": 5e-4, "noise_floors": 50.0, "shape": []}
    gap = {"before": None, "after": None, "noise_floor": 1e-5}
    assert remaining(gap, [])["share"] is None
