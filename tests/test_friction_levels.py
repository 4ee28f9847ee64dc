"""Levels of the load: those that are there, whatever their distances."""

import numpy as np
import pytest

from locosweep.friction_fit.levels import load_levels

RANDOM = np.random.default_rng(0)


def strokes(level, count=400):
    """Loads to and fro under one weight: guides carry 3 % more on the way back."""
    way = np.where(np.arange(count) % 2, 1.03, 1.0)
    return level * way * (1.0 + 0.002 * RANDOM.standard_normal(count))


@pytest.mark.parametrize(
    "levels", [(20,), (20, 60), (10, 20, 100), (5, 20, 60, 140), (10, 14, 100)]
)
def test_strokes_to_and_fro_are_one_level(levels):
    found = load_levels(np.concatenate([strokes(level) for level in levels]), 4)
    assert len(found) == len(levels)
    for (low, high), level in zip(found, levels, strict=True):
        assert 0.98 * level < low <= level
        assert 1.03 * level <= high < 1.05 * level


def test_a_load_on_its_way_is_no_level():
    ramp = np.linspace(20.0, 60.0, 8)
    found = load_levels(np.concatenate([strokes(20, 5000), ramp[1:-1], strokes(60, 5000)]), 4)
    assert [round(high) for _, high in found] == [21, 62]


def test_of_many_levels_some_are_drawn_from_end_to_end():
    found = load_levels(
        np.concatenate([strokes(level) for level in (10, 15, 20, 30, 40, 60, 90)]), 4
    )
    assert [round(high) for _, high in found] == [10, 21, 42, 93]


def test_a_load_without_levels_is_cut_into_as_many_samples():
    load = np.linspace(10.0, 90.0, 400) ** 1.2
    found = load_levels(load, 4)
    counts = [np.sum((load >= low) & (load <= high)) for low, high in found]
    assert counts == pytest.approx([100] * 4, abs=1)


def test_one_load_is_one_level():
    assert load_levels(np.full(30, 4.0), 4) == [(4.0, 4.0)]
    assert load_levels(np.array([0.0, 0.0]), 4) == [(0.0, 0.0)]
