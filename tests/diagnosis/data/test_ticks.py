"""Ticks of a log's clock: which rows miss, packets with one stamp, and stamps that jump."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.data.ticks import evidence, spread_packets, tick_numbers, times_of_ticks

RNG = np.random.default_rng(11)
COUNT, STEP = 600, 0.004
EVEN = 3.0 + STEP * np.arange(COUNT)
KEPT = np.sort(np.concatenate([[0, COUNT - 1], RNG.choice(np.arange(1, COUNT - 1), 540, False)]))


class TestTickNumbers:
    @pytest.mark.parametrize("jitter", [0.0, 0.1, 0.3])
    def test_rows_that_miss_leave_out_ticks(self, jitter: float) -> None:
        stamps = EVEN + jitter * STEP * RNG.uniform(-1.0, 1.0, COUNT)
        found = tick_numbers(stamps[KEPT])
        assert found is not None
        assert np.array_equal(found[0], KEPT)
        assert found[1] == pytest.approx(STEP, rel=1e-3)

    def test_a_clock_that_runs_fast_at_times_still_ticks(self) -> None:
        wandering = EVEN + 0.02 * np.sin(2.0 * np.pi * (EVEN - 3.0) / 2.4)
        found = tick_numbers(wandering[KEPT])
        assert found is not None
        assert np.array_equal(found[0], KEPT)

    def test_rows_written_when_something_happens_have_no_ticks(self) -> None:
        assert tick_numbers(np.cumsum(RNG.exponential(STEP, COUNT))) is None
        assert tick_numbers(np.array([0.0, 1.0])) is None

    def test_a_step_that_doubles_half_way_is_no_row_left_out(self) -> None:
        two = np.concatenate([STEP * np.arange(300), STEP * (300 + 2.5 * np.arange(300))])
        assert tick_numbers(two) is None


class TestPackets:
    @pytest.mark.parametrize("rows", [2, 3, 7])
    @pytest.mark.parametrize("late", [0.0, 0.4])
    def test_rows_of_a_packet_are_spread(self, rows: int, late: float) -> None:
        stamps = EVEN[rows - 1 :: rows]
        stamps = stamps + late * STEP * rows * RNG.random(stamps.size)
        found = spread_packets(np.repeat(stamps, rows))
        assert found is not None
        assert np.diff(found) == pytest.approx(STEP, rel=0.03)

    def test_a_packet_that_was_lost_leaves_a_gap(self) -> None:
        stamps = np.repeat(EVEN[::5], 5)
        found = spread_packets(np.delete(stamps, np.arange(200, 210)))
        assert found is not None
        steps = np.diff(found) / STEP
        assert np.sort(steps)[[0, -2]] == pytest.approx(1.0, abs=0.02)
        assert steps[199] == pytest.approx(11.0, abs=0.1)

    def test_stamps_rounded_to_more_than_a_step_are_packets_too(self) -> None:
        found = spread_packets(np.floor(EVEN / 0.01) * 0.01)
        assert found is not None
        assert np.diff(found) == pytest.approx(STEP, rel=0.01)

    def test_a_stamp_that_repeats_once_is_no_packet(self) -> None:
        once = EVEN.copy()
        once[50] = once[49]
        assert spread_packets(once) is None
        assert spread_packets(EVEN) is None

    def test_packets_without_a_clock_are_refused(self) -> None:
        wild = np.repeat(np.cumsum(RNG.exponential(1.0, 40)), RNG.integers(2, 40, 40))
        assert spread_packets(wild) is None
        assert spread_packets(np.repeat([0.0, 1.0, 0.5], 20)) is None


class TestJitter:
    STAMPS = EVEN + 0.2 * STEP * RNG.uniform(-1.0, 1.0, COUNT)
    NOISE = RNG.normal(0.0, 1e-5, COUNT)

    @staticmethod
    def place(t: np.ndarray) -> np.ndarray:
        return np.asarray(0.1 * np.sin(4.0 * t))

    def test_ticks_are_the_line_through_the_stamps(self) -> None:
        even = times_of_ticks(self.STAMPS)
        assert even is not None
        assert even == pytest.approx(EVEN, abs=0.02 * STEP)
        assert times_of_ticks(EVEN) is None
        assert times_of_ticks(EVEN[KEPT]) is None

    def test_x_tells_whether_it_was_read_at_the_ticks_or_beside_them(self) -> None:
        even = times_of_ticks(self.STAMPS)
        assert even is not None
        assert evidence(self.place(EVEN) + self.NOISE, even, self.STAMPS) > 100.0
        assert evidence(self.place(self.STAMPS) + self.NOISE, even, self.STAMPS) < -100.0

    def test_what_rests_does_not_tell(self) -> None:
        even = times_of_ticks(self.STAMPS)
        assert even is not None
        assert abs(evidence(self.NOISE, even, self.STAMPS)) < 3.0
        assert evidence(np.full(COUNT, np.nan), even, self.STAMPS) == 0.0
