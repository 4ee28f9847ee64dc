"""Kinds of motion on a motion whose kinds are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import savgol_filter

from diagnosis_small import NOISE, problem
from locosweep.diagnosis.data.regimes import (
    REGIMES,
    MeasuredMotion,
    _local_parabolas,
    measured_motion,
    regimes_of,
)
from locosweep.files.runs import Run

RATE = 100.0
REST, FORWARD, BACK = 100, 200, 150
"""Samples of a head that rests, slides forward at 50 mm/s, turns, slides back at 40, rests."""


def known(noise: float = 0.0) -> Run:
    speed = np.repeat([0.0, 0.05, -0.04, 0.0], [REST, FORWARD, BACK, REST])
    x = np.concatenate([[0.0], np.cumsum(speed[:-1]) / RATE])
    x += noise * np.random.default_rng(2).standard_normal(x.size)
    return Run("0", np.arange(x.size) / RATE, np.zeros(x.size), {"x": x})


def kinds(run: Run) -> list[str]:
    return [REGIMES[k] for k in regimes_of(motion(run))]


def motion(run: Run) -> MeasuredMotion:
    return measured_motion(run, problem([run]).noise["x"])


@pytest.mark.parametrize("noise", [0.0, NOISE])
def test_every_phase_has_its_kind(noise: float) -> None:
    found = kinds(known(noise))
    middle = {REST // 2: "at_rest", REST + FORWARD // 2: "sliding_forward",
              REST + FORWARD + BACK // 2: "sliding_backward", -REST // 2: "at_rest"}  # fmt: skip
    assert {k: found[k] for k in middle} == middle
    # A break-away lies where sliding begins, a reversal where the speed changes its sign;
    # smoothing may move both by its half width.
    (broken,) = _starts(found, "breakaway")
    (turned,) = _starts(found, "reversal")
    assert abs(broken - REST) < 12
    assert abs(turned - (REST + FORWARD)) < 12


def _starts(found: list[str], kind: str) -> list[int]:
    return [k for k, name in enumerate(found) if name == kind and found[k - 1] != kind]


def test_distance_counts_from_the_last_rest_or_turn() -> None:
    """It grows forward only; a head that moves when the readings begin brings its own along."""
    run = known()
    distance = motion(run).sliding_distance()
    since = run.channels["x"] - run.channels["x"][0]
    forward = slice(REST + 12, REST + FORWARD - 12)
    assert np.abs(distance[forward] - since[forward]).max() < 0.002
    assert not distance[: REST - 12].any()
    assert not distance[REST + FORWARD + 12 :].any()
    late = Run("1", run.t[150:], run.drive[150:], {"x": run.channels["x"][150:]})
    brought = motion(late).sliding_distance(before=0.5)
    assert brought[20] == pytest.approx(0.5 + 20 * 0.05 / RATE)
    assert not brought[FORWARD - 50 + 12 :].any()


def test_a_head_at_rest_is_at_rest_whatever_the_noise() -> None:
    x = NOISE * np.random.default_rng(1).standard_normal(400)
    run = Run("0", np.arange(400) / RATE, np.zeros(400), {"x": x})
    # The limit of three deviations: a few in a thousand may lie beyond it.
    assert np.mean([k == "at_rest" for k in kinds(run)]) > 0.95


def test_the_motion_is_smoothed_to_its_speed() -> None:
    found = motion(known(NOISE))
    true = known().channels["x"]
    inside = slice(REST + 30, REST + FORWARD - 30)
    assert np.sqrt(np.mean((found.x - true)[inside] ** 2)) < NOISE
    assert np.abs(found.v[inside] - 0.05).max() < 5.0 * found.deviation
    # Smoothing is as wide as brings the speed to a few hundredths.
    assert 0.0 < found.deviation < 0.05 * 0.05


def test_missing_readings_are_bridged() -> None:
    run = known(NOISE)
    run.channels["x"][REST + 50 : REST + 60] = np.nan
    assert "sliding_forward" in kinds(run)
    assert np.isfinite(motion(run).v).all()


def test_nothing_measured_is_at_rest() -> None:
    run = Run("0", np.arange(50) / RATE, np.zeros(50), {"x": np.full(50, np.nan)})
    assert set(kinds(run)) == {"at_rest"}


@pytest.mark.parametrize(("count", "width"), [(5, 5), (9, 5), (301, 37), (2000, 251)])
def test_local_parabolas_are_the_filter_of_savitzky_and_golay(count, width):
    x = np.cumsum(np.random.default_rng(3).normal(size=count))
    value, slope = _local_parabolas(x, width)
    assert value == pytest.approx(savgol_filter(x, width, 2), abs=1e-9)
    assert slope == pytest.approx(savgol_filter(x, width, 2, deriv=1), abs=1e-9)


def test_local_parabolas_follow_a_parabola_to_its_ends():
    t = np.arange(40.0)
    value, slope = _local_parabolas(2.0 - 3.0 * t + 0.5 * t**2, 11)
    assert value == pytest.approx(2.0 - 3.0 * t + 0.5 * t**2)
    assert slope == pytest.approx(t - 3.0, abs=1e-9)
