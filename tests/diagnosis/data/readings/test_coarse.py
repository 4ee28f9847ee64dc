"""Runs in steps."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.data.readings.coarse import coarse
from locosweep.files.runs import Run

T = np.arange(401) * 0.01
NOMINAL = {"mass": 2.0, "gravity": 10.0, "gain": 3.0, "slope_deg": 0.0}


def test_an_even_acceleration_and_its_work() -> None:
    run = Run("0", T, np.full(401, 2.0))
    found = coarse(run, 0.5 * 1.5 * T**2, NOMINAL)
    assert found is not None
    assert found.accelerations == pytest.approx(1.5, rel=1e-2)
    assert found.force == pytest.approx(6.0)
    assert found.work[0] == pytest.approx(6.0 * found.span)
    assert found.work[0] == found.work[1]


def test_weight_and_torque_belong_to_the_force() -> None:
    uphill = coarse(Run("0", T, np.zeros(401), slope_deg=30.0), T, NOMINAL)
    assert uphill is not None
    assert uphill.force == pytest.approx(-10.0)
    hanging = coarse(Run("0", T, np.zeros(401)), np.full(401, np.pi / 2),
                     {**NOMINAL, "gravity_torque": 4.0})  # fmt: skip
    assert hanging is not None
    assert hanging.force == pytest.approx(-4.0)


def test_bad_and_missing_readings_do_not_matter() -> None:
    x = np.sin(T)
    clean = coarse(Run("0", T, np.zeros(401)), x, NOMINAL)
    x = x.copy()
    x[::20], x[7::20] = 1e9, np.nan
    spoilt = coarse(Run("0", T, np.zeros(401)), x, NOMINAL)
    assert clean is not None
    assert spoilt is not None
    assert spoilt.span == pytest.approx(clean.span, rel=0.02)


def test_too_little_says_nothing() -> None:
    assert coarse(Run("0", T[:5], np.zeros(5)), T[:5], NOMINAL) is None
