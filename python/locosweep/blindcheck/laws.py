"""Laws of causes with a strength: from nothing at 0 to a strong effect at 1.

Every cause has the law of its name and at least one other law of the same cause;
`OUTSIDE` are disturbances that no name stands for. The laws themselves are those of
the reality; here stands only how their parameters follow from a rig's scale.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.blindcheck.rigs import log_uniform

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.random import Generator

    Strength = Callable[[float], dict[str, float]]
    Law = Callable[["Scale", Generator], Strength]

__all__ = ["CAUSES", "LAWS", "OUTSIDE", "Cause", "Scale", "draw_cause"]


@dataclass(frozen=True)
class Scale:
    """What is large and small on a rig: forces in N, lengths in m, or N m and rad.

    Attributes
    ----------
    level, force : float
        Coulomb level at the nominal slope, largest drive force.
    mass, grip : float
        Of the head; weight of the body on its anchors.
    speed, travel, low, high : float
        Largest speed, typical range of a run, ends of all positions.
    duration : float
        Of a run, s.
    mu : float
        Coulomb coefficient; NaN where the level is given as a force.
    """

    level: float
    force: float
    mass: float
    grip: float
    speed: float
    travel: float
    low: float
    high: float
    duration: float
    mu: float


@dataclass(frozen=True)
class Cause:
    """A cause with one law of it; `at` gives the parameters at a strength."""

    name: str
    form: str
    at: Strength

    def effect(self, strength: float) -> tuple[str, str, dict[str, float]]:
        """Return what the reality takes."""
        return self.name, self.form, self.at(strength)


LAWS: dict[tuple[str, str], Law] = {}


def _law(name: str, form: str = "law") -> Callable[[Law], Law]:
    def keep(law: Law) -> Law:
        LAWS[name, form] = law
        return law

    return keep


def _sign(rng: Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


@_law("viscous_friction")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"c": 3.0 * s * k.level / k.speed}


@_law("viscous_friction", "power")
def _(k: Scale, rng: Generator) -> Strength:
    n = float(rng.choice([0.7, 1.25]))
    return lambda s: {"c": 3.0 * s * k.level / k.speed, "n": n, "v0": 0.5 * k.speed}


@_law("quadratic_drag")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"c2": 4.0 * s * k.level / k.speed**2}


@_law("quadratic_drag", "power")
def _(k: Scale, rng: Generator) -> Strength:
    n = float(rng.choice([1.5, 2.5]))
    return lambda s: {"c2": 4.0 * s * k.level / k.speed**2, "n": n, "v0": 0.5 * k.speed}


def _stribeck(k: Scale, rng: Generator) -> tuple[Strength, Generator]:
    v_s = k.speed * log_uniform(rng, 0.03, 0.4)
    return (lambda s: {"F_s": k.level * (1.0 + s), "v_s": v_s}), rng


@_law("stribeck_friction")
def _(k: Scale, rng: Generator) -> Strength:
    at, rng = _stribeck(k, rng)
    delta = float(rng.choice([0.7, 1.0, 1.5, 2.0]))
    return lambda s: {**at(s), "delta": delta}


@_law("stribeck_friction", "rational")
def _(k: Scale, rng: Generator) -> Strength:
    return _stribeck(k, rng)[0]


@_law("stribeck_friction", "ramp")
def _(k: Scale, rng: Generator) -> Strength:
    return _stribeck(k, rng)[0]


@_law("presliding_compliance")
def _(k: Scale, rng: Generator) -> Strength:
    zeta = rng.uniform(0.3, 1.0)

    def at(s: float) -> dict[str, float]:
        stiffness = k.level / (0.3 * max(s, 1e-4) * k.travel)
        return {"sigma0": stiffness, "sigma1": 2.0 * zeta * float(np.sqrt(stiffness * k.mass))}

    return at


@_law("presliding_compliance", "dahl")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"sigma0": k.level / (0.3 * max(s, 1e-4) * k.travel)}


def _sides(k: Scale, rng: Generator) -> Strength:
    share = rng.uniform(-1.0, 0.5)
    way = _sign(rng)

    def at(s: float) -> dict[str, float]:
        levels = [1.0 + 0.9 * way * s, 1.0 + 0.9 * way * s * share]
        return {"F_c_forward": k.level * levels[0], "F_c_backward": k.level * levels[1]}

    return at


@_law("direction_dependent_friction")
def _(k: Scale, rng: Generator) -> Strength:
    return _sides(k, rng)


@_law("direction_dependent_friction", "fading")
def _(k: Scale, rng: Generator) -> Strength:
    at, v0 = _sides(k, rng), k.speed * rng.uniform(0.03, 0.15)
    return lambda s: {**at(s), "v0": v0}


@_law("position_dependent_friction")
def _(k: Scale, rng: Generator) -> Strength:
    length, phase = k.travel * log_uniform(rng, 0.3, 2.5), rng.uniform(0.0, 2 * np.pi)
    return lambda s: {"a": min(0.95, s), "L": length, "p": phase}


def _spot(k: Scale, rng: Generator, widths: tuple[float, float]) -> dict[str, float]:
    at = k.low + (k.high - k.low) * rng.uniform(0.2, 0.8)
    return {"x0": at, "w": k.travel * rng.uniform(*widths)}


@_law("position_dependent_friction", "bump")
def _(k: Scale, rng: Generator) -> Strength:
    spot, way = _spot(k, rng, (0.06, 0.3)), _sign(rng)
    return lambda s: {"a": way * 0.9 * s, **spot}


@_law("position_dependent_friction", "step")
def _(k: Scale, rng: Generator) -> Strength:
    spot, way = _spot(k, rng, (0.01, 0.03)), _sign(rng)
    return lambda s: {"a": way * 0.9 * s, **spot}


@_law("load_dependent_friction")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"mu_l": 0.5 * s}


@_law("load_dependent_friction", "square")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"mu_l": 0.5 * s, "F0": k.force}


def _slowly(k: Scale, rng: Generator) -> float:
    return k.duration * log_uniform(rng, 0.15, 1.5)


def _lately(k: Scale, rng: Generator) -> dict[str, float]:
    return {"T": k.duration * rng.uniform(0.3, 0.7), "w": k.duration * rng.uniform(0.03, 0.1)}


@_law("friction_drift")
def _(k: Scale, rng: Generator) -> Strength:
    time, way = _slowly(k, rng), _sign(rng)
    return lambda s: {"a": way * 0.9 * s, "T": time}


@_law("friction_drift", "linear")
def _(k: Scale, rng: Generator) -> Strength:
    way = _sign(rng)
    return lambda s: {"a": way * 0.9 * s, "T": k.duration}


@_law("friction_drift", "late")
def _(k: Scale, rng: Generator) -> Strength:
    late, way = _lately(k, rng), _sign(rng)
    return lambda s: {"a": way * 0.9 * s, **late}


@_law("lubricant_buildup")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"k_b": 6.0 * s * k.level / k.travel}


@_law("lubricant_buildup", "levelling")
def _(k: Scale, rng: Generator) -> Strength:
    s0 = k.travel * rng.uniform(0.1, 0.4)
    return lambda s: {"k_b": 6.0 * s * k.level / k.travel, "s0": s0}


@_law("drive_saturation")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"F_max": k.force * (1.0 - 0.7 * s)}


@_law("drive_saturation", "knee")
def _(k: Scale, rng: Generator) -> Strength:
    n = float(rng.choice([6.0, 10.0]))
    return lambda s: {"F_max": k.force * 0.7 / s, "n": n}


@_law("drive_saturation", "tanh")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"F_max": k.force * 0.6 / s}


@_law("drive_lag")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"T": 0.3 * max(s, 1e-4)}


@_law("drive_lag", "asymmetric")
def _(k: Scale, rng: Generator) -> Strength:
    other = rng.uniform(0.3, 0.6) ** _sign(rng)
    return lambda s: {"T_rise": 0.3 * max(s, 1e-4), "T_fall": 0.3 * max(s, 1e-4) * other}


@_law("drive_lag", "second_order")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"T": 0.3 * max(s, 1e-4)}


@_law("drive_delay")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"T": 0.2 * s}


@_law("drive_delay", "polled")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"T": 0.4 * s}


@_law("drive_deadzone")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"d": 0.6 * s * k.level}


@_law("drive_deadzone", "hysteresis")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"d_open": 1.4 * s * k.level, "d_close": 0.6 * s * k.level}


@_law("drive_deadzone", "soft")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"d": 0.6 * s * k.level}


@_law("drive_gain_error")
def _(k: Scale, rng: Generator) -> Strength:
    way = _sign(rng)
    return lambda s: {"e": way * 0.5 * s}


@_law("drive_gain_error", "asymmetric")
def _(k: Scale, rng: Generator) -> Strength:
    way, other = _sign(rng), rng.uniform(0.6, 0.9) ** _sign(rng)
    return lambda s: {"e_forward": way * 0.4 * s, "e_backward": way * 0.4 * s * other}


@_law("back_emf")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"k_e": 3.0 * s * k.level / k.speed}


@_law("back_emf", "saturating")
def _(k: Scale, rng: Generator) -> Strength:
    v0 = k.speed * rng.uniform(0.5, 1.5)
    return lambda s: {"k_e": 3.0 * s * k.level / k.speed, "v0": v0}


@_law("supply_sag")
def _(k: Scale, rng: Generator) -> Strength:
    time = _slowly(k, rng)
    return lambda s: {"a": 0.7 * s, "T": time}


@_law("supply_sag", "linear")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"a": 0.7 * s, "T": k.duration}


@_law("supply_sag", "late")
def _(k: Scale, rng: Generator) -> Strength:
    late = _lately(k, rng)
    return lambda s: {"a": 0.7 * s, **late}


def _side_mass(k: Scale, share: float, s: float) -> float:
    # A lighter drive side with a weaker effect: at 0 nothing is left of it.
    return k.mass * share * float(np.clip(s / 0.3, 0.02, 1.0))


@_law("transmission_backlash")
def _(k: Scale, rng: Generator) -> Strength:
    share = rng.uniform(0.05, 0.3)
    return lambda s: {"b": 0.15 * s * k.travel, "m_d": _side_mass(k, share, s)}


@_law("transmission_backlash", "soft")
def _(k: Scale, rng: Generator) -> Strength:
    share, stiff = rng.uniform(0.05, 0.3), k.mass * log_uniform(rng, 3e3, 1e4)

    def at(s: float) -> dict[str, float]:
        side = _side_mass(k, share, s)
        damping = 0.8 * float(np.sqrt(stiff * side * k.mass / (side + k.mass)))
        return {"b": 0.15 * s * k.travel, "m_d": side, "k": stiff, "d": damping}

    return at


def _spring(k: Scale, rng: Generator) -> Strength:
    share, zeta = rng.uniform(0.05, 0.3), log_uniform(rng, 0.08, 0.5)

    def at(s: float) -> dict[str, float]:
        side = _side_mass(k, share, s)
        stiff = k.force / (0.3 * max(s, 1e-3) * k.travel)
        damping = 2.0 * zeta * float(np.sqrt(stiff * side * k.mass / (side + k.mass)))
        return {"k": stiff, "d": damping, "m_d": side}

    return at


@_law("transmission_compliance")
def _(k: Scale, rng: Generator) -> Strength:
    return _spring(k, rng)


@_law("transmission_compliance", "hardening")
def _(k: Scale, rng: Generator) -> Strength:
    at = _spring(k, rng)
    return lambda s: {**at(s), "s0": 0.8 * k.force / at(s)["k"]}


@_law("slope_error")
def _(k: Scale, rng: Generator) -> Strength:
    way = _sign(rng)
    return lambda s: {"d_alpha_deg": way * 12.0 * s}


@_law("slope_error", "uneven")
def _(k: Scale, rng: Generator) -> Strength:
    way, length = _sign(rng), k.travel * rng.uniform(0.5, 2.0)
    return lambda s: {"d_alpha_deg": way * 12.0 * s, "a": 0.3, "L": length}


@_law("payload_mass")
def _(k: Scale, rng: Generator) -> Strength:
    way = _sign(rng)
    return lambda s: {"dm": way * 0.5 * s * k.mass}


@_law("payload_mass", "swinging")
def _(k: Scale, rng: Generator) -> Strength:
    shape = {"f": rng.uniform(5.0, 15.0), "zeta": rng.uniform(0.1, 0.4)}
    return lambda s: {"dm": 0.5 * s * k.mass, **shape}


@_law("coulomb_error")
def _(k: Scale, rng: Generator) -> Strength:
    way = _sign(rng)
    return lambda s: {"d_mu": way * 0.5 * s * k.mu}


@_law("coulomb_error", "force")
def _(k: Scale, rng: Generator) -> Strength:
    way = _sign(rng)
    return lambda s: {"d_force": way * 0.5 * s * k.level}


@_law("coulomb_error", "rate")
def _(k: Scale, rng: Generator) -> Strength:
    way, v0 = _sign(rng), 0.1 * k.speed
    return lambda s: {"d_force": way * 0.4 * s * k.level, "a": 0.15, "v0": v0}


def _grip(k: Scale, rng: Generator) -> Strength:
    share = rng.uniform(0.7, 0.97)

    def at(s: float) -> dict[str, float]:
        mu = k.force * (1.0 - 0.7 * s) / k.grip
        return {"mu_static": mu, "mu_coulomb": share * mu}

    return at


@_law("anchor_slip")
def _(k: Scale, rng: Generator) -> Strength:
    return _grip(k, rng)


@_law("anchor_slip", "falling")
def _(k: Scale, rng: Generator) -> Strength:
    at, v0 = _grip(k, rng), k.speed * rng.uniform(0.02, 0.1)
    return lambda s: {**at(s), "v0": v0}


@_law("sensor_scale")
def _(k: Scale, rng: Generator) -> Strength:
    way = _sign(rng)
    return lambda s: {"e": way * 0.3 * s}


@_law("sensor_scale", "bent")
def _(k: Scale, rng: Generator) -> Strength:
    way = _sign(rng)
    return lambda s: {"e": way * 0.3 * s, "L": k.travel}


@_law("sensor_drift")
def _(k: Scale, rng: Generator) -> Strength:
    way = _sign(rng)
    return lambda s: {"b": way * s * k.travel / k.duration}


@_law("sensor_drift", "levelling")
def _(k: Scale, rng: Generator) -> Strength:
    way, time = _sign(rng), k.duration * rng.uniform(0.2, 0.6)
    return lambda s: {"b": way * s * k.travel / time, "T": time}


@_law("sensor_delay")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"T": 0.2 * s}


@_law("sensor_delay", "filter")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"T": 0.2 * max(s, 1e-4)}


@_law("tether", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    slack = k.low + (k.high - k.low) * rng.uniform(0.0, 0.4)
    return lambda s: {"k": 5.0 * s * k.level / k.travel, "x0": slack}


@_law("periodic_push", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    shape = {"f": log_uniform(rng, 0.7, 6.0), "p": rng.uniform(0.0, 2 * np.pi)}
    return lambda s: {"A": 2.0 * s * k.level, **shape}


@_law("coloured_push", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    time = log_uniform(rng, 0.02, 0.5)
    return lambda s: {"A": 2.0 * s * k.level, "T": time}


@_law("gusts", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    shape = {"T": k.duration / 6.0, "w": rng.uniform(0.02, 0.1)}
    return lambda s: {"A": 4.0 * s * k.level, **shape}


@_law("mass_step", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    way, at = _sign(rng), k.duration * rng.uniform(0.3, 0.7)
    return lambda s: {"r": way * 0.6 * s, "t0": at}


@_law("magnet", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    spot = _spot(k, rng, (0.08, 0.3))
    return lambda s: {"A": 4.0 * s * k.level, **spot}


@_law("vibration", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    frequency = rng.uniform(5.0, 30.0)
    return lambda s: {"a": 0.9 * s, "f": frequency}


@_law("rocking", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    shape = {"f": log_uniform(rng, 0.3, 1.5), "p": rng.uniform(0.0, 2 * np.pi)}
    return lambda s: {"A_deg": 15.0 * s, **shape}


@_law("wall", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    stiff = k.mass * (2 * np.pi * rng.uniform(6.0, 20.0)) ** 2
    damping = 2.0 * rng.uniform(0.05, 0.4) * float(np.sqrt(stiff * k.mass))
    return lambda s: {"x0": k.high - 0.8 * s * (k.high - k.low), "k": stiff, "d": damping}


@_law("reading_slips", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    way = _sign(rng)
    return lambda s: {"J": way * 0.3 * s * k.travel, "T": k.duration / 2.5}


@_law("reading_freezes", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    return lambda s: {"w": 0.5 * s, "T": k.duration / 4.0}


OUTSIDE = tuple(name for name, form in LAWS if form == "outside")
"""Disturbances that are no effect of the list."""

CAUSES = tuple(dict.fromkeys(name for name, form in LAWS if form != "outside"))
"""Effects of the list."""


def draw_cause(rng: Generator, scale: Scale, name: str, form: str) -> Cause:
    """Draw what of a law does not depend on its strength."""
    return Cause(name, form, LAWS[name, form](scale, rng))
