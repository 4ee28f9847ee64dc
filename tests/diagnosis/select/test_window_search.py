"""Searches in windows of runs that are replayed whole."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis_search import search_of
from diagnosis_small import driven, measured
from locosweep.diagnosis.estimate.shooting import WindowProblem
from locosweep.diagnosis.select.search import Collection
from locosweep.diagnosis.select.window_search import (
    best_in_windows,
    search_windows,
    singles_in_windows,
)

NAMES = ("viscous_friction", "sensor_drift")
BOTH = {"viscous_friction": {"c": 0.06}, "sensor_drift": {"b": 3e-3}}


def test_what_is_best_in_windows_is_followed_along_whole_runs() -> None:
    search = search_of(measured(BOTH, driven(3, 6.0)), *NAMES)
    windows = search_windows(search)
    assert windows
    assert all(isinstance(one.search.problem, WindowProblem) for one in windows)
    assert [len(one.singles) for one in windows] == [2] * len(windows)
    known = Collection({frozenset(): search.none}, 1)
    known = known.adding(singles_in_windows(search, known, windows))
    assert {*known.fits} == {frozenset(), *(frozenset({name}) for name in NAMES)}
    seeds = [known.fits[frozenset({"viscous_friction"})]]
    found = best_in_windows(search, known, windows, seeds)
    assert found[frozenset(BOTH)].named()["sensor_drift"]["b"] == pytest.approx(3e-3, rel=0.05)


def test_windows_are_not_cut_again() -> None:
    search = search_of(measured({}, driven(3, 6.0)), *NAMES)
    assert search_windows(search_windows(search)[0].search) == []


def test_where_hardly_anything_is_measured_there_are_no_windows() -> None:
    runs = measured({}, driven(3, 6.0))
    for run in runs:
        run.channels["x"][np.arange(600) % 30 != 0] = np.nan
    assert search_windows(search_of(runs, *NAMES)) == []
