"""Readings that fall to one value, and readings that repeat the last one."""

from __future__ import annotations

import numpy as np

from locosweep.diagnosis.data.readings.dropouts import coded, dropped, repeats

T = np.arange(600) * 0.005
NOISE = 2e-5


def sliding(seed: int = 0, step: float = 0.0) -> np.ndarray:
    x = 0.1 * np.sin(2.0 * T) + np.random.default_rng(seed).normal(0.0, NOISE, T.size)
    return np.round(x / step) * step if step else x


def test_zero_and_values_that_come_again_are_codes() -> None:
    x = np.array([1.0, 0.0, 1.0, -9.0, 1.0, -9.0, 1.0, -9.0, 1.0, 5.0])
    off = x != 1.0
    assert dropped(x, off).tolist() == (off & (x != 5.0)).tolist()
    assert dropped(x, np.zeros(10, dtype=bool)).sum() == 0


def test_a_code_is_one_also_where_it_does_not_stand_out() -> None:
    x = np.array([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.1, 0.0, 0.0, -0.1, 0.0, 0.0, 0.0, 0.0])
    off = np.zeros(15, dtype=bool)
    off[[1, 3, 5]] = True
    # Four in a row are a head that rests there.
    assert np.flatnonzero(coded(x, off)).tolist() == [1, 3, 5, 8, 9]
    assert coded(x, off & (np.arange(15) < 4)).sum() == 0


class TestRepeats:
    def found(self, *columns: np.ndarray, step: float = 0.0, most: float = 5.0) -> list[int]:
        runs = [(T, x, most) for x in columns]
        return np.flatnonzero(np.concatenate(repeats(runs, NOISE, step))).tolist()

    def test_held_readings_of_a_moving_head(self) -> None:
        x = sliding()
        bad = [30, 31, 90, 300, 420, 421, 422]
        for i in bad:
            x[i] = x[i - 1]
        assert self.found(sliding(1), x) == [i + 600 for i in bad]

    def test_a_coarse_encoder_repeats_readings(self) -> None:
        for seed in range(10):
            for step in (1e-5, 4e-5, 2e-4, 2e-3):
                assert self.found(sliding(seed, step), step=step) == []

    def test_a_head_that_rests_may_repeat_them_for_ever(self) -> None:
        assert self.found(np.zeros(600)) == []
        assert self.found(np.zeros(9)[:5]) == []

    def test_a_pause_that_forces_could_make_is_motion(self) -> None:
        v = np.where(np.arange(600) % 60 == 0, 0.0, 0.2)
        assert self.found(np.cumsum(v) * 0.005, most=500.0) == []
