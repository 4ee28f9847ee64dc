"""Every effect as a family of one strength, with the shapes that it may take on a rig."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from locosweep.simulation.replay import effects

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Values = dict[str, float]

__all__ = ["Family", "Rig", "Shape", "families"]

_DAMPED = 0.3
_LIGHTEST = 1e-2
"""Smallest mass on the drive's side over that of the head: a lighter one is stiff."""


@dataclass(frozen=True)
class Rig:
    """Sizes of a rig and of its planned motion, SI, above zero.

    `level` is the Coulomb level, `force` the largest drive force, `weight` and
    `grip` the weight of head and body on the ground, `viscous` the nominal
    coefficient; `travel`, `speed` and `duration` are those of the nominal motion.
    """

    mass: float
    level: float
    force: float
    weight: float
    grip: float
    speed: float
    travel: float
    duration: float
    viscous: float = 0.0


@dataclass(frozen=True)
class Shape:
    """A further parameter of a family: where fits begin, and its bounds.

    With `log` the fit steps its logarithm; `step` is that of a finite difference.
    """

    name: str
    starts: tuple[float, ...]
    low: float
    high: float
    log: bool = True
    step: float = 0.02

    def coordinate(self, value: float) -> float:
        """Return what the fit steps."""
        return float(np.log(value)) if self.log else value

    def value(self, coordinate: float) -> float:
        """Return the parameter, within its bounds."""
        if not self.log:
            return float(np.clip(coordinate, self.low, self.high))
        return float(np.exp(np.clip(coordinate, np.log(self.low), np.log(self.high))))


@dataclass(frozen=True)
class Family:
    """One effect: parameters from a strength and shapes.

    A strength of 0 is the nominal model, one about 1 as large as the rig allows.
    `low` is 0 where the effect has one sign only; below `least` an integrator
    resolves no more than the nominal model.
    """

    name: str
    make: Callable[[float, Mapping[str, float]], Values]
    low: float
    high: float
    shapes: tuple[Shape, ...] = ()
    least: float = 1e-9

    @property
    def signs(self) -> tuple[float, ...]:
        """Signs that the strength may have."""
        return (1.0, -1.0) if self.low < 0.0 else (1.0,)

    def starts(self) -> list[tuple[float, ...]]:
        """Return every combination of the shapes' first values."""
        return list(product(*(shape.starts for shape in self.shapes)))

    def parameters(self, theta: Floats) -> Values:
        """Return the effect's parameters at the coordinates of a fit, strength first."""
        shapes = {s.name: s.value(c) for s, c in zip(self.shapes, theta[1:], strict=True)}
        return self.make(float(np.clip(theta[0], self.low, self.high)), shapes)


def _scaled(key: str, size: float) -> Callable[[float, Mapping[str, float]], Values]:
    return lambda u, _: {key: u * size}


