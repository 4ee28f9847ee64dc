"""Directions in which every cause can go when it copies another."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from locosweep.validation.experiment import Effect
    from locosweep.validation.law_table import Scale, Strength

__all__ = ["LENGTHS", "Rival", "rivals_of", "waves_of"]

LENGTHS = np.geomspace(0.2, 7.0, 13)
"""Lengths of ripples, from short ones to a slope, in travels."""


@dataclass(frozen=True)
class Rival:
    """A direction in which a rival can go: its effect at a signed strength."""

    cause: str
    group: str
    at: Strength
    signs: tuple[float, ...]
    length: float = 0.0
    """Of a wave along the way."""

    def effect(self, s: float, *, as_force: bool) -> Effect:
        """Return what the reality takes."""
        form = "force" if as_force and self.cause == "coulomb_error" else "law"
        return self.cause, form, self.at(s)

    def allows(self, s: float) -> bool:
        """Whether a strength makes sense: sensors and drives act late, not early."""
        return s >= 0.0 or (len(self.signs) == 2 and not self.cause.endswith("_delay"))


def _wave(s: float, length: float, phase: float) -> dict[str, float]:
    return {"a": float(np.clip(s, -0.95, 0.95)), "L": length, "p": phase}


def waves_of(length: float) -> list[Rival]:
    """Both phases of friction that goes up and down along the way."""
    name = "position_dependent_friction"
    return [
        Rival(
            name,
            f"{name} {length:.9g}",
            partial(_wave, length=length, phase=p),
            (1.0, -1.0),
            length,
        )
        for p in (0.0, 0.5 * np.pi)
    ]


def rivals_of(k: Scale, *, as_force: bool) -> list[Rival]:
    """Laws of all causes over a grid of what is not their strength."""
    both, up = (1.0, -1.0), (1.0,)
    found = []

    def add(cause: str, at: Strength, signs: tuple[float, ...] = both, group: str = "") -> None:
        found.append(Rival(cause, f"{cause}{group}", at, signs))

    per_speed = k.level / k.speed
    add("viscous_friction", lambda s: {"c": s * per_speed})
    add("quadratic_drag", lambda s: {"c2": s * per_speed / k.speed})

    def stribeck(s: float, v_s: float, delta: float) -> dict[str, float]:
        return {"F_s": k.level * max(1.0 + s, 0.05), "v_s": v_s, "delta": delta}

    for share in (0.03, 0.1, 0.35):
        for delta in (1.0, 2.0):
            add(
                "stribeck_friction",
                partial(stribeck, v_s=share * k.speed, delta=delta),
                group=f" {share} {delta}",
            )

    def bristle(s: float, zeta: float) -> dict[str, float]:
        stiff = k.level / (max(s, 1e-4) * k.travel)
        return {"sigma0": stiff, "sigma1": 2.0 * zeta * float(np.sqrt(stiff * k.mass))}

    for zeta in (0.3, 1.0):
        add("presliding_compliance", partial(bristle, zeta=zeta), up, f" {zeta}")

    def one_side(s: float, side: str) -> dict[str, float]:
        levels = {"F_c_forward": k.level, "F_c_backward": k.level}
        return {**levels, side: k.level * max(1.0 + s, 0.0)}

    for way in ("F_c_forward", "F_c_backward"):
        add("direction_dependent_friction", partial(one_side, side=way))

    for share in LENGTHS:
        found += waves_of(float(share) * k.travel)
    add("load_dependent_friction", lambda s: {"mu_l": s})

    def change(s: float, time: float) -> dict[str, float]:
        return {"a": float(np.clip(s, -0.95, 0.95)), "T": time}

    for cause in ("friction_drift", "supply_sag"):
        for share in (0.15, 0.5, 1.5):
            add(cause, partial(change, time=share * k.duration), group=f" {share}")
    add("lubricant_buildup", lambda s: {"k_b": s * k.level / k.travel})
    add("drive_saturation", lambda s: {"F_max": k.force * max(1.0 - s, 0.05)}, up)
    add("drive_lag", lambda s: {"T": max(s, 1e-5)}, up)
    add("drive_delay", lambda s: {"T": s}, both)
    add("drive_deadzone", lambda s: {"d": s * k.level}, up)
    add("drive_gain_error", lambda s: {"e": s})
    add("back_emf", lambda s: {"k_e": s * per_speed})

    def side(s: float, share: float) -> float:
        return k.mass * share * float(np.clip(s / 0.1, 0.02, 1.0))

    def play(s: float, share: float) -> dict[str, float]:
        return {"b": s * k.travel, "m_d": side(s, share)}

    def spring(s: float, share: float) -> dict[str, float]:
        stiff, m_d = k.force / (max(s, 1e-3) * k.travel), side(s, share)
        reduced = m_d * k.mass / (m_d + k.mass)
        return {"k": stiff, "d": 0.4 * float(np.sqrt(stiff * reduced)), "m_d": m_d}

    for share in (0.05, 0.25):
        add("transmission_backlash", partial(play, share=share), up, f" {share}")
        add("transmission_compliance", partial(spring, share=share), up, f" {share}")
    add("slope_error", lambda s: {"d_alpha_deg": float(np.clip(20.0 * s, -60, 60))})
    add("payload_mass", lambda s: {"dm": k.mass * max(s, -0.9)})
    if as_force:
        add("coulomb_error", lambda s: {"d_force": s * k.level})
    else:
        add("coulomb_error", lambda s: {"d_mu": s * k.mu})
    if k.grip > 0.0:

        def grip(s: float) -> dict[str, float]:
            mu = k.force * max(1.0 - s, 0.05) / k.grip
            return {"mu_static": mu, "mu_coulomb": 0.9 * mu}

        add("anchor_slip", grip, up)
    add("sensor_scale", lambda s: {"e": s})
    add("sensor_drift", lambda s: {"b": s * k.travel / k.duration})
    add("sensor_delay", lambda s: {"T": s}, both)
    return found
