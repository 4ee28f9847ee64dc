"""Noise of a channel, as stated or as the readings show it."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.data.noise import Noise, noise_of, noise_warnings, stretches, weights_of
from locosweep.files.runs import Run

T = np.linspace(0.0, 2.0, 4001)


def run(values: np.ndarray, channel: str = "x") -> Run:
    return Run("0", T[: values.size], np.zeros(values.size), {channel: values})


def noisy(sd: float, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, sd, T.size) + 0.1 * np.sin(T)


class TestNoiseOf:
    def test_readings_show_their_noise_under_the_motion(self) -> None:
        found = noise_of("x", [run(noisy(3e-4))], {})
        assert found.sd == pytest.approx(3e-4, rel=0.05)
        assert not found.stated
        assert found.step == 0.0

    def test_what_the_file_states_is_taken(self) -> None:
        found = noise_of("x", [run(noisy(3e-4))], {"position_noise": 2e-4})
        assert (found.sd, found.gaussian, found.stated) == (2e-4, 2e-4, True)

    def test_readings_that_show_far_more_are_believed(self) -> None:
        found = noise_of("x", [run(noisy(3e-4))], {"position_noise": 1e-4})
        assert found.sd == pytest.approx(3e-4, rel=0.1)
        assert found.gaussian == pytest.approx(found.sd)
        assert not found.stated

    def test_each_channel_has_its_own_key(self) -> None:
        sensor = {"position_noise": 1.0, "velocity_noise": 2.0, "force_noise": 3.0,
                  "power_noise": 4.0}  # fmt: skip
        found = {c: noise_of(c, [], sensor).sd for c in ("x", "x_rear", "v", "force", "power")}
        assert found == {"x": 1.0, "x_rear": 1.0, "v": 2.0, "force": 3.0, "power": 4.0}

    def test_quantisation_adds_its_variance(self) -> None:
        found = noise_of("x", [], {"position_noise": 3.0, "position_resolution": 4.0 * 12**0.5})
        assert found.sd == pytest.approx(5.0)

    def test_the_step_of_a_quantiser_is_seen(self) -> None:
        step = 2e-3
        found = noise_of("x", [run(step * np.round(noisy(1e-4) / step))], {})
        assert found.step == pytest.approx(step)
        # A step alone errs by its width over the root of 12.
        assert found.sd >= step / 12**0.5 * (1.0 - 1e-9)

    def test_digits_of_a_file_are_no_quantiser(self) -> None:
        found = noise_of("x", [run(np.round(noisy(3e-4), 7))], {})
        assert found.step == 0.0

    def test_missing_readings_do_not_count(self) -> None:
        values = noisy(3e-4)
        values[::5] = np.nan
        assert noise_of("x", [run(values)], {}).sd == pytest.approx(3e-4, rel=0.1)

    def test_no_readings_leave_a_positive_deviation(self) -> None:
        assert noise_of("x", [run(np.ones(5))], {}).sd == 1e-12


class TestNoiseWarnings:
    def said(self, sd: float, sensor: dict[str, float]) -> list[str]:
        return noise_warnings([run(noisy(sd))], sensor)

    def test_noise_as_stated_needs_no_word(self) -> None:
        assert self.said(3e-4, {"position_noise": 3e-4}) == []
        assert self.said(3e-4, {}) == []

    def test_more_noise_than_stated_gives_both_figures(self) -> None:
        (said,) = self.said(3e-4, {"position_noise": 1e-5})
        assert said.startswith("x: all readings show noise of 0.00029, 29 times the stated 1e-05")

    def test_far_less_noise_than_stated_is_said_too(self) -> None:
        (said,) = self.said(1e-5, {"position_noise": 3e-4})
        assert said.startswith("x: the readings show noise of 9.8e-06, the nominal file states")
        assert self.said(1e-4, {"position_noise": 3e-4}) == []


class TestStuck:
    def test_a_quantiser_without_noise_keeps_its_error(self) -> None:
        # The first harmonic of a sawtooth of height 1.
        assert Noise(0.3, 0.0, 1.0, stated=True).stuck == pytest.approx(1.0 / (np.pi * 2**0.5))

    def test_noise_of_half_a_step_shakes_it_loose(self) -> None:
        assert Noise(0.6, 0.5, 1.0, stated=True).stuck < 0.002
        assert Noise(0.5, 0.5, 0.0, stated=True).stuck == 0.0


class TestStretches:
    def test_a_reading_that_leaves_the_band_begins_a_stretch(self) -> None:
        values = np.array([0.0, 0.5, 1.0, 1.1, 1.5, 0.0])
        assert stretches(values, 1.0).tolist() == [0, 0, 0, 1, 1, 2]

    def test_missing_readings_stay_where_they_are(self) -> None:
        values = np.array([0.0, np.nan, 3.0, np.nan])
        assert stretches(values, 1.0).tolist() == [0, 0, 1, 1]

    def test_nothing(self) -> None:
        assert stretches(np.zeros(0), 1.0).size == 0


def test_rows_without_a_reading_change_the_weight_of_none() -> None:
    step = 1e-4
    noise = Noise(step / np.sqrt(12.0), 0.0, step, stated=True)
    read = step * np.round(np.linspace(0.0, 0.02, 401) / step)
    alone = weights_of(read, noise, np.array([0, read.size]))
    rare = np.full(10 * read.size, np.nan)
    rare[::10] = read
    beside = weights_of(rare, noise, np.array([0, rare.size]))
    np.testing.assert_allclose(beside[::10], alone)
    assert alone.min() < alone[0] * 1.01 < noise.sd**-1
