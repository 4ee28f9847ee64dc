"""Laws of drive and transmission, with a strength."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.validation.law_table import lately, law, sign, slowly
from locosweep.validation.rigs import log_uniform

if TYPE_CHECKING:
    from numpy.random import Generator

    from locosweep.validation.law_table import Scale, Strength

__all__: list[str] = []


def _side_mass(k: Scale, share: float, s: float) -> float:
    # A lighter drive side with a weaker effect: at 0 nothing is left of it.
    return k.mass * share * float(np.clip(s / 0.3, 0.02, 1.0))


def _play(k: Scale, s: float) -> float:
    # Less weak than the mass behind it: play that nobody can see is none.
    return 0.15 * float(np.sqrt(s)) * k.travel


def _spring(k: Scale, rng: Generator) -> Strength:
    share, zeta = rng.uniform(0.05, 0.3), log_uniform(rng, 0.08, 0.5)

    def at(s: float) -> dict[str, float]:
        side = _side_mass(k, share, s)
        stiff = k.force / (0.3 * max(s, 1e-3) * k.travel)
        damping = 2.0 * zeta * float(np.sqrt(stiff * side * k.mass / (side + k.mass)))
        return {"k": stiff, "d": damping, "m_d": side}

    return at


@law("drive_saturation")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"F_max": k.force * (1.0 - 0.7 * s)}


@law("drive_saturation", "knee")
def _(k: Scale, rng: Generator) -> Strength:
    n = float(rng.choice([6.0, 10.0]))
    return lambda s: {"F_max": k.force * 0.7 / s, "n": n}


@law("drive_saturation", "tanh")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"F_max": k.force * 0.6 / s}


@law("drive_lag")
def _(_k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"T": 0.3 * max(s, 1e-4)}


@law("drive_lag", "asymmetric")
def _(_k: Scale, rng: Generator) -> Strength:
    other = rng.uniform(0.3, 0.6) ** sign(rng)
    return lambda s: {"T_rise": 0.3 * max(s, 1e-4), "T_fall": 0.3 * max(s, 1e-4) * other}


@law("drive_lag", "second_order")
def _(_k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"T": 0.3 * max(s, 1e-4)}


@law("drive_delay")
def _(_k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"T": 0.2 * s}


@law("drive_delay", "polled")
def _(_k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"T": 0.4 * s}


@law("drive_deadzone")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"d": 0.6 * s * k.level}


@law("drive_deadzone", "hysteresis")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"d_open": 1.4 * s * k.level, "d_close": 0.6 * s * k.level}


@law("drive_deadzone", "soft")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"d": 0.6 * s * k.level}


@law("drive_gain_error")
def _(_k: Scale, rng: Generator) -> Strength:
    way = sign(rng)
    return lambda s: {"e": way * 0.5 * s}


@law("drive_gain_error", "asymmetric")
def _(_k: Scale, rng: Generator) -> Strength:
    way, other = sign(rng), rng.uniform(0.6, 0.9) ** sign(rng)
    return lambda s: {"e_forward": way * 0.4 * s, "e_backward": way * 0.4 * s * other}


@law("back_emf")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"k_e": 3.0 * s * k.level / k.speed}


@law("back_emf", "saturating")
def _(k: Scale, rng: Generator) -> Strength:
    v0 = k.speed * rng.uniform(0.5, 1.5)
    return lambda s: {"k_e": 3.0 * s * k.level / k.speed, "v0": v0}


@law("supply_sag")
def _(k: Scale, rng: Generator) -> Strength:
    time = slowly(k, rng)
    return lambda s: {"a": 0.7 * s, "T": time}


@law("supply_sag", "linear")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"a": 0.7 * s, "T": k.duration}


@law("supply_sag", "late")
def _(k: Scale, rng: Generator) -> Strength:
    late = lately(k, rng)
    return lambda s: {"a": 0.7 * s, **late}


@law("transmission_backlash")
def _(k: Scale, rng: Generator) -> Strength:
    share = rng.uniform(0.05, 0.3)
    return lambda s: {"b": _play(k, s), "m_d": _side_mass(k, share, s)}


@law("transmission_backlash", "soft")
def _(k: Scale, rng: Generator) -> Strength:
    share, stiff = rng.uniform(0.05, 0.3), k.mass * log_uniform(rng, 3e3, 1e4)

    def at(s: float) -> dict[str, float]:
        side = _side_mass(k, share, s)
        damping = 0.8 * float(np.sqrt(stiff * side * k.mass / (side + k.mass)))
        return {"b": _play(k, s), "m_d": side, "k": stiff, "d": damping}

    return at


@law("transmission_compliance")
def _(k: Scale, rng: Generator) -> Strength:
    return _spring(k, rng)


@law("transmission_compliance", "hardening")
def _(k: Scale, rng: Generator) -> Strength:
    at = _spring(k, rng)
    return lambda s: {**at(s), "s0": 0.8 * k.force / at(s)["k"]}
