"""Laws of friction, with a strength."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.validation.law_table import lately, law, sign, slowly, spot
from locosweep.validation.rigs import log_uniform

if TYPE_CHECKING:
    from numpy.random import Generator

    from locosweep.validation.law_table import Scale, Strength

__all__: list[str] = []


def _stribeck(k: Scale, rng: Generator) -> tuple[Strength, Generator]:
    v_s = k.speed * log_uniform(rng, 0.03, 0.4)
    return (lambda s: {"F_s": k.level * (1.0 + s), "v_s": v_s}), rng


def _sides(k: Scale, rng: Generator) -> Strength:
    share = rng.uniform(-1.0, 0.5)
    way = sign(rng)

    def at(s: float) -> dict[str, float]:
        levels = [1.0 + 0.9 * way * s, 1.0 + 0.9 * way * s * share]
        return {"F_c_forward": k.level * levels[0], "F_c_backward": k.level * levels[1]}

    return at


@law("viscous_friction")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"c": 3.0 * s * k.level / k.speed}


@law("viscous_friction", "power")
def _(k: Scale, rng: Generator) -> Strength:
    n = float(rng.choice([0.7, 1.25]))
    return lambda s: {"c": 3.0 * s * k.level / k.speed, "n": n, "v0": 0.5 * k.speed}


@law("quadratic_drag")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"c2": 4.0 * s * k.level / k.speed**2}


@law("quadratic_drag", "power")
def _(k: Scale, rng: Generator) -> Strength:
    n = float(rng.choice([1.5, 2.5]))
    return lambda s: {"c2": 4.0 * s * k.level / k.speed**2, "n": n, "v0": 0.5 * k.speed}


@law("stribeck_friction")
def _(k: Scale, rng: Generator) -> Strength:
    at, rng = _stribeck(k, rng)
    delta = float(rng.choice([0.7, 1.0, 1.5, 2.0]))
    return lambda s: {**at(s), "delta": delta}


@law("stribeck_friction", "rational")
def _(k: Scale, rng: Generator) -> Strength:
    return _stribeck(k, rng)[0]


@law("stribeck_friction", "ramp")
def _(k: Scale, rng: Generator) -> Strength:
    return _stribeck(k, rng)[0]


@law("presliding_compliance")
def _(k: Scale, rng: Generator) -> Strength:
    zeta = rng.uniform(0.3, 1.0)

    def at(s: float) -> dict[str, float]:
        stiffness = k.level / (0.3 * max(s, 1e-4) * k.travel)
        return {"sigma0": stiffness, "sigma1": 2.0 * zeta * float(np.sqrt(stiffness * k.mass))}

    return at


@law("presliding_compliance", "dahl")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"sigma0": k.level / (0.3 * max(s, 1e-4) * k.travel)}


@law("direction_dependent_friction")
def _(k: Scale, rng: Generator) -> Strength:
    return _sides(k, rng)


@law("direction_dependent_friction", "fading")
def _(k: Scale, rng: Generator) -> Strength:
    at, v0 = _sides(k, rng), k.speed * rng.uniform(0.03, 0.15)
    return lambda s: {**at(s), "v0": v0}


@law("position_dependent_friction")
def _(k: Scale, rng: Generator) -> Strength:
    length, phase = k.travel * log_uniform(rng, 0.3, 2.5), rng.uniform(0.0, 2 * np.pi)
    return lambda s: {"a": min(0.95, s), "L": length, "p": phase}


@law("position_dependent_friction", "bump")
def _(k: Scale, rng: Generator) -> Strength:
    place, way = spot(k, rng, (0.06, 0.3)), sign(rng)
    return lambda s: {"a": way * 0.9 * s, **place}


@law("position_dependent_friction", "step")
def _(k: Scale, rng: Generator) -> Strength:
    place, way = spot(k, rng, (0.01, 0.03)), sign(rng)
    return lambda s: {"a": way * 0.9 * s, **place}


@law("load_dependent_friction")
def _(_k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"mu_l": 0.5 * s}


@law("load_dependent_friction", "square")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"mu_l": 0.5 * s, "F0": k.force}


@law("friction_drift")
def _(k: Scale, rng: Generator) -> Strength:
    time, way = slowly(k, rng), sign(rng)
    return lambda s: {"a": way * 0.9 * s, "T": time}


@law("friction_drift", "linear")
def _(k: Scale, rng: Generator) -> Strength:
    way = sign(rng)
    return lambda s: {"a": way * 0.9 * s, "T": k.duration}


@law("friction_drift", "late")
def _(k: Scale, rng: Generator) -> Strength:
    late, way = lately(k, rng), sign(rng)
    return lambda s: {"a": way * 0.9 * s, **late}


@law("lubricant_buildup")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"k_b": 6.0 * s * k.level / k.travel}


@law("lubricant_buildup", "levelling")
def _(k: Scale, rng: Generator) -> Strength:
    s0 = k.travel * rng.uniform(0.1, 0.4)
    return lambda s: {"k_b": 6.0 * s * k.level / k.travel, "s0": s0}


@law("coulomb_error")
def _(k: Scale, rng: Generator) -> Strength:
    way = sign(rng)
    return lambda s: {"d_mu": way * 0.5 * s * k.mu}


@law("coulomb_error", "force")
def _(k: Scale, rng: Generator) -> Strength:
    way = sign(rng)
    return lambda s: {"d_force": way * 0.5 * s * k.level}


@law("coulomb_error", "rate")
def _(k: Scale, rng: Generator) -> Strength:
    way, v0 = sign(rng), 0.1 * k.speed
    return lambda s: {"d_force": way * 0.4 * s * k.level, "a": 0.15, "v0": v0}
