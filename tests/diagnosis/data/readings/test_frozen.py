"""Stretches of one reading: frozen encoders and heads at rest."""

from __future__ import annotations

import numpy as np

from locosweep.diagnosis.data.noise import Noise
from locosweep.diagnosis.data.readings.frozen import frozen

T = np.arange(300) * 0.01
PUSHED = np.ones(300, dtype=bool)
SD = 2e-5


def moving(step: float, noise: float) -> np.ndarray:
    """Rest for a second, then a slide."""
    x = 0.2 * np.maximum(T - 1.0, 0.0) + np.random.default_rng(0).normal(0.0, noise, 300)
    return np.round(x / step) * step


def found(x: np.ndarray, step: float, flicker: float, pushed: np.ndarray = PUSHED) -> list[int]:
    noise = Noise(float(np.hypot(flicker, step / 12**0.5)), flicker, step, stated=True)
    return np.flatnonzero(frozen(T, x, noise, flicker, 5.0, pushed)).tolist()


def test_noise_does_not_repeat_one_value() -> None:
    x = moving(1e-7, SD)
    assert found(x, 1e-7, SD) == []
    x[30:60] = x[30]
    # At rest: no jump tells, only that noise is missing.
    assert found(x, 1e-7, SD) == list(range(31, 60))


def test_a_stretch_to_the_end_of_the_run() -> None:
    x = moving(1e-7, SD)
    x[200:] = x[200]
    assert found(x, 1e-7, SD) == list(range(201, 300))


def test_without_noise_rest_is_no_freeze_but_a_jump_is_one() -> None:
    x = moving(1e-3, 0.0)
    assert found(x, 1e-3, 0.0) == []
    x[150:180] = x[150]
    assert found(x, 1e-3, 0.0) == list(range(151, 180))


def test_a_jump_while_nothing_pushes_is_a_slip() -> None:
    x = moving(1e-3, 0.0)
    x[90:] += 0.02
    assert found(x, 1e-3, 0.0) == []
    x = moving(1e-3, 0.0)
    x[150:180] = x[150]
    assert found(x, 1e-3, 0.0, ~PUSHED) == []


def test_an_impact_is_no_jump() -> None:
    v = np.where(T > 1.0, 0.5, 0.0)
    assert found(np.round(np.cumsum(v) * 0.01 / 1e-4) * 1e-4, 1e-4, 0.0) == []
