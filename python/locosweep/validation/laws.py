"""Laws of causes with a strength: from nothing at 0 to a strong effect at 1.

Every cause has the law of its name and at least one other functional form; those of the
form `outside` are disturbances that no effect of the list stands for. The laws themselves
are those of the reality; here stands only how their parameters follow from a rig's scale.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from locosweep.validation.rigs import log_uniform

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.random import Generator

    Parameters = dict[str, float]
    Draw = Callable[[Generator], float]


@dataclass(frozen=True)
class Scale:
    """Sizes of a rig and its runs: forces in N, lengths in m, or N m and rad.

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
    at: Callable[[float], Parameters]

    def effect(self, strength: float) -> tuple[str, str, Parameters]:
        """Return what the reality takes."""
        return self.name, self.form, self.at(strength)


class _Law:
    """Parameters of a law from strength, scale and numbers that are drawn once, in order."""

    def __init__(self, parameters: Callable[..., Parameters], *draws: Draw) -> None:
        self.parameters, self.draws = parameters, draws


def _uniform(low: float, high: float) -> Draw:
    return lambda rng: rng.uniform(low, high)


def _log_uniform(low: float, high: float) -> Draw:
    return lambda rng: log_uniform(rng, low, high)


def _one_of(*values: float) -> Draw:
    return lambda rng: float(rng.choice(values))


_SIGN = _one_of(-1.0, 1.0)
_PHASE = _uniform(0.0, 2 * pi)
_SIDE_MASS = _uniform(0.05, 0.3)
"""Share of the drive side in the head's mass."""
_TIME = _log_uniform(0.15, 1.5)
"""Time constant of a change that levels out, as a share of a run."""
_LATE = _uniform(0.3, 0.7), _uniform(0.03, 0.1)
"""Time of a late change and its width, as shares of a run."""
_MIDDLE = _uniform(0.2, 0.8)
"""A position between the ends of the head's range, as a share of it."""


def _late(k: Scale, at: float, width: float) -> Parameters:
    return {"T": k.duration * at, "w": k.duration * width}


def _spot(k: Scale, at: float, width: float) -> Parameters:
    return {"x0": k.low + (k.high - k.low) * at, "w": k.travel * width}


def _side_mass(s: float, k: Scale, share: float) -> float:
    # A lighter drive side with a weaker effect: at 0 nothing is left of it.
    return k.mass * share * float(np.clip(s / 0.3, 0.02, 1.0))


def _damping(k: Scale, ratio: float, stiffness: float, side: float) -> float:
    """Damping of a transmission between the head and the mass of the drive side."""
    return ratio * float(np.sqrt(stiffness * side * k.mass / (side + k.mass)))


def _play(s: float, k: Scale, share: float) -> Parameters:
    # Less weak than the mass behind it: play that nobody can see is none.
    return {"b": 0.15 * float(np.sqrt(s)) * k.travel, "m_d": _side_mass(s, k, share)}


def _soft_play(s: float, k: Scale, share: float, stiffness: float) -> Parameters:
    play, k_c = _play(s, k, share), k.mass * stiffness
    return {**play, "k": k_c, "d": _damping(k, 0.8, k_c, play["m_d"])}


def _spring(s: float, k: Scale, share: float, zeta: float) -> Parameters:
    side = _side_mass(s, k, share)
    stiffness = k.force / (0.3 * max(s, 1e-3) * k.travel)
    return {"k": stiffness, "d": _damping(k, 2.0 * zeta, stiffness, side), "m_d": side}


def _hardening_spring(s: float, k: Scale, share: float, zeta: float) -> Parameters:
    spring = _spring(s, k, share, zeta)
    return {**spring, "s0": 0.8 * k.force / spring["k"]}


def _bristles(s: float, k: Scale) -> Parameters:
    return {"sigma0": k.level / (0.3 * max(s, 1e-4) * k.travel)}


def _damped_bristles(s: float, k: Scale, zeta: float) -> Parameters:
    bristles = _bristles(s, k)
    return {**bristles, "sigma1": 2.0 * zeta * float(np.sqrt(bristles["sigma0"] * k.mass))}


