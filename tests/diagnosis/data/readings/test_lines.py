"""Readings off lines through their neighbours."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.data.readings.lines import off_line

T = np.array([0.0, 0.1, 0.25, 0.3, 0.5])


def at(*where: int) -> list[np.ndarray]:
    return [np.array([i]) for i in where]


def test_a_straight_line_leaves_nothing() -> None:
    found = off_line(T, 2.0 - 3.0 * T, *at(2, 0, 4))
    assert found.size[0] == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("where", [(2, 1, 3), (4, 2, 3), (0, 1, 2)])
def test_an_acceleration_bends_it_by_its_share(where: tuple[int, int, int]) -> None:
    found = off_line(T, 0.5 * 4.0 * T**2, *at(*where))
    assert abs(found.size[0]) == pytest.approx(4.0 * found.bend[0])


def test_gain_is_the_deviation_that_noise_makes() -> None:
    even = np.arange(3.0)
    assert off_line(even, even, *at(1, 0, 2)).gain[0] == pytest.approx(np.sqrt(1.5))
    assert off_line(even, even, *at(2, 0, 1)).gain[0] == pytest.approx(np.sqrt(6.0))
