"""Lines in spectra of residuals: hum is seen, noise and a sensor's coarse steps are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl
import pytest
from scipy.stats import chi2, norm

from diagnosis_small import NOISE, ROBOT, driven, measured, problem
from locosweep.diagnosis import diagnose
from locosweep.diagnosis.select.spectral_line import (
    _log_of_least,
    _log_of_product,
    _log_tails,
    _powers,
    spectral_line,
)
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


def test_noise_has_no_line() -> None:
    assert all(spectral_line(OWN, noise(seed)) is None for seed in range(300))


def test_noise_that_is_not_white_has_no_line() -> None:
    """Speed by differences of positions, noise that was stated too large, and none at all."""
    long = problem(measured({}, driven(seconds=40.0)))
    for seed in range(10):
        e = np.random.default_rng(seed).standard_normal(long.count + 4)
        assert spectral_line(long, np.diff(e)) is None
        assert spectral_line(long, 0.1 * e[1:]) is None
    small = noise(1)
    small[: OWN.count] = 0.1 * np.sin(2.0 * np.pi * 0.23 * np.arange(OWN.count))
    assert spectral_line(OWN, small) is None
    assert spectral_line(OWN, np.zeros(SIZE)) is None


@pytest.mark.parametrize("count", [40, 200, 20_000])
def test_tails_are_those_of_noise_however_few_powers_there_are(count: int) -> None:
    """Of 1e4 powers of noise, one is beyond a tail of 1e-4."""
    random = np.random.default_rng(count)
    tails = [_log_tails(_powers(random.standard_normal(2 * count)), 0.0)
             for _ in range(200_000 // count)]  # fmt: skip
    tails = np.concatenate(tails)
    for tail in (0.1, 1e-2, 1e-3):
        expected = tail * tails.size
        assert np.sum(tails < np.log(tail)) == pytest.approx(expected, abs=5.0 * expected**0.5)


def test_powers_are_those_of_white_noise_up_to_one_in_two_values() -> None:
    for count in (199, 200):
        random = np.random.default_rng(count)
        found = np.mean([_powers(random.standard_normal(count)) for _ in range(4000)], axis=0)
        assert found.size == count // 2
        np.testing.assert_allclose(found[:-1], count, rtol=0.1)
        assert found[-1] == pytest.approx(count * (1.0 if count % 2 else 0.5), rel=0.1)


def test_an_oscillation_of_every_other_reading_is_seen() -> None:
    e = noise(1)
    e[: OWN.count] += 1.5 * (-1.0) ** np.arange(OWN.count)
    found = spectral_line(OWN, e)
    assert found is not None
    assert found.period == 2.0


def test_the_frequency_is_that_of_the_readings() -> None:
    """A sensor that is read in every second row."""
    runs = [
        replace(run, channels={"x": np.where(np.arange(run.t.size) % 2, np.nan, run.channels["x"])})
        for run in measured({}, driven(seconds=8.0))
    ]
    own = problem(runs)
    t = np.concatenate([run.t for run in runs])
    e = np.random.default_rng(1).standard_normal(own.count + 3)
    e[: own.count] = e[: own.count] + 1.2 * np.sin(2.0 * np.pi * 11.0 * t)
    e[: own.count][np.isnan(np.concatenate([run.channels["x"] for run in runs]))] = 0.0
    found = spectral_line(own, e)
    assert found is not None
    assert "oscillates at 11 Hz" in found.told(own)
    assert "50 readings a second" in found.told(own)


def test_a_hum_is_found_that_blocks_do_not_show() -> None:
    e = noise(1)
    e[: OWN.count] += 1.3 * np.sin(2.0 * np.pi * 0.23 * np.arange(OWN.count))
    assert not whiteness_test(OWN, e).rejected
    found = spectral_line(OWN, e)
    assert found is not None
    assert 1.0 / found.period == pytest.approx(0.23, abs=0.003)
    assert found.share == pytest.approx(0.85 / 1.85, rel=0.3)
    assert "oscillates at 23 Hz" in found.told(OWN)


def test_what_is_slow_is_no_line() -> None:
    """A trend, weak or strong, that comes once in each run."""
    for size, rejected in ((0.3, False), (2.0, True)):
        e = noise(1)
        e[: OWN.count] += size * np.sin(2.0 * np.pi * 0.005 * np.arange(OWN.count))
        assert whiteness_test(OWN, e).rejected is rejected
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


def test_deviations_are_those_of_a_tail_also_where_it_is_no_number() -> None:
    """A line alone in long runs: its tail is that of the normal deviate, to first order."""
    e = noise(1)
    e[: OWN.count] += 3.0 * np.sin(2.0 * np.pi * 0.23 * np.arange(OWN.count))
    found = spectral_line(OWN, e)
    assert found is not None
    tails = []
    for run in range(3):
        least = float(_log_tails(_powers(e[200 * run : 200 * run + 200]), 0.0).min())
        tails.append(_log_of_least(least, 93))
    product = _log_of_product(tails)
    assert norm.logsf(found.deviations) == pytest.approx(product, rel=1e-6)


def test_runs_of_a_channel_count_together() -> None:
    """Fisher's product of tails has the distribution of chi2."""
    tails = [-3.0, -0.5, -7.0]
    assert _log_of_product(tails) == pytest.approx(chi2.logsf(21.0, 6), rel=1e-9)
    assert _log_of_product([-2.0]) == pytest.approx(-2.0)
    assert _log_of_least(np.log(0.01), 3) == pytest.approx(np.log(1.0 - 0.99**3))
    assert _log_of_least(-1000.0, 10) == pytest.approx(-1000.0 + np.log(10.0))
    assert _log_of_least(0.0, 5) == 0.0
    # A hum too weak in any run, in all of them.
    together = [noise(seed) for seed in (1, 2)]
    t = np.arange(OWN.count)
    one, every = together
    one[:200] += 0.5 * np.sin(2.0 * np.pi * 0.23 * t[:200])
    every[: OWN.count] += 0.5 * np.sin(2.0 * np.pi * 0.23 * t)
    assert spectral_line(OWN, one) is None
    assert spectral_line(OWN, every) is not None


def test_hum_alone_is_unexplained_and_told() -> None:
    found = diagnose(with_hum({}), ROBOT)
    assert found.status == "unexplained", found
    assert any("oscillates at 23 Hz" in said for said in found.report["warnings"])
    assert found.report["verdict"]["remaining"]["shape"][0]["variable"] == "frequency"


def test_hum_beside_a_cause_leaves_its_name_and_is_what_remains() -> None:
    found = diagnose(with_hum({"payload_mass": {"dm": 0.05}}), ROBOT)
    assert found.status == "partial", found
    assert "payload_mass" in found.equivalent[0], found
    assert any("oscillates at 23 Hz" in said for said in found.report["warnings"])
    assert found.report["verdict"]["remaining"]["shape"][0]["variable"] == "frequency"
