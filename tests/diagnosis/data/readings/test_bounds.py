"""Bounds on what a rig could do."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.data.readings.bounds import (
    largest_acceleration,
    largest_force,
    resistance,
)
from locosweep.files.runs import Run

T = np.arange(4.0)
NOMINAL = {"mass": 2.0, "gravity": 10.0, "gain": 0.5, "mu_coulomb": 0.3, "slope_deg": 0.0}


def test_all_forces_add_up() -> None:
    run = Run("0", T, np.array([0.0, 3.0, -8.0, 1.0]))
    assert resistance(run, NOMINAL) == pytest.approx(6.0)
    assert largest_force(run, NOMINAL) == pytest.approx(4.0 + 6.0)
    assert largest_acceleration(run, NOMINAL) == pytest.approx(5.0)


def test_a_slope_of_the_run_adds_its_weight() -> None:
    run = Run("0", T, np.zeros(4), slope_deg=-30.0)
    assert resistance(run, NOMINAL) == pytest.approx(6.0 * np.cos(np.radians(30.0)) + 10.0)


def test_a_pendulum_adds_its_torque() -> None:
    bench = {"mass": 0.1, "gravity": 9.81, "gain": 1.0, "coulomb_force": 0.2, "slope_deg": 0.0,
             "gravity_torque": 3.0}  # fmt: skip
    run = Run("0", T, np.ones(4))
    assert largest_force(run, bench) == pytest.approx(1.0 + 0.2 + 3.0)