def _sides(s: float, k: Scale, share: float, sign: float) -> Parameters:
    return {
        "F_c_forward": k.level * (1.0 + 0.9 * sign * s),
        "F_c_backward": k.level * (1.0 + 0.9 * sign * s * share),
    }


def _stribeck(s: float, k: Scale, v_s: float) -> Parameters:
    return {"F_s": k.level * (1.0 + s), "v_s": k.speed * v_s}


def _grip(s: float, k: Scale, share: float) -> Parameters:
    mu = k.force * (1.0 - 0.7 * s) / k.grip
    return {"mu_static": mu, "mu_coulomb": share * mu}


def _wall(s: float, k: Scale, frequency: float, zeta: float) -> Parameters:
    stiffness = k.mass * (2 * pi * frequency) ** 2
    x0 = k.high - 0.8 * s * (k.high - k.low)
    return {"x0": x0, "k": stiffness, "d": 2.0 * zeta * float(np.sqrt(stiffness * k.mass))}


_DRIVE = {
    ("drive_saturation", "law"): _Law(lambda s, k: {"F_max": k.force * (1.0 - 0.7 * s)}),
    ("drive_saturation", "knee"): _Law(
        lambda s, k, n: {"F_max": k.force * 0.7 / s, "n": n}, _one_of(6.0, 10.0)
    ),
    ("drive_saturation", "tanh"): _Law(lambda s, k: {"F_max": k.force * 0.6 / s}),
    ("drive_lag", "law"): _Law(lambda s, _: {"T": 0.3 * max(s, 1e-4)}),
    ("drive_lag", "asymmetric"): _Law(
        lambda s, _, other, sign: {
            "T_rise": 0.3 * max(s, 1e-4), "T_fall": 0.3 * max(s, 1e-4) * other**sign
        },
        _uniform(0.3, 0.6), _SIGN,
    ),
    ("drive_lag", "second_order"): _Law(lambda s, _: {"T": 0.3 * max(s, 1e-4)}),
    ("drive_delay", "law"): _Law(lambda s, _: {"T": 0.2 * s}),
    # From some share of a period on: samples often lie a whole number of periods apart, and
    # at instants of reading their rounded times would say which change is late.
    ("drive_delay", "polled"): _Law(lambda s, _, p: {"T": 0.4 * s, "p": p}, _uniform(0.0, 1.0)),
    ("drive_deadzone", "law"): _Law(lambda s, k: {"d": 0.6 * s * k.level}),
    ("drive_deadzone", "hysteresis"): _Law(
        lambda s, k: {"d_open": 1.4 * s * k.level, "d_close": 0.6 * s * k.level}
    ),
    ("drive_deadzone", "soft"): _Law(lambda s, k: {"d": 0.6 * s * k.level}),
    ("drive_gain_error", "law"): _Law(lambda s, _, sign: {"e": sign * 0.5 * s}, _SIGN),
    ("drive_gain_error", "asymmetric"): _Law(
        lambda s, _, sign, other, power: {
            "e_forward": sign * 0.4 * s, "e_backward": sign * 0.4 * s * other**power
        },
        _SIGN, _uniform(0.6, 0.9), _SIGN,
    ),
    ("back_emf", "law"): _Law(lambda s, k: {"k_e": 3.0 * s * k.level / k.speed}),
    ("back_emf", "saturating"): _Law(
        lambda s, k, v0: {"k_e": 3.0 * s * k.level / k.speed, "v0": k.speed * v0},
        _uniform(0.5, 1.5),
    ),
    ("supply_sag", "law"): _Law(lambda s, k, time: {"a": 0.7 * s, "T": k.duration * time}, _TIME),
    ("supply_sag", "linear"): _Law(lambda s, k: {"a": 0.7 * s, "T": k.duration}),
    ("supply_sag", "late"): _Law(
        lambda s, k, *late: {"a": 0.7 * s, **_late(k, *late)}, *_LATE
    ),
    ("transmission_backlash", "law"): _Law(_play, _SIDE_MASS),
    ("transmission_backlash", "soft"): _Law(_soft_play, _SIDE_MASS, _log_uniform(3e3, 1e4)),
    ("transmission_compliance", "law"): _Law(_spring, _SIDE_MASS, _log_uniform(0.08, 0.5)),
    ("transmission_compliance", "hardening"): _Law(
        _hardening_spring, _SIDE_MASS, _log_uniform(0.08, 0.5)
    ),
}  # fmt: skip

