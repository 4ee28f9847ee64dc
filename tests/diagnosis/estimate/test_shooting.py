"""Windows that are replayed from the state measured at their starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_long import PENDULUM, SLED, drives, in_windows, measured, whole
from locosweep.diagnosis.estimate.shooting import knows_start
from locosweep.files.runs import Run


@pytest.mark.parametrize("robot", [SLED, PENDULUM], ids=["sled", "pendulum"])
@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("viscous_friction", {"c": 0.05}),
        ("sensor_scale", {"e": 0.03}),
        ("sensor_drift", {"b": 0.01}),
        ("sensor_delay", {"T": 0.01}),
        ("drive_delay", {"T": 0.02}),
        ("friction_drift", {"a": 0.3, "T": 5.0}),
        ("lubricant_buildup", {"k_b": 0.2}),
    ],
)
def test_the_truth_leaves_noise(robot, name, values):
    windows = in_windows(whole(robot, measured(robot, {name: values}, drives(robot))))
    plain = windows.plain()
    true = replace(plain, names=(name,), values=plain.values.copy())
    for key, value in values.items():
        true.values[windows.parameter_index(name, key)] = value
    nominal, left = (windows.residuals([plain, true]) ** 2).sum(axis=1) / windows.degrees()
    assert nominal > 2.0
    assert 0.9 < left < 1.25
    assert sum(windows.degrees([r]) for r in windows.fitted) == windows.degrees()


def test_a_start_is_known_where_enough_was_read_around_it():
    t, x = np.arange(0.0, 1.0, 0.01), np.zeros(100)
    x[40:60] = np.nan
    run = Run("0", t, np.zeros(100), {"x": x})
    assert knows_start(run, 20, 0.05)
    assert not knows_start(run, 50, 0.05)


def test_windows_are_replayed_under_drives_of_their_own():
    windows = in_windows(whole(SLED, measured(SLED, {}, drives(SLED))))
    plain, every = [windows.plain()], range(len(windows.runs))
    before = windows.replay(plain, every)["x"]
    same = windows.driven_by([run.drive for run in windows.runs])
    np.testing.assert_array_equal(same.replay(plain, every)["x"], before)
    more = windows.driven_by([run.drive + 0.5 for run in windows.runs])
    assert np.abs(more.replay(plain, every)["x"] - before).max() > 1e-3
