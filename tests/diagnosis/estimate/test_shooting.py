"""Windows that are replayed from the state measured at their starts."""

from __future__ import annotations

from dataclasses import replace

import pytest

from diagnosis_long import PENDULUM, SLED, drives, in_windows, measured, whole


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