def families(rig: Rig, *, force_level: bool = False) -> dict[str, Family]:
    """Return the families of all effects, by name.

    Parameters
    ----------
    rig : Rig
        What the strengths and the shapes are measured by.
    force_level : bool
        Whether the nominal file gives its Coulomb level as a force.
    """
    r = rig
    drag = r.force / r.speed
    slowly = Shape("T", (0.1 * r.duration, 0.6 * r.duration, 4.0 * r.duration),
                   1e-2 * r.duration, 20.0 * r.duration)  # fmt: skip
    damping = Shape("zeta", (_DAMPED,), 1e-3, 3.0)
    # Less than no viscosity at all would be a motor.
    least = -min(1.0, r.viscous / drag)
    degree = float(np.degrees(min(1.0, r.level / r.weight)))
    level = "d_force" if force_level else "d_mu"

    def stribeck(u: float, s: Mapping[str, float]) -> Values:
        return {"F_s": r.level * (1.0 + u), "v_s": s["v_s"], "delta": s["delta"]}

    def presliding(u: float, s: Mapping[str, float]) -> Values:
        stiffness = r.level / (max(u, 1e-12) * r.travel)
        return {"sigma0": stiffness, "sigma1": 2.0 * s["zeta"] * float(np.sqrt(stiffness * r.mass))}

    def direction(u: float, s: Mapping[str, float]) -> Values:
        common = 1.0 + s["common"]
        return {"F_c_forward": max(0.0, r.level * (common + u)),
                "F_c_backward": max(0.0, r.level * (common - u))}  # fmt: skip

    def drift(u: float, s: Mapping[str, float]) -> Values:
        return {"a": u, "T": s["T"]}

    def slip(u: float, s: Mapping[str, float]) -> Values:
        grip = r.force / r.grip * (1.0 - u)
        return {"mu_static": grip, "mu_coulomb": grip * s["ratio"]}

    # Play and spring show by the mass behind them: without it they change nothing.
    def backlash(u: float, s: Mapping[str, float]) -> Values:
        return {"b": s["b"], "m_d": max(u, _LIGHTEST) * r.mass}

    def compliance(u: float, s: Mapping[str, float]) -> Values:
        side = max(u, _LIGHTEST) * r.mass
        return {"k": s["k"], "d": 2.0 * s["zeta"] * float(np.sqrt(s["k"] * side)), "m_d": side}

    gap = Shape("b", tuple(r.travel * f for f in (1e-3, 2e-2)), 1e-6 * r.travel, r.travel)
    spring = Shape("k", tuple(r.mass * (2.0 * np.pi * f) ** 2 for f in (4.0, 15.0)),
                   r.mass, r.mass * 1e5)  # fmt: skip
    ripple = (
        Shape("L", tuple(r.travel * f for f in (0.08, 0.2, 0.5, 1.2)), 0.02 * r.travel,
              10.0 * r.travel),
        Shape("p", (0.0, 1.57, 3.14, 4.71), -100.0, 100.0, log=False),
    )  # fmt: skip
    speeds = Shape("v_s", tuple(r.speed * f for f in (0.01, 0.1, 0.4)), 1e-4 * r.speed,
                   10.0 * r.speed)  # fmt: skip
    found = [
        Family("viscous_friction", _scaled("c", drag), least, 10.0),
        Family("quadratic_drag", _scaled("c2", drag / r.speed), 0.0, 10.0),
        Family("stribeck_friction", stribeck, 0.0, 10.0,
               (speeds, Shape("delta", (1.0,), 0.5, 2.5))),
        Family("presliding_compliance", presliding, 0.0, 10.0, (damping,), 1e-9),
        Family("direction_dependent_friction", direction, -1.0, 1.0,
               (Shape("common", (0.0,), -1.0, 10.0, log=False, step=1e-3),)),
        Family("position_dependent_friction", lambda u, s: {"a": u, **s}, 0.0, 1.0, ripple),
        Family("load_dependent_friction", _scaled("mu_l", 1.0), -0.9, 10.0),
        Family("friction_drift", drift, -1.0, 10.0, (slowly,)),
        Family("lubricant_buildup", _scaled("k_b", r.force / r.travel), -1.0, 10.0),
        Family("drive_saturation", lambda u, _: {"F_max": r.force * (1.0 - u)}, 0.0, 1.0),
        Family("drive_lag", _scaled("T", r.duration), 0.0, 1.0),
        Family("drive_delay", _scaled("T", r.duration), 0.0, 0.3),
        Family("drive_deadzone", _scaled("d", r.force), 0.0, 1.0),
        Family("drive_gain_error", _scaled("e", 1.0), -1.0, 10.0),
        Family("back_emf", _scaled("k_e", drag), least, 10.0),
        Family("supply_sag", drift, -1.0, 1.0, (slowly,)),
        Family("transmission_backlash", backlash, 0.0, 3.0, (gap,), _LIGHTEST),
        Family("transmission_compliance", compliance, 0.0, 3.0, (spring, damping),
               _LIGHTEST),
        Family("slope_error", _scaled("d_alpha_deg", degree), -1.0, 1.0),
        Family("payload_mass", _scaled("dm", r.mass), -0.95, 10.0),
        Family("coulomb_error", _scaled(level, r.level if force_level else r.level / r.weight),
               -1.0, 10.0),
        Family("anchor_slip", slip, 0.0, 0.99, (Shape("ratio", (0.9,), 0.1, 1.0),)),
        Family("sensor_scale", _scaled("e", 1.0), -0.95, 10.0),
        Family("sensor_drift", _scaled("b", r.travel / r.duration), -10.0, 10.0),
        Family("sensor_delay", _scaled("T", r.duration), 0.0, 0.3),
    ]  # fmt: skip
    by_name = {family.name: family for family in found}
    return {record.name: by_name[record.name] for record in effects()}
