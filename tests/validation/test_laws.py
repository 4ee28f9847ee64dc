"""The table of laws with a strength."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep import _core
from locosweep.simulation.replay import effects
from locosweep.validation.cases import draw_case, scale_of_runs
from locosweep.validation.experiment import World
from locosweep.validation.laws import (
    ALL_LAWS,
    CAUSES,
    KEPT_OUT,
    LAWS,
    OUTSIDE,
    Scale,
    draw_background,
    draw_cause,
)
from locosweep.validation.sizes import Nuisances

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
    assert not set(CAUSES) & {*OUTSIDE, *KEPT_OUT}
    assert not set(KEPT_OUT) & set(OUTSIDE)
    for cause in CAUSES:
        forms = [form for name, form in LAWS if name == cause]
        assert forms[0] == "law"
        assert set(forms) - {"law", "force"}, cause


@pytest.mark.parametrize(("name", "form"), sorted(ALL_LAWS))
def test_the_reality_takes_every_law(name: str, form: str) -> None:
    cause = draw_cause(np.random.default_rng(3), SCALE, name, form)
    assert cause.effect(0.5) == (name, form, cause.at(0.5))
    rig = BENCH if (name, form) == ("coulomb_error", "force") else RIG
    for strength in (1e-3, 1.0):
        assert np.isfinite(list(cause.at(strength).values())).all()
        assert np.isfinite(position(rig, cause.effect(strength))).all()


@pytest.mark.parametrize(("name", "form"), sorted(ALL_LAWS))
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


@pytest.mark.parametrize("name", KEPT_OUT)
def test_a_weaker_disturbance_changes_less(name: str) -> None:
    cause = draw_cause(np.random.default_rng(0), SCALE, name, "outside")
    nominal = position(RIG)
    weak, strong = (
        float(np.linalg.norm(position(RIG, cause.effect(s)) - nominal)) for s in (0.03, 0.3)
    )
    assert 0.0 < weak < strong


def test_backgrounds_are_taken_by_the_reality() -> None:
    drawn = [draw_background(np.random.default_rng(seed), SCALE) for seed in range(12)]
    assert {cause.name for cause in drawn} == {"coloured_push", "slope_error", "friction_drift"}
    for cause in drawn:
        assert np.isfinite(position(RIG, cause.effect(0.1))).all()


def test_a_sagging_rail_pulls_to_its_middle() -> None:
    law = ("sagging_rail", "outside", {"A_deg": 5.0, "x0": 0.0, "L": 0.2})
    alpha = np.radians(5.0 * 0.1 / 0.2)
    friction = {**RIG, "mu_coulomb": 0.5 * np.tan(alpha)}
    idle = (T, np.zeros_like(T), 0.0)
    ((x, *_),) = _core.reality_run([idle], [(0, friction, [law], (0.1, 0.0), 1e-4, 1)], 1)
    # As on the slope of its place to first order: half of its pull is left beside friction.
    pull = 9.81 * (np.sin(alpha) - friction["mu_coulomb"] * np.cos(alpha))
    assert x[10] - 0.1 == pytest.approx(-0.5 * pull * T[10] ** 2, rel=0.02)


def test_a_dust_ridge_resists_only_at_its_front() -> None:
    law = ("dust_ridge", "outside", {"A": 0.5, "L": 0.02})
    free = position(RIG)
    pushed = position(RIG, law)
    front = int(np.argmax(pushed))
    assert pushed[front] < free.max()
    # On the way back nothing resists but friction, beside a command that is held.
    push = 1.5 * np.sin(2 * np.pi * T)
    ((_, v, *_),) = _core.reality_run([RUN], [(0, RIG, [law], (0.0, 0.0), 1e-5, 1)], 1)
    back = slice(front + 2, front + 12)
    assert (v[back] < 0.0).all()
    expected = (push[back] + 0.2 * 0.3 * 9.81) / 0.3
    assert (np.diff(v) / np.diff(T))[back] == pytest.approx(expected, rel=1e-6)


def test_a_loose_encoder_lags_by_half_its_play() -> None:
    free = position(RIG)
    loose = position(RIG, ("loose_encoder", "outside", {"b": 0.02}))
    assert np.abs(loose - free).max() == pytest.approx(0.01, rel=1e-6)


def test_mains_hum_shakes_as_a_force_on_a_mass_does() -> None:
    smooth = {**RIG, "mu_coulomb": 0.0}
    amplitude, f = 3.0, 50.0
    law = ("mains_hum", "outside", {"A": amplitude, "f": f, "p": 0.5 * np.pi})
    times = np.arange(0.0, 0.2, 1e-3)
    idle = (times, np.zeros_like(times), 0.0)
    ((x, *_),) = _core.reality_run([idle], [(0, smooth, [law], (0.0, 0.0), 1e-5, 1)], 1)
    omega = 2 * np.pi * f
    closed = amplitude / 0.3 * (1.0 - np.cos(omega * times)) / omega**2
    assert x == pytest.approx(closed, abs=1e-8)


def test_a_cable_reel_holds_less_while_it_winds_up() -> None:
    smooth = {**RIG, "mu_coulomb": 0.0}
    law = ("cable_reel", "outside", {"A": 0.3, "k": 0.0, "x0": 0.0, "h": 0.25, "v0": 1e-4})
    idle = (T, np.zeros_like(T), 0.0)
    for speed, pull in ((0.4, 0.3 * 1.25), (-0.4, 0.3 * 0.75)):
        ((x, *_),) = _core.reality_run([idle], [(0, smooth, [law], (0.0, speed), 1e-5, 1)], 1)
        assert x[20] == pytest.approx(speed * T[20] - 0.5 * pull / 0.3 * T[20] ** 2, rel=1e-3)


@pytest.mark.slow
def test_a_law_of_no_strength_changes_nothing_on_a_rig_that_is_not_as_told() -> None:
    """Levels of effects refer to the rig as it is, not as its file says.

    Friction that differs by direction was a level that is off by the uncertainty of the file, and
    friction that falls from rest an equal copy of it.
    """
    case = draw_case(3, 0, gap_free=True)
    uncertain = {"mu_coulomb": 0.03, "mass": 0.02}
    experiment = replace(case.experiment, rig=replace(case.experiment.rig, uncertainty=uncertain))
    shifts = {"mu_coulomb": 2.0, "mass": -1.0}
    nuisances = Nuisances(experiment, scale_of_runs(experiment, shifts), World(shifts), 1)
    rng = np.random.default_rng(0)
    off = {}
    friction = {one.name for one in effects() if one.site == "friction"}
    # Bristles have a least deflection, and levels as forces are those of other rigs.
    for name, form in LAWS:
        if name not in friction - {"presliding_compliance"} or form == "force":
            continue
        cause = draw_cause(rng, nuisances.scale, name, form)
        off[name, form] = nuisances.size(((name, form, cause.at(1e-9)),))
    assert {key: size for key, size in off.items() if not size < 0.1} == {}
