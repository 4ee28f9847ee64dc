"""Disturbances that no effect of the list stands for, with a strength."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.validation.law_table import law, sign, spot
from locosweep.validation.rigs import log_uniform

if TYPE_CHECKING:
    from numpy.random import Generator

    from locosweep.validation.law_table import Scale, Strength

__all__: list[str] = []


@law("tether", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    slack = k.low + (k.high - k.low) * rng.uniform(0.0, 0.4)
    return lambda s: {"k": 5.0 * s * k.level / k.travel, "x0": slack}


@law("periodic_push", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    shape = {"f": log_uniform(rng, 0.7, 6.0), "p": rng.uniform(0.0, 2 * np.pi)}
    return lambda s: {"A": 2.0 * s * k.level, **shape}


@law("coloured_push", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    time = log_uniform(rng, 0.02, 0.5)
    return lambda s: {"A": 2.0 * s * k.level, "T": time}


@law("gusts", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    shape = {"T": k.duration / 6.0, "w": rng.uniform(0.02, 0.1)}
    return lambda s: {"A": 4.0 * s * k.level, **shape}


@law("mass_step", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    way, at = sign(rng), k.duration * rng.uniform(0.3, 0.7)
    return lambda s: {"r": way * 0.6 * s, "t0": at}


@law("magnet", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    place = spot(k, rng, (0.08, 0.3))
    return lambda s: {"A": 4.0 * s * k.level, **place}


@law("vibration", "outside")
def _(_k: Scale, rng: Generator) -> Strength:
    frequency = rng.uniform(5.0, 30.0)
    return lambda s: {"a": 0.9 * s, "f": frequency}


@law("rocking", "outside")
def _(_k: Scale, rng: Generator) -> Strength:
    shape = {"f": log_uniform(rng, 0.3, 1.5), "p": rng.uniform(0.0, 2 * np.pi)}
    return lambda s: {"A_deg": 15.0 * s, **shape}


@law("wall", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    stiff = k.mass * (2 * np.pi * rng.uniform(6.0, 20.0)) ** 2
    damping = 2.0 * rng.uniform(0.05, 0.4) * float(np.sqrt(stiff * k.mass))
    return lambda s: {"x0": k.high - 0.8 * s * (k.high - k.low), "k": stiff, "d": damping}


@law("reading_slips", "outside")
def _(k: Scale, rng: Generator) -> Strength:
    way = sign(rng)
    return lambda s: {"J": way * 0.3 * s * k.travel, "T": k.duration / 2.5}


@law("reading_freezes", "outside")
def _(k: Scale, _rng: Generator) -> Strength:
    return lambda s: {"w": 0.5 * s, "T": k.duration / 4.0}
