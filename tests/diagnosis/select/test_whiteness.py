"""The residual whiteness test on white noise, on what is not, and on stray readings."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2, norm

from diagnosis_small import driven, measured, problem
from locosweep.diagnosis.select.whiteness import (
    noise_level,
    residuals_by_run,
    stray_readings,
    white_variance,
    whiteness_test,
)

OWN = problem(measured({}))
"""Three runs of 200 samples of x; residuals end with three start offsets."""
SIZE = OWN.count + 3


def noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(SIZE)


def test_white_noise_is_not_rejected() -> None:
    found = [whiteness_test(OWN, noise(seed)) for seed in range(200)]
    assert not any(one.rejected for one in found)
    # The largest of three scales' normal deviates.
    assert 0.3 < np.mean([one.deviations for one in found]) < 1.5


def test_an_offset_is_found_in_long_blocks() -> None:
    found = whiteness_test(OWN, noise(1) + 0.6)
    assert found.rejected
    assert (found.channel, found.block) == ("x", 64)
    assert found.excess == pytest.approx(0.6, abs=0.15)


def test_deviations_are_those_of_chi2() -> None:
    e = noise(2)
    e[: OWN.count] += 0.15
    found = whiteness_test(OWN, e)
    parts = [v for _, _, v in residuals_by_run(OWN, e)]
    sums = np.concatenate(
        [v[: v.size // found.block * found.block].reshape(-1, found.block).sum(axis=1)
         for v in parts]
    ) / np.sqrt(found.block)  # fmt: skip
    base = white_variance(np.concatenate(parts))
    exact = norm.isf(chi2.sf(sums @ sums / base, sums.size))
    assert found.deviations == pytest.approx(exact, abs=0.05)


def test_the_level_of_noise_ignores_what_is_slow() -> None:
    t = np.arange(SIZE) / 30.0
    assert noise_level(OWN, 2.0 * noise(3) + 5.0 * np.sin(t)) == pytest.approx(4.0, rel=0.2)
    # What is stated may be too large; it is not trusted to be far too large.
    assert noise_level(OWN, 0.1 * noise(3)) == 0.5
    assert white_variance(np.zeros(10)) == 1.0


def test_samples_without_weight_do_not_count() -> None:
    runs = measured({})
    runs[1].channels["x"][50:100] = np.nan
    own = problem(runs, held=(2,))
    sizes = [v.size for _, _, v in residuals_by_run(own, noise(4))]
    assert sizes == [200, 150]


def test_single_readings_far_off_are_told() -> None:
    own = problem(measured({}, driven(1)))
    e = np.random.default_rng(5).standard_normal(own.count + 1)
    assert stray_readings(own, e) == []
    e[100] = 30.0
    (said,) = stray_readings(own, e)
    assert said.startswith("run 0: a reading of x at 1 s lies more than 8 deviations")
    e[100:104] = 30.0
    assert "4 readings of x between 1 and 1.03 s lie" in stray_readings(own, e)[0]
    # Many of them are no single ones: the whiteness test finds them.
    e[100:140] = 30.0
    assert stray_readings(own, e) == []
