"""Jumps that stay."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.data.readings.slips import slips

NOISE, MOST = 2e-5, 8.0
T = np.arange(400) * 0.01


def motion() -> np.ndarray:
    v = 0.4 * np.sin(3.0 * T) * (T > 0.5)
    return np.cumsum(v) * 0.01 + np.random.default_rng(0).normal(0.0, NOISE, T.size)


def test_motion_has_none() -> None:
    assert slips(T, motion(), NOISE, MOST) == []


@pytest.mark.parametrize("at", [2, 30, 200, 397])
@pytest.mark.parametrize("size", [0.01, -0.02])
def test_a_slip_is_found_with_its_size(at: int, size: float) -> None:
    x = motion()
    x[at:] += size
    ((before, jump),) = slips(T, x, NOISE, MOST)
    assert before == at - 1
    assert jump == pytest.approx(size, abs=1e-3)


def test_what_comes_back_is_none() -> None:
    x = motion()
    x[200] += 0.02
    assert slips(T, x, NOISE, MOST) == []


def test_an_impact_is_none() -> None:
    v = np.where(T > 1.003, 0.5, 0.0)
    assert slips(T, np.cumsum(v) * 0.01, NOISE, MOST) == []


def test_over_a_gap_in_the_data_the_head_may_go_far() -> None:
    x = motion()
    kept = (T < 1.0) | (T > 1.5)
    x[T > 1.5] += 0.3
    assert slips(T[kept], x[kept], NOISE, MOST) == []
