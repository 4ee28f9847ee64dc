"""The table of laws with a strength."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep import _core
from locosweep.simulation.replay import effects
from locosweep.validation.laws import CAUSES, LAWS, OUTSIDE, Scale, draw_cause

SCALE = Scale(
    level=0.6,
    force=2.0,
    mass=0.3,
    grip=8.8,
    speed=0.2,
    travel=0.1,
    low=-0.05,
    high=0.08,
    duration=1.0,
    mu=0.2,
)
RIG = {
    "segments": 4.0,
    "mass": 0.3,
    "gravity": 9.81,
    "mu_coulomb": 0.2,
    "viscous": 0.0,
    "slope_deg": 0.0,
    "gain": 1.0,
    "limit": np.inf,
}
BENCH = {**{k: v for k, v in RIG.items() if k != "mu_coulomb"}, "coulomb_force": 0.6}
T = np.arange(0.0, 1.0, 0.01)
RUN = (T, 1.5 * np.sin(2 * np.pi * T), 0.0)


def position(rig: dict[str, float], *laws: tuple[str, str, dict[str, float]]) -> np.ndarray:
    ((x, *_),) = _core.reality_run([RUN], [(0, rig, list(laws), (0.0, 0.0), 5e-4, 1)], 1)
    return np.asarray(x)


def test_every_effect_has_a_law_and_another_form() -> None:
    drawn = {record.name for record in effects() if record.drawn}
    assert drawn <= set(CAUSES) <= {record.name for record in effects()}
    assert not set(CAUSES) & set(OUTSIDE)
    for cause in CAUSES:
        forms = [form for name, form in LAWS if name == cause]
        assert forms[0] == "law"
        assert set(forms) - {"law", "force"}, cause


@pytest.mark.parametrize(("name", "form"), sorted(LAWS))
def test_the_reality_takes_every_law(name: str, form: str) -> None:
    cause = draw_cause(np.random.default_rng(3), SCALE, name, form)
    assert cause.effect(0.5) == (name, form, cause.at(0.5))
    rig = BENCH if (name, form) == ("coulomb_error", "force") else RIG
    for strength in (1e-3, 1.0):
        assert np.isfinite(list(cause.at(strength).values())).all()
        assert np.isfinite(position(rig, cause.effect(strength))).all()


@pytest.mark.parametrize(("name", "form"), sorted(LAWS))
def test_numbers_are_drawn_once(name: str, form: str) -> None:
    one, again = (draw_cause(np.random.default_rng(7), SCALE, name, form) for _ in range(2))
    first = one.at(0.4)
    assert one.at(0.9) is not first
    assert one.at(0.4) == again.at(0.4) == first


@pytest.mark.parametrize("name", ["viscous_friction", "drive_gain_error", "sensor_scale"])
def test_a_weaker_law_changes_less(name: str) -> None:
    cause = draw_cause(np.random.default_rng(0), SCALE, name, "law")
    nominal = position(RIG)
    weak, strong = (
        float(np.linalg.norm(position(RIG, cause.effect(s)) - nominal)) for s in (0.01, 0.3)
    )
    assert 0.0 < weak < strong
