"""White noise in all readings, and motion that is none."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.data.white_noise import noise_beyond, scaled_differences, white_level
from locosweep.files.runs import Run

T = np.arange(800) * 0.005
DRIVE = np.where(T > 0.4, 1.0, 0.0)


def runs(x: np.ndarray, sd: float, drive: np.ndarray = DRIVE, count: int = 4) -> list[Run]:
    rng = np.random.default_rng(2)
    return [Run(str(k), T, drive, {"x": x + rng.normal(0.0, sd, T.size)}) for k in range(count)]


SLIDE = np.where(T > 0.4, 0.2 * (T - 0.4) ** 2, 0.0)


@pytest.mark.parametrize("sd", [1e-5, 1e-3])
def test_noise_shows_under_the_motion(sd: float) -> None:
    assert white_level("x", runs(SLIDE, sd)) == pytest.approx(sd, rel=0.1)


def test_fast_motion_is_none() -> None:
    ringing = np.where(T > 0.4, 1e-3 * np.sin(2.0 * np.pi * 31.0 * T), 0.0)
    assert white_level("x", runs(ringing, 1e-6)) < 2e-6
    always = 1e-2 * np.sin(2.0 * np.pi * 20.0 * T)
    assert white_level("x", runs(always, 1e-6, drive=np.cos(T))) < 3e-5


def test_rest_that_is_quieter_says_that_it_is_motion() -> None:
    rough = np.where(T > 0.4, np.random.default_rng(5).normal(0.0, 1e-3, T.size), 0.0)
    assert white_level("x", runs(rough, 1e-5)) == 0.0
    # Without rest nobody can say so.
    assert white_level("x", runs(rough, 1e-5, drive=np.cos(T))) == pytest.approx(1e-3, rel=0.2)


def test_early_and_late_samples_are_no_noise() -> None:
    rng = np.random.default_rng(7)
    t = T + rng.uniform(-0.3, 0.3, T.size) * 0.005
    swinging = [
        Run(str(k), t, np.cos(t), {"x": 0.3 * np.sin(4.0 * t + k) + rng.normal(0.0, 1e-5, t.size)})
        for k in range(4)
    ]
    assert white_level("x", swinging) == pytest.approx(1e-5, rel=0.15)


@pytest.mark.parametrize("order", [3, 7])
def test_differences_keep_the_deviation_of_noise(order: int) -> None:
    rng = np.random.default_rng(8)
    noise = rng.normal(0.0, 1.0, 20000)
    even = np.arange(20000.0)
    for t in (even, even + rng.uniform(-0.3, 0.3, even.size)):
        assert scaled_differences(t, noise, order).std() == pytest.approx(1.0, rel=0.05)
    assert scaled_differences(even[:order], noise[:order], order).size == 0


def test_a_reading_that_never_changes_has_none() -> None:
    assert white_level("x", runs(np.zeros(800), 0.0)) == 0.0
    assert white_level("x", []) == 0.0


def test_noise_counts_from_twice_the_stated_one() -> None:
    noisy = runs(SLIDE, 1e-4)
    assert noise_beyond(6e-5, "x", noisy) == 0.0
    assert noise_beyond(4e-5, "x", noisy) == pytest.approx(1e-4, rel=0.1)
