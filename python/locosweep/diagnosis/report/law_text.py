"""A law that a model lacks, as a report says it: units, a formula, a curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.report.units import WIDE, rotary_unit, rounded, scale, sized
from locosweep.diagnosis.select.shape import KINDS, Axis

if TYPE_CHECKING:
    from collections.abc import Callable

    from locosweep.diagnosis.select.force_law import ForceLaw
    from locosweep.diagnosis.select.law_forms import Found

_HALF_HEIGHT = 2.0 * float(np.sqrt(2.0 * np.log(2.0)))
"""Width of a bump at half its height, in that of its formula."""


def row_of(law: ForceLaw, *, rotary: bool) -> dict[str, Any]:
    """Return what a report says of a law: formula, share and curve.

    Of a law that is odd (friction) the values are what resists the motion; of others the force
    along x, or the error of the reading.
    """
    along, unit, _ = _units(law, rotary=rotary)
    return {
        "formula": formula_of(law, rotary=rotary),
        "share": law.share,
        "curve": {
            "at": law.at.tolist(),
            "at_unit": along,
            "value": law.size.tolist(),
            "std": law.deviation.tolist(),
            "by_formula": None if law.found is None else law.found.at(law.at).tolist(),
            "unit": unit,
        },
    }


def formula_of(law: ForceLaw, *, rotary: bool) -> str | None:
    """Return the formula of a law as text, sizes with their 95 % interval; None without one."""
    if law.found is None:
        return None
    along, unit, per = _units(law, rotary=rotary)

    first, spread = _leading(law.found)
    words = law.found.form.words.format(
        *(_Number(value, lambda at: sized(at, along)) for value in _ordered(law.found)),
        a=_spread(first, spread, unit),
        b=_spread(first, spread, per),
        symbol=_axis(law).symbol,
        end=sized(float(np.abs(law.at).max()), along),
    )
    if law.found.constant:
        beside = float(law.found.sizes[-1]), float(law.found.deviations[-1])
        words += f", beside {_spread(*beside, unit)}"
    return words


def _axis(law: ForceLaw) -> Axis:
    axis = KINDS[law.variable].axis
    if axis is None:
        raise ValueError(f"no law of {law.variable} is drawn")
    return axis


def _units(law: ForceLaw, *, rotary: bool) -> tuple[str, str, str]:
    """Return the units of the variable, of the law, and of the law over the variable."""
    axis = _axis(law)
    along, unit, per = (rotary_unit(u) if rotary else u for u in (axis.unit, axis.of, axis.per))
    return along, unit, per


def _spread(value: float, deviation: float, unit: str) -> str:
    """Return a size with its 95 % interval in a unit that reads well."""
    factor, small = scale(abs(value), unit)
    half = WIDE * factor * deviation
    if half <= 0.0:
        return f"{factor * value:.3g} {small}".removesuffix(" 1")
    return f"({rounded(factor * value, half)} ± {half:.2g}) {small}".removesuffix(" 1")


def _leading(found: Found) -> tuple[float, float]:
    """Return the size that a text gives, and its deviation: of a wave its amplitude."""
    own = found.sizes[: found.sizes.size - found.constant]
    if own.size == 1:
        return float(own[0]), float(found.deviations[0])
    return float(np.hypot(*own)), float(found.deviations[: own.size].max())


def _ordered(found: Found) -> list[float]:
    ends = found.form.grids == ("end", "end")
    return sorted(found.shape) if ends else list(found.shape)


@dataclass(frozen=True)
class _Number:
    """A number of a shape, as a text asks for it."""

    value: float
    at: Callable[[float], str]

    def __format__(self, spec: str) -> str:
        if spec == "plain":
            return f"{self.value:g}"
        return self.at(self.value * (_HALF_HEIGHT if spec == "wide" else 1.0))