_FRICTION = {
    ("viscous_friction", "law"): _Law(lambda s, k: {"c": 3.0 * s * k.level / k.speed}),
    ("viscous_friction", "power"): _Law(
        lambda s, k, n: {"c": 3.0 * s * k.level / k.speed, "n": n, "v0": 0.5 * k.speed},
        _one_of(0.7, 1.25),
    ),
    ("quadratic_drag", "law"): _Law(lambda s, k: {"c2": 4.0 * s * k.level / k.speed**2}),
    ("quadratic_drag", "power"): _Law(
        lambda s, k, n: {"c2": 4.0 * s * k.level / k.speed**2, "n": n, "v0": 0.5 * k.speed},
        _one_of(1.5, 2.5),
    ),
    ("stribeck_friction", "law"): _Law(
        lambda s, k, v_s, delta: {**_stribeck(s, k, v_s), "delta": delta},
        _log_uniform(0.03, 0.4), _one_of(0.7, 1.0, 1.5, 2.0),
    ),
    ("stribeck_friction", "rational"): _Law(_stribeck, _log_uniform(0.03, 0.4)),
    ("stribeck_friction", "ramp"): _Law(_stribeck, _log_uniform(0.03, 0.4)),
    ("presliding_compliance", "law"): _Law(_damped_bristles, _uniform(0.3, 1.0)),
    ("presliding_compliance", "dahl"): _Law(_bristles),
    ("direction_dependent_friction", "law"): _Law(_sides, _uniform(-1.0, 0.5), _SIGN),
    ("direction_dependent_friction", "fading"): _Law(
        lambda s, k, share, sign, v0: {**_sides(s, k, share, sign), "v0": k.speed * v0},
        _uniform(-1.0, 0.5), _SIGN, _uniform(0.03, 0.15),
    ),
    ("position_dependent_friction", "law"): _Law(
        lambda s, k, length, phase: {"a": min(0.95, s), "L": k.travel * length, "p": phase},
        _log_uniform(0.3, 2.5), _PHASE,
    ),
    ("position_dependent_friction", "bump"): _Law(
        lambda s, k, at, width, sign: {"a": sign * 0.9 * s, **_spot(k, at, width)},
        _MIDDLE, _uniform(0.06, 0.3), _SIGN,
    ),
    ("position_dependent_friction", "step"): _Law(
        lambda s, k, at, width, sign: {"a": sign * 0.9 * s, **_spot(k, at, width)},
        _MIDDLE, _uniform(0.01, 0.03), _SIGN,
    ),
    ("load_dependent_friction", "law"): _Law(lambda s, _: {"mu_l": 0.5 * s}),
    ("load_dependent_friction", "square"): _Law(lambda s, k: {"mu_l": 0.5 * s, "F0": k.force}),
    ("friction_drift", "law"): _Law(
        lambda s, k, time, sign: {"a": sign * 0.9 * s, "T": k.duration * time}, _TIME, _SIGN
    ),
    ("friction_drift", "linear"): _Law(
        lambda s, k, sign: {"a": sign * 0.9 * s, "T": k.duration}, _SIGN
    ),
    ("friction_drift", "late"): _Law(
        lambda s, k, at, width, sign: {"a": sign * 0.9 * s, **_late(k, at, width)}, *_LATE, _SIGN
    ),
    ("lubricant_buildup", "law"): _Law(lambda s, k: {"k_b": 6.0 * s * k.level / k.travel}),
    ("lubricant_buildup", "levelling"): _Law(
        lambda s, k, s0: {"k_b": 6.0 * s * k.level / k.travel, "s0": k.travel * s0},
        _uniform(0.1, 0.4),
    ),
    ("coulomb_error", "law"): _Law(lambda s, k, sign: {"d_mu": sign * 0.5 * s * k.mu}, _SIGN),
    ("coulomb_error", "force"): _Law(
        lambda s, k, sign: {"d_force": sign * 0.5 * s * k.level}, _SIGN
    ),
    ("coulomb_error", "rate"): _Law(
        lambda s, k, sign: {"d_force": sign * 0.4 * s * k.level, "a": 0.15, "v0": 0.1 * k.speed},
        _SIGN,
    ),
}  # fmt: skip

