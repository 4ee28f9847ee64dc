"""Rows that miss: where they are put in, which drive they get, and within which bounds."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.data.missing_rows import with_missing_rows
from locosweep.files.runs import Run

STEP = 0.005
T = STEP * np.arange(1000)
RNG = np.random.default_rng(2)
SINE = np.round(2.0 * np.sin(2.0 * np.pi * 1.3 * T), 3)
STEPS = np.where(np.floor(T / 0.4) % 2 == 0, 1.0, -1.0)


def left_out(drive: np.ndarray, gone: list[int]) -> Run:
    """A run without some of its rows."""
    kept = np.delete(np.arange(T.size), gone)
    return Run("0", T[kept], drive[kept], {"x": T[kept] ** 2, "v": T[kept]}, 1.5)


def test_a_whole_run_stays() -> None:
    whole = left_out(SINE, [])
    assert with_missing_rows(whole) == (whole, [])


def test_rows_are_put_in_without_readings() -> None:
    found, gaps = with_missing_rows(left_out(SINE, [10, 11, 500]))
    assert found.t == pytest.approx(T)
    assert found.slope_deg == 1.5
    for values in found.channels.values():
        assert np.flatnonzero(np.isnan(values)).tolist() == [10, 11, 500]
    assert [(round(a / STEP), round(b / STEP), n) for a, b, n in gaps] == [
        (9, 12, 2),
        (499, 501, 1),
    ]


def test_a_smooth_drive_goes_on_through_a_gap() -> None:
    gone = sorted(RNG.choice(np.arange(5, 995), 60, False).tolist())
    found, _ = with_missing_rows(left_out(SINE, gone))
    assert found.drive_deviation is not None
    error = (found.drive - SINE)[gone]
    # The commands are rounded to 1 mN, which a parabola through them makes larger.
    assert np.abs(error).max() < 0.05
    assert np.sqrt(np.mean(error**2)) < 2.0 * np.sqrt(np.mean(found.drive_deviation[gone] ** 2))
    assert found.drive_deviation[gone].max() < 0.05


def test_a_step_within_a_gap_is_known_within_its_height() -> None:
    edge = int(np.flatnonzero(np.diff(STEPS))[2]) + 1
    found, _ = with_missing_rows(left_out(STEPS, [edge, edge + 200]))
    assert found.drive_deviation is not None
    # Either level: half the height is both the middle and the deviation.
    assert found.drive[edge] == pytest.approx(0.0, abs=1e-12)
    assert found.drive_deviation[edge] == pytest.approx(1.0, rel=0.05)


def test_a_level_that_both_sides_hold_is_known() -> None:
    edge = int(np.flatnonzero(np.diff(STEPS))[2]) + 1
    for row in (edge - 2, edge - 1 - 20, edge + 1, edge + 20):
        found, _ = with_missing_rows(left_out(STEPS, [row]))
        assert found.drive_deviation is not None
        assert found.drive[row] == STEPS[row]
        assert found.drive_deviation[row] == 0.0


def test_a_drive_that_changes_every_row_is_unknown_in_a_gap() -> None:
    noise = RNG.normal(0.0, 1.0, T.size)
    gone = sorted(RNG.choice(np.arange(5, 995), 40, False).tolist())
    found, _ = with_missing_rows(left_out(noise, gone))
    assert found.drive_deviation is not None
    deviates = (found.drive - noise)[gone] / found.drive_deviation[gone]
    assert 0.5 < np.sqrt(np.mean(deviates**2)) < 1.5


def test_pulses_shorter_than_a_gap_make_a_level_less_known() -> None:
    pulses = np.zeros(T.size)
    pulses[20::40] = 1.0
    found, _ = with_missing_rows(left_out(pulses, [500]))
    assert found.drive_deviation is not None
    assert 0.05 < found.drive_deviation[500] < 0.3


def test_a_run_of_which_more_than_half_misses_stays() -> None:
    gone = [k for k in range(1, 999) if k % 3]
    # Two in three rows at random places: steps are of all lengths.
    gone = sorted(RNG.choice(gone + list(range(3, 999, 3)), 660, False).tolist())
    part = left_out(SINE, gone)
    assert with_missing_rows(part) == (part, [])
