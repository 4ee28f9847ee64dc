"""Laws of mass, slope, anchors and sensors, with a strength."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.validation.law_table import law, sign

if TYPE_CHECKING:
    from numpy.random import Generator

    from locosweep.validation.law_table import Scale, Strength

__all__: list[str] = []


def _grip(k: Scale, rng: Generator) -> Strength:
    share = rng.uniform(0.7, 0.97)

    def at(s: float) -> dict[str, float]:
        mu = k.force * (1.0 - 0.7 * s) / k.grip
        return {"mu_static": mu, "mu_coulomb": share * mu}

    return at


@law("slope_error")
def _(_k: Scale, rng: Generator) -> Strength:
    way = sign(rng)
    return lambda s: {"d_alpha_deg": way * 12.0 * s}


@law("slope_error", "uneven")
def _(k: Scale, rng: Generator) -> Strength:
    way, length = sign(rng), k.travel * rng.uniform(0.5, 2.0)
    return lambda s: {"d_alpha_deg": way * 12.0 * s, "a": 0.3, "L": length}


@law("payload_mass")
def _(k: Scale, rng: Generator) -> Strength:
    way = sign(rng)
    return lambda s: {"dm": way * 0.5 * s * k.mass}


@law("payload_mass", "swinging")
def _(k: Scale, rng: Generator) -> Strength:
    shape = {"f": rng.uniform(5.0, 15.0), "zeta": rng.uniform(0.1, 0.4)}
    return lambda s: {"dm": 0.5 * s * k.mass, **shape}


@law("anchor_slip")
def _(k: Scale, rng: Generator) -> Strength:
    return _grip(k, rng)


@law("anchor_slip", "falling")
def _(k: Scale, rng: Generator) -> Strength:
    at, v0 = _grip(k, rng), k.speed * rng.uniform(0.02, 0.1)
    return lambda s: {**at(s), "v0": v0}


@law("sensor_scale")
def _(_k: Scale, rng: Generator) -> Strength:
    way = sign(rng)
    return lambda s: {"e": way * 0.3 * s}


@law("sensor_scale", "bent")
def _(k: Scale, rng: Generator) -> Strength:
    way = sign(rng)
    return lambda s: {"e": way * 0.3 * s, "L": k.travel}


@law("sensor_drift")
def _(k: Scale, rng: Generator) -> Strength:
    way = sign(rng)
    return lambda s: {"b": way * s * k.travel / k.duration}


@law("sensor_drift", "levelling")
def _(k: Scale, rng: Generator) -> Strength:
    way, time = sign(rng), k.duration * rng.uniform(0.2, 0.6)
    return lambda s: {"b": way * s * k.travel / time, "T": time}


@law("sensor_delay")
def _(_k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"T": 0.2 * s}


@law("sensor_delay", "filter")
def _(_k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"T": 0.2 * max(s, 1e-4)}