_OUTSIDE = {
    ("tether", "outside"): _Law(
        lambda s, k, slack: {
            "k": 5.0 * s * k.level / k.travel, "x0": k.low + (k.high - k.low) * slack
        },
        _uniform(0.0, 0.4),
    ),
    ("periodic_push", "outside"): _Law(
        lambda s, k, f, p: {"A": 2.0 * s * k.level, "f": f, "p": p}, _log_uniform(0.7, 6.0), _PHASE
    ),
    ("coloured_push", "outside"): _Law(
        lambda s, k, time: {"A": 2.0 * s * k.level, "T": time}, _log_uniform(0.02, 0.5)
    ),
    ("gusts", "outside"): _Law(
        lambda s, k, w: {"A": 4.0 * s * k.level, "T": k.duration / 6.0, "w": w},
        _uniform(0.02, 0.1),
    ),
    ("mass_step", "outside"): _Law(
        lambda s, k, sign, at: {"r": sign * 0.6 * s, "t0": k.duration * at},
        _SIGN, _uniform(0.3, 0.7),
    ),
    ("magnet", "outside"): _Law(
        lambda s, k, at, width: {"A": 4.0 * s * k.level, **_spot(k, at, width)},
        _MIDDLE, _uniform(0.08, 0.3),
    ),
    ("vibration", "outside"): _Law(lambda s, _, f: {"a": 0.9 * s, "f": f}, _uniform(5.0, 30.0)),
    ("rocking", "outside"): _Law(
        lambda s, _, f, p: {"A_deg": 15.0 * s, "f": f, "p": p}, _log_uniform(0.3, 1.5), _PHASE
    ),
    ("wall", "outside"): _Law(_wall, _uniform(6.0, 20.0), _uniform(0.05, 0.4)),
    ("reading_slips", "outside"): _Law(
        lambda s, k, sign: {"J": sign * 0.3 * s * k.travel, "T": k.duration / 2.5}, _SIGN
    ),
    ("reading_freezes", "outside"): _Law(lambda s, k: {"w": 0.5 * s, "T": k.duration / 4.0}),
}  # fmt: skip

_KEPT_OUT = {
    ("dust_ridge", "outside"): _Law(
        lambda s, k, length: {"A": 3.0 * s * k.level, "L": k.travel * length}, _uniform(0.1, 1.0)
    ),
    ("cable_reel", "outside"): _Law(
        lambda s, k, share, loss: {
            "A": 1.5 * s * share * k.level, "k": 1.5 * s * (1.0 - share) * k.level / k.travel,
            "x0": k.low, "h": loss, "v0": 0.02 * k.speed,
        },
        _uniform(0.2, 0.8), _uniform(0.1, 0.4),
    ),
    ("mains_hum", "outside"): _Law(
        lambda s, k, f, p: {"A": 20.0 * s * k.level, "f": f, "p": p}, _one_of(50.0, 60.0), _PHASE
    ),
    ("sagging_rail", "outside"): _Law(
        lambda s, k, at: {
            "A_deg": 15.0 * s, "x0": k.low + (k.high - k.low) * at, "L": k.high - k.low
        },
        _uniform(0.3, 0.7),
    ),
    ("loose_encoder", "outside"): _Law(lambda s, k: {"b": 0.5 * s * k.travel}),
}  # fmt: skip

