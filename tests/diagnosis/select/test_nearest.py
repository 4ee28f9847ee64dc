"""The nearest set of effects, compared window by window."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import search_for
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.nearest import Nearest, nearest

NAMES = ("viscous_friction", "sensor_drift")


def test_what_takes_most_in_all_runs_is_nearest() -> None:
    search = search_for({"viscous_friction": {"c": 0.06}}, *NAMES)
    known = singles(search)
    found = nearest(search, known)
    assert found is not None
    assert found.fit.model.names == ("viscous_friction",)
    assert found.fits == [found.fit]
    assert all(len(key) < 2 for key in known.fits)


def test_where_nothing_helps_nothing_is_near() -> None:
    search = search_for({"drive_delay": {"T": 0.01}}, "sensor_drift")
    assert nearest(search, singles(search)) is None


def test_weights_count_a_window_for_one_sample() -> None:
    search = search_for({}, *NAMES)
    a = replace(search.none, chi2=400.0)
    b, c = replace(a, chi2=440.0), replace(a, chi2=480.0)
    rows = Nearest(a, [a, b]).weighed([b, c], windows=20)
    assert [fit for fit, _ in rows] == [a, b, c]
    weights = np.exp([0.0, -1.0, -2.0])
    assert [w for _, w in rows] == pytest.approx(list(weights / weights.sum()))
