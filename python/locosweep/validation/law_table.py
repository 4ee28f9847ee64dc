"""Laws of causes with a strength: from nothing at 0 to a strong effect at 1.

Every cause has the law of its name and at least one other law of the same cause;
`OUTSIDE` are disturbances that no name stands for. The laws themselves are those of
the reality; here stands only how their parameters follow from a rig's scale.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from locosweep.validation.rigs import log_uniform

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.random import Generator

    Strength = Callable[[float], dict[str, float]]
    Law = Callable[["Scale", Generator], Strength]

__all__ = ["LAWS", "Cause", "Scale", "Strength", "lately", "law", "sign", "slowly", "spot"]


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


def law(name: str, form: str = "law") -> Callable[[Law], Law]:
    """Put a function into the book: scale of a rig and random numbers in, strength out."""

    def keep(law: Law) -> Law:
        LAWS[name, form] = law
        return law

    return keep


def sign(rng: Generator) -> float:
    """Draw a sign."""
    return float(rng.choice([-1.0, 1.0]))


def slowly(k: Scale, rng: Generator) -> float:
    """Draw the time of a change that levels out."""
    return k.duration * log_uniform(rng, 0.15, 1.5)


def lately(k: Scale, rng: Generator) -> dict[str, float]:
    """Draw when a late change happens, and how suddenly."""
    return {"T": k.duration * rng.uniform(0.3, 0.7), "w": k.duration * rng.uniform(0.03, 0.1)}


def spot(k: Scale, rng: Generator, widths: tuple[float, float]) -> dict[str, float]:
    """Draw a place that the head comes by, and a width as a share of its travel."""
    at = k.low + (k.high - k.low) * rng.uniform(0.2, 0.8)
    return {"x0": at, "w": k.travel * rng.uniform(*widths)}