_MASS_SLOPE_SENSORS = {
    ("slope_error", "law"): _Law(lambda s, _, sign: {"d_alpha_deg": sign * 12.0 * s}, _SIGN),
    ("slope_error", "uneven"): _Law(
        lambda s, k, sign, length: {
            "d_alpha_deg": sign * 12.0 * s, "a": 0.3, "L": k.travel * length
        },
        _SIGN, _uniform(0.5, 2.0),
    ),
    ("payload_mass", "law"): _Law(lambda s, k, sign: {"dm": sign * 0.5 * s * k.mass}, _SIGN),
    ("payload_mass", "swinging"): _Law(
        lambda s, k, f, zeta: {"dm": 0.5 * s * k.mass, "f": f, "zeta": zeta},
        _uniform(5.0, 15.0), _uniform(0.1, 0.4),
    ),
    ("anchor_slip", "law"): _Law(_grip, _uniform(0.7, 0.97)),
    ("anchor_slip", "falling"): _Law(
        lambda s, k, share, v0: {**_grip(s, k, share), "v0": k.speed * v0},
        _uniform(0.7, 0.97), _uniform(0.02, 0.1),
    ),
    ("sensor_scale", "law"): _Law(lambda s, _, sign: {"e": sign * 0.3 * s}, _SIGN),
    ("sensor_scale", "bent"): _Law(
        lambda s, k, sign: {"e": sign * 0.3 * s, "L": k.travel}, _SIGN
    ),
    ("sensor_drift", "law"): _Law(
        lambda s, k, sign: {"b": sign * s * k.travel / k.duration}, _SIGN
    ),
    ("sensor_drift", "levelling"): _Law(
        lambda s, k, sign, time: {
            "b": sign * s * k.travel / (k.duration * time), "T": k.duration * time
        },
        _SIGN, _uniform(0.2, 0.6),
    ),
    ("sensor_delay", "law"): _Law(lambda s, _: {"T": 0.2 * s}),
    ("sensor_delay", "filter"): _Law(lambda s, _: {"T": 0.2 * max(s, 1e-4)}),
}  # fmt: skip

_BACKGROUNDS = {
    ("coloured_push", "outside"): _OUTSIDE["coloured_push", "outside"],
    ("slope_error", "uneven"): _Law(
        lambda s, k, length: {"d_alpha_deg": 0.12 * s, "a": 100.0, "L": k.travel * length},
        _log_uniform(0.3, 2.0),
    ),
    ("friction_drift", "linear"): _FRICTION["friction_drift", "linear"],
}
"""A track that is uneven about its nominal slope, and friction that warms up, beside the push."""

LAWS = {**_DRIVE, **_FRICTION, **_OUTSIDE, **_MASS_SLOPE_SENSORS}
"""Laws by cause and functional form; which law a seed draws follows from their order."""

ALL_LAWS = {**LAWS, **_KEPT_OUT}
"""Those of the strata, too."""

OUTSIDE = tuple(name for name, form in LAWS if form == "outside")
"""Disturbances that are no effect of the list."""

KEPT_OUT = tuple(name for name, _ in _KEPT_OUT)
"""Further ones, which cases of the mixture never have: no threshold was ever set on them."""


CAUSES = tuple(dict.fromkeys(name for name, form in LAWS if form != "outside"))
"""Effects of the list."""


def draw_cause(rng: Generator, scale: Scale, name: str, form: str) -> Cause:
    """Draw what of a law does not depend on its strength."""
    law = ALL_LAWS[name, form]
    return _drawn(rng, scale, name, form, law)


def draw_background(rng: Generator, scale: Scale) -> Cause:
    """Draw a disturbance that leaves a rest beside an effect."""
    names = list(_BACKGROUNDS)
    name, form = names[int(rng.integers(len(names)))]
    return _drawn(rng, scale, name, form, _BACKGROUNDS[name, form])


def _drawn(rng: Generator, scale: Scale, name: str, form: str, law: _Law) -> Cause:
    drawn = [draw(rng) for draw in law.draws]
    return Cause(name, form, partial(_at, law, scale, drawn))


def _at(law: _Law, scale: Scale, drawn: list[float], strength: float) -> Parameters:
    return law.parameters(strength, scale, *drawn)
