"""Windows along a run: their lengths, their order, and which of many are chosen."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis_long import PENDULUM, SLED, drives
from locosweep.diagnosis.estimate.windows import (
    TURNS,
    chosen_windows,
    growth_rates,
    spread,
    windows_along,
)
from locosweep.files.runs import Run
from locosweep.simulation.replay import nominal_of


def test_errors_grow_as_those_of_a_pendulum_above_its_pivot() -> None:
    t = np.arange(0.0, 1.0, 0.1)
    run = Run("0", t, np.zeros(t.size), {"x": np.where(t < 0.5, 0.0, np.pi)})
    rates = growth_rates(run, nominal_of(PENDULUM))
    assert not rates[:5].any()
    np.testing.assert_allclose(rates[5:], np.sqrt(1.0 / 0.05))
    assert not growth_rates(run, nominal_of(SLED)).any()


def test_counting_parts_follow_each_other_and_cover_the_run() -> None:
    run = drives(SLED, 1)[0]
    lead = 12
    found = windows_along(run, lead, 0.4, nominal_of(SLED))
    counted = [i for a, b in found for i in range(a + lead, b - lead)]
    assert counted == list(range(lead, run.t.size - lead))
    seconds = [run.t[b - lead - 1] - run.t[a + lead] for a, b in found[:-1]]
    assert max(seconds) == pytest.approx(0.4, abs=0.01)


def test_windows_are_shorter_where_errors_grow() -> None:
    run = drives(PENDULUM, 1)[0]
    above = Run("0", run.t, run.drive, {"x": np.full(run.t.size, np.pi)})
    a, b = windows_along(above, 12, 4.0, nominal_of(PENDULUM))[0]
    grown = (run.t[b - 12] - run.t[a]) * np.sqrt(1.0 / 0.05)
    assert grown == pytest.approx(0.5 * TURNS, rel=0.2)


def test_every_run_gives_windows_and_few_of_them_rest() -> None:
    t = np.arange(0.0, 10.0, 0.01)
    moves = np.where(t < 5.0, 0.0, np.sin(t - 5.0))
    runs = [Run(str(k), t, np.where(t < 5.0, 0.0, 1.0 + k), {"x": moves}) for k in range(2)]
    every = {r: [(r, a, a + 50) for a in range(0, 1000, 50)] for r in range(2)}
    found = chosen_windows(runs, every, 800, 1e-4)
    assert found == sorted(found)
    assert [sum(r == k for r, _, _ in found) for k in range(2)] == [8, 8]
    assert sum(b <= 500 for _, _, b in found) == 2


def test_numbers_are_spread_evenly() -> None:
    assert spread(3, 5) == [0, 1, 2]
    assert spread(10, 2) == [2, 7]
    assert spread(10, 0) == []


def test_each_of_many_runs_shows_motion_and_one_window_in_eight_rests() -> None:
    t = np.arange(0.0, 12.0, 0.01)
    moves = np.where(t < 2.0, 0.0, np.sin(t - 2.0))
    runs = [Run(str(k), t, np.where(t < 2.0, 0.0, 1.0), {"x": moves}) for k in range(16)]
    every = {r: [(r, a, a + 100) for a in range(0, 1200, 100)] for r in range(16)}
    found = chosen_windows(runs, every, 1600, 1e-4)
    assert len(found) == 16
    assert sum(b <= 200 for _, _, b in found) == 2
