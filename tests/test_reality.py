"""The blind check's reality against the engine's own replay: two codes, one contract."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep import _core
from locosweep.errors import InputError
from locosweep.simulation.replay import effect_values, effects
from locosweep.validation.laws import ALL_LAWS, CAUSES, OUTSIDE

NOMINAL = {
    "segments": 4.0, "mass": 0.8, "gravity": 9.81, "mu_coulomb": 0.3, "viscous": 0.4,
    "slope_deg": 2.0, "gain": 1.1, "limit": float("inf"),
}  # fmt: skip
LEVEL = 0.3 * 0.8 * 9.81 * np.cos(np.radians(2.0))
STRONG = {
    "viscous_friction": {"c": 1.0},
    "quadratic_drag": {"c2": 3.0},
    "stribeck_friction": {"F_s": LEVEL * 1.3, "v_s": 0.03, "delta": 1.5},
    "presliding_compliance": {"sigma0": 2e4, "sigma1": 60.0},
    "direction_dependent_friction": {"F_c_forward": LEVEL * 1.2, "F_c_backward": LEVEL * 0.7},
    "position_dependent_friction": {"a": 0.3, "L": 0.08, "p": 0.7},
    "load_dependent_friction": {"mu_l": 0.1},
    "friction_drift": {"a": 0.3, "T": 1.0},
    "lubricant_buildup": {"k_b": 8.0},
    "drive_saturation": {"F_max": 3.8},
    "drive_lag": {"T": 0.03},
    "drive_delay": {"T": 0.0123},
    "drive_deadzone": {"d": 0.4},
    "drive_gain_error": {"e": -0.1},
    "back_emf": {"k_e": 1.3},
    "supply_sag": {"a": 0.2, "T": 2.0},
    "transmission_backlash": {"b": 0.002, "m_d": 0.1},
    "transmission_compliance": {"k": 400.0, "d": 2.0, "m_d": 0.1},
    "slope_error": {"d_alpha_deg": 1.5},
    "payload_mass": {"dm": 0.2},
    "coulomb_error": {"d_mu": 0.05},
    "anchor_slip": {"mu_static": 0.2, "mu_coulomb": 0.15},
    "sensor_scale": {"e": 0.05},
    "sensor_drift": {"b": 0.01},
    "sensor_delay": {"T": 0.0173},
}
START = (0.01, 0.05)


def drive() -> tuple[np.ndarray, np.ndarray]:
    t = np.round(np.arange(0.0, 2.0, 0.005), 6)
    wave = sum(np.sin(2 * np.pi * f * t + p) for f, p in ((0.7, 0.3), (1.9, 1.0), (3.1, 2.0)))
    return t, np.where(t < 0.1, 0.0, 2.1 * wave)


def both(
    chosen: dict[str, dict[str, float]], slope_deg: float = 3.0
) -> list[dict[str, np.ndarray]]:
    """Readings of the engine and of the reality."""
    t, command = drive()
    runs = [(t, command, slope_deg)]
    job = _core.Replay(NOMINAL, runs)
    shares, starts = np.array([[1.0, 1.0, 1.0, 0.0]]), np.array([START])
    engine = job.run([(0, 0, t.size, list(chosen))], effect_values(chosen)[None], shares, starts, 1)
    law = [(name, "law", values) for name, values in chosen.items()]
    reality = _core.reality_run(runs, [(0, NOMINAL, law, START, 1e-5, 1)], 1)[0]
    return [dict(zip(("x", "v", "x_rear", "force"), r, strict=True)) for r in (engine, reality)]


def test_every_effect_has_its_law_and_another() -> None:
    names = {record.name for record in effects()}
    assert set(CAUSES) == names == set(STRONG)
    forms = {(name, form) for name, form, _ in _core.reality_forms()}
    assert forms == set(ALL_LAWS)
    for name in names:
        assert (name, "law") in forms
        assert any(cause == name and form != "law" for cause, form in forms)
    assert len(OUTSIDE) >= 6


@pytest.mark.parametrize("name", sorted(STRONG))
def test_laws_are_those_of_the_engine(name: str) -> None:
    engine, reality = both({name: STRONG[name]})
    plain = both({})[1]
    effect = max(np.abs(reality[c] - plain[c]).max() for c in ("x", "x_rear"))
    assert effect > 1e-3
    # Where a contact begins the force jumps, by 20 N here: the reality's steps tell when
    # to some microseconds.
    bars = {"transmission_backlash": (2e-5, 0.1)}.get(name, (5e-6, 1e-5))
    for channel, bar in (("x", bars[0]), ("x_rear", bars[0]), ("force", bars[1])):
        assert np.abs(engine[channel] - reality[channel]).max() < bar


@pytest.mark.parametrize(
    "names",
    [
        (
            "drive_delay",
            "drive_gain_error",
            "drive_deadzone",
            "drive_saturation",
            "drive_lag",
            "back_emf",
        ),
        ("drive_deadzone", "transmission_compliance", "back_emf", "load_dependent_friction"),
        (
            "friction_drift",
            "position_dependent_friction",
            "direction_dependent_friction",
            "payload_mass",
        ),
        ("sensor_scale", "sensor_drift", "sensor_delay"),
        (
            "presliding_compliance",
            "transmission_compliance",
            "load_dependent_friction",
            "drive_lag",
            "back_emf",
        ),
        ("presliding_compliance", "transmission_backlash", "stribeck_friction"),
        ("slope_error", "payload_mass", "coulomb_error", "anchor_slip", "drive_lag"),
    ],
)
def test_several_effects_act_in_the_engines_order(names: tuple[str, ...]) -> None:
    engine, reality = both({name: STRONG[name] for name in names})
    # Where a contact begins the force jumps: see above.
    force = 0.1 if "transmission_backlash" in names else 1e-3
    # Under a lag the engine drives the body by the mean force of each sample's interval.
    for channel, bar in (("x", 2e-5), ("x_rear", 1e-3), ("force", force)):
        assert np.abs(engine[channel] - reality[channel]).max() < bar


PENDULUM = {
    **NOMINAL, "coulomb_force": 0.3, "gravity_torque": 3.0, "mass": 0.2, "slope_deg": 0.0,
}  # fmt: skip
ON_A_PENDULUM = {
    **{
        name: values
        for name, values in STRONG.items()
        if name not in ("anchor_slip", "slope_error")
    },
    "stribeck_friction": {"F_s": 0.45, "v_s": 0.1, "delta": 1.5},
    "presliding_compliance": {"sigma0": 500.0, "sigma1": 3.0},
    "direction_dependent_friction": {"F_c_forward": 0.4, "F_c_backward": 0.2},
    "drive_saturation": {"F_max": 2.0},
    "transmission_backlash": {"b": 0.01, "m_d": 0.05},
    "transmission_compliance": {"k": 400.0, "d": 2.0, "m_d": 0.02},
    "payload_mass": {"dm": 0.05},
}


@pytest.mark.parametrize("name", sorted(ON_A_PENDULUM))
def test_laws_are_those_of_the_engine_on_a_pendulum(name: str) -> None:
    chosen, form = {name: ON_A_PENDULUM[name]}, "law"
    if name == "coulomb_error":
        chosen, form = {name: {"d_force": 0.1}}, "force"
    t, command = drive()
    runs = [(t, command, 0.0)]
    job = _core.Replay(PENDULUM, runs)
    shares, starts = np.array([[1.0, 1.0, 1.0, 0.0]]), np.array([START])
    engine = job.run([(0, 0, t.size, list(chosen))], effect_values(chosen)[None], shares, starts, 1)
    laws = [[(name, form, chosen[name])], []]
    jobs = [(0, PENDULUM, law, START, 1e-5, 1) for law in laws]
    reality, plain = _core.reality_run(runs, jobs, 1)
    assert np.abs(reality[0] - plain[0]).max() > 1e-3
    # A gap closes with a blow: its time is known to some microseconds.
    bar = 5e-6 if name == "transmission_backlash" else 2e-6
    assert np.abs(engine[0] - reality[0]).max() < bar


def test_a_clock_shifts_the_drive() -> None:
    t, command = drive()
    runs = [(t, command, 0.0)]
    late = {**NOMINAL, "clock": 0.004}
    delay = [("drive_delay", "law", {"T": 0.004})]
    jobs = [(0, late, [], START, 1e-4, 1), (0, NOMINAL, delay, START, 1e-4, 1)]
    a, b = _core.reality_run(runs, jobs, 1)
    assert np.array_equal(a[0], b[0])


def test_bad_jobs_are_refused_in_one_line() -> None:
    t, command = drive()
    good = (t, command, 0.0)
    job = (0, NOMINAL, [], START, 1e-4, 1)
    with pytest.raises(InputError, match="times that rise from 0"):
        _core.reality_run([(t + 1.0, command, 0.0)], [job], 1)
    with pytest.raises(InputError, match="a run below 1"):
        _core.reality_run([good], [(1, *job[1:])], 1)
    with pytest.raises(InputError, match="no effect gravity"):
        _core.reality_run([good], [(0, NOMINAL, [("gravity", "law", {})], START, 1e-4, 1)], 1)
    bare = {k: v for k, v in NOMINAL.items() if k != "gain"}
    with pytest.raises(InputError, match="the rig has no gain"):
        _core.reality_run([good], [(0, bare, [], START, 1e-4, 1)], 1)
