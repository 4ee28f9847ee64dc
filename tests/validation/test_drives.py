"""Drawn drive commands and sample times."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.validation.drives import KINDS, draw_shape, sample_times

T = np.arange(0.0, 4.0, 0.01)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("one_way", [True, False])
def test_shapes_stay_within_their_amplitude(kind: str, one_way: bool) -> None:
    for seed in range(20):
        shape = draw_shape(np.random.default_rng(seed), kind, T, one_way=one_way)
        assert shape.shape == T.shape
        assert shape.max() <= 1.0 + 1e-12
        assert shape.min() >= (0.0 if one_way else -1.0) - 1e-12
        assert np.ptp(shape) > 0.3


@pytest.mark.parametrize("kind", KINDS)
def test_shapes_depend_on_the_generator_alone(kind: str) -> None:
    one, again, other = (
        draw_shape(np.random.default_rng(seed), kind, T, one_way=False) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, again)
    assert not np.array_equal(one, other)


def test_most_rigs_start_at_rest() -> None:
    quiet = [
        not draw_shape(np.random.default_rng(seed), "sine", T, one_way=True)[:5].any()
        for seed in range(200)
    ]
    assert 0.65 < np.mean(quiet) < 0.85


def test_jitter_moves_samples_but_neither_end() -> None:
    even = sample_times(np.random.default_rng(0), 100.0, 2.0, jitter=False)
    shaken = sample_times(np.random.default_rng(0), 100.0, 2.0, jitter=True)
    np.testing.assert_array_equal(even, np.arange(201) / 100.0)
    assert (shaken[0], shaken[-1]) == (0.0, 2.0)
    assert (np.diff(shaken) > 0.0).all()
    assert 0.0 < np.abs(shaken - even).max() <= 0.003
    np.testing.assert_array_equal(shaken, np.round(shaken, 6))
