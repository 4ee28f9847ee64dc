"""Lines in spectra of residuals: hum is seen, noise and a sensor's coarse steps are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl
import pytest
from scipy.stats import norm

from diagnosis_small import NOISE, ROBOT, driven, measured, problem
from locosweep.diagnosis import diagnose
from locosweep.diagnosis.select.spectral_line import _deviations, spectral_line
from locosweep.diagnosis.select.whiteness import whiteness_test

OWN = problem(measured({}))
"""Three runs of 200 samples of x, 100 a second; residuals end with three start offsets."""
SIZE = OWN.count + 3


def noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(SIZE)


def with_hum(effects: dict[str, dict[str, float]]) -> pl.DataFrame:
    """Return runs of a robot with `effects` whose readings of x hum."""
    frames = []
    for run in measured(effects, driven(seconds=8.0)):
        hum = 1.3 * NOISE * np.sin(2.0 * np.pi * 23.0 * run.t)
        columns = {"t": run.t, "drive": run.drive, "x": run.channels["x"] + hum}
        frames.append(pl.DataFrame(columns).with_columns(run=pl.lit(run.label)))
    return pl.concat(frames)


def test_white_noise_has_no_line() -> None:
    assert all(spectral_line(OWN, noise(seed)) is None for seed in range(300))


def test_a_hum_is_found_that_blocks_do_not_show() -> None:
    e = noise(1)
    e[: OWN.count] += 1.3 * np.sin(2.0 * np.pi * 0.23 * np.arange(OWN.count))
    assert not whiteness_test(OWN, e).rejected
    found = spectral_line(OWN, e)
    assert found is not None
    assert 1.0 / found.period == pytest.approx(0.23, abs=0.003)
    assert found.rms == pytest.approx(1.3 / np.sqrt(2.0), rel=0.2)
    assert found.share == pytest.approx(0.85 / 1.85, rel=0.3)
    assert "oscillates at 23 Hz" in found.told(OWN)


def test_what_is_slow_is_left_to_the_whiteness_test() -> None:
    e = noise(1)
    e[: OWN.count] += 2.0 * np.sin(2.0 * np.pi * 0.01 * np.arange(OWN.count))
    assert whiteness_test(OWN, e).rejected
    assert spectral_line(OWN, e) is None


def test_steps_of_a_reading_are_no_line() -> None:
    """A head that moves evenly past coarse marks errs by a saw tooth."""
    t = np.arange(OWN.count)
    tooth = (0.301 * t) % 1.0 - 0.5
    e = np.zeros(SIZE)
    e[: OWN.count] = np.sqrt(12.0) * tooth
    assert spectral_line(OWN, e) is not None
    coarse = {"sensor.position_noise": NOISE, "sensor.position_resolution": 1e-4}
    assert spectral_line(problem(measured({}), replace(ROBOT, other=coarse)), e) is None


@pytest.mark.parametrize("tried", [10, 100_000])
def test_deviations_are_those_of_exponential_powers(tried: int) -> None:
    """Half of all sets of white noise have a largest power beyond that of the median."""
    median = -np.log(-np.expm1(np.log(0.5) / tried))
    assert _deviations(median, tried) == pytest.approx(0.0, abs=0.2)
    power = np.log(tried) - norm.logsf(6.0)
    assert _deviations(power, tried) == pytest.approx(6.0, abs=1e-6)
    # Where the tail is no number any more, it goes on.
    near, far = (_deviations(np.log(tried) + by, tried) for by in (708.0, 709.0))
    assert 0.0 < far - near < 0.2


def test_hum_alone_is_unexplained_and_told() -> None:
    found = diagnose(with_hum({}), ROBOT)
    assert found.status == "unexplained", found
    assert any("oscillates at 23 Hz" in said for said in found.report["warnings"])
    assert found.report["verdict"]["remaining"]["shape"][0]["variable"] == "frequency"


def test_hum_beside_a_cause_is_told_and_leaves_its_name() -> None:
    found = diagnose(with_hum({"payload_mass": {"dm": 0.05}}), ROBOT)
    assert "payload_mass" in found.equivalent[0], found
    assert any("oscillates at 23 Hz" in said for said in found.report["warnings"])
