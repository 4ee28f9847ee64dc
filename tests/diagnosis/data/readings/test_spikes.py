"""Spikes among neighbours, and motions that are none."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.data.readings.spikes import spikes

NOISE, MOST = 2e-5, 8.0
T = np.arange(400) * 0.01


def motion(seed: int = 0) -> np.ndarray:
    """Rest, a push, a stop at once, and the way back, within an acceleration of 8."""
    v = np.clip(np.minimum(4.0 * (T - 0.5), 0.4), 0.0, None) * (T < 2.0)
    v -= np.clip(np.minimum(6.0 * (T - 2.5), 0.5), 0.0, None) * (T < 3.5)
    x = np.cumsum(v) * 0.01
    return x + np.random.default_rng(seed).normal(0.0, NOISE, T.size)


def found(x: np.ndarray) -> list[int]:
    return np.flatnonzero(spikes(T, x, NOISE, MOST)).tolist()


def test_motion_has_none() -> None:
    for seed in range(20):
        assert found(motion(seed)) == []


@pytest.mark.parametrize("size", [1e-3, -1e-3])
def test_small_ones_stand_alone(size: float) -> None:
    x = motion()
    bad = [20, 50, 130, 333]
    x[bad] += size
    assert found(x) == bad


@pytest.mark.parametrize("size", [-1e-2, 3.0, 1e186])
def test_single_ones_are_found_wherever_they_are(size: float) -> None:
    x = motion()
    bad = [20, 50, 52, 130, 200, 201, 333]
    x[bad] += size
    assert found(x) == bad


def test_the_first_and_the_last_reading() -> None:
    x = motion()
    x[[0, 399]] += 0.05
    assert found(x) == [0, 399]
    # A step like others of the run may be motion.
    x = motion()
    x[[0, 399]] += 0.005
    assert found(x) == []


def test_a_few_in_a_row() -> None:
    x = motion()
    x[100:104] += 0.01
    assert found(x) == [100, 101, 102, 103]
    x = motion()
    x[100:130] += 0.01
    assert found(x) == []


def test_a_jump_that_stays_is_none() -> None:
    x = motion()
    x[150:] += 0.01
    assert found(x) == []


def test_an_impact_is_none() -> None:
    # The head is hit and brakes at the largest acceleration: it does not come back.
    v = np.where(T > 1.0, np.maximum(0.5 - MOST * (T - 1.0), 0.0), 0.0)
    assert found(np.cumsum(v) * 0.01) == []


def test_noise_that_is_larger_hides_them() -> None:
    x = motion()
    x[120] += 1e-3
    assert spikes(T, x, 1e-3, MOST).sum() == 0


def test_times_need_not_be_even() -> None:
    rng = np.random.default_rng(3)
    t = np.sort(rng.uniform(0.0, 4.0, 400))
    t = t[np.diff(t, prepend=-1.0) > 1e-4]
    x = 0.1 * np.sin(t) + rng.normal(0.0, NOISE, t.size)
    assert spikes(t, x, NOISE, MOST).sum() == 0
    x[77] += 0.005
    assert np.flatnonzero(spikes(t, x, NOISE, MOST)).tolist() == [77]


def test_few_readings_are_left_as_they_are() -> None:
    assert spikes(T[:6], np.array([0.0, 0.0, 9.0, 0.0, 0.0, 0.0]), NOISE, MOST).sum() == 0
