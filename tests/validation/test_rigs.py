"""Drawn rigs and sensors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep.validation.rigs import Rig, Sensors, draw_rig, draw_sensors, log_uniform, rounded

NOMINAL = {
    "segments": 4.0, "mass": 0.3, "gravity": 9.81, "mu_coulomb": 0.2,
    "viscous": 0.0, "slope_deg": 0.0, "gain": 2.0, "limit": np.inf,
}  # fmt: skip


def test_uncertain_values_shift_in_their_own_units() -> None:
    rig = Rig(NOMINAL, uncertainty={"mass": 0.1, "mu_coulomb": 0.2, "clock": 1e-3})
    true = rig.true({"mass": 1.0, "mu_coulomb": -1.0, "clock": 2.0})
    assert true["mass"] == pytest.approx(0.33)
    assert true["mu_coulomb"] == pytest.approx(0.16)
    assert true["clock"] == pytest.approx(2e-3)
    assert true["gain"] == NOMINAL["gain"]
    assert rig.true({}) == {**NOMINAL, "clock": 0.0}


def test_a_level_that_is_a_force_shifts_as_the_coefficient_does() -> None:
    force = {**{k: v for k, v in NOMINAL.items() if k != "mu_coulomb"}, "coulomb_force": 1.5}
    rig = Rig(force, uncertainty={"mu_coulomb": 0.1})
    assert rig.level == 1.5
    assert rig.true({"mu_coulomb": 2.0})["coulomb_force"] == pytest.approx(1.8)


def test_level_of_a_slope() -> None:
    sloped = Rig({**NOMINAL, "slope_deg": 60.0})
    assert sloped.level == pytest.approx(0.5 * Rig(NOMINAL).level)


def test_an_exact_rig_leaves_the_generator_where_another_does() -> None:
    for seed in range(50):
        exact, other = np.random.default_rng(seed), np.random.default_rng(seed)
        one, two = draw_rig(exact, exact=True), draw_rig(other, exact=False)
        assert one.uncertainty == {}
        assert replace(two, uncertainty={}) == one
        assert exact.random() == other.random()


def test_sensors_suit_their_bench() -> None:
    seen = set()
    for seed in range(300):
        rng = np.random.default_rng(seed)
        rig = draw_rig(rng, exact=False)
        sensors = draw_sensors(rng, rig, travel=0.1, speed=0.2, force=3.0)
        assert not ("x_rear" in sensors.channels and (rig.rotary or rig.linear_bench))
        assert ("power" in sensors.channels) == bool(rig.motor)
        assert sensors.deviation("x") > sensors.noise("x") > 0.0
        seen |= set(sensors.channels)
    assert seen == {"v", "force", "x_rear", "power"}


def test_rounding_adds_to_the_deviation_of_positions_only() -> None:
    sensors = Sensors(3e-4, 4e-4 * np.sqrt(12.0), force_noise=0.1)
    assert sensors.deviation("x") == pytest.approx(5e-4)
    assert sensors.deviation("x_rear") == sensors.deviation("x")
    assert sensors.deviation("force") == pytest.approx(0.1)


def test_logarithms_are_uniform() -> None:
    rng = np.random.default_rng(0)
    values = np.array([log_uniform(rng, 0.01, 100.0) for _ in range(2000)])
    assert values.min() >= 0.01
    assert values.max() <= 100.0
    assert np.log10(values).mean() == pytest.approx(0.0, abs=0.1)
    assert rounded(0.0123456, 2) == 0.012
