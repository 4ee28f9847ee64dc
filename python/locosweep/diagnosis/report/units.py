"""Numbers and units as a report writes them: of rotary rigs, with prefixes, rounded."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    pass

_TURNING = {"N": "N m", "kg": "kg m^2", "m": "rad"}
"""Units of a rig that turns, by those of one that slides: torque, inertia, angle."""
_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_WHOLE = ("kg", "deg")
"""Units that take no further prefix."""
WIDE = 1.96
"""Standard deviations to either end of a 95 % interval."""
_MOST = 12
"""Digits that an interval may ask for."""


def rotary_unit(unit: str) -> str:
    """Return the unit of a parameter on a rig that turns, by that of the registry.

    Examples
    --------
    >>> from locosweep.diagnosis.report.units import rotary_unit
    >>> rotary_unit("N s/m"), rotary_unit("kg"), rotary_unit("1")
    ('N m s/rad', 'kg m^2', '1')
    """
    if "N m" in unit:
        return unit
    return re.sub(r"\b(N|kg|m)\b", lambda found: _TURNING[found[1]], unit)


def scale(largest: float, unit: str) -> tuple[float, str]:
    """Return factor and unit in which values up to `largest` of a unit read well.

    Units that begin with a power or a prefix, before which another would be read otherwise, stay.

    Examples
    --------
    >>> from locosweep.diagnosis.report.units import scale
    >>> scale(0.02, "m"), scale(0.3, "kg")
    ((1000.0, 'mm'), (1.0, 'kg'))
    """
    first = re.split("[ /]", unit)[0]
    if not math.isfinite(largest) or largest == 0.0 or first in _WHOLE or not first.isalpha():
        return 1.0, unit
    # 0.3 m stays 0.3 m; 0.03 m becomes 30 mm.
    for size, prefix in _PREFIXES:
        if largest >= 0.1 * size:
            return 1.0 / size, prefix + unit
    return 1.0 / _PREFIXES[-1][0], _PREFIXES[-1][1] + unit


def sized(value: float, unit: str, digits: int = 2) -> str:
    """Return a number for a sentence in a unit that reads well.

    Examples
    --------
    >>> from locosweep.diagnosis.report.units import sized
    >>> sized(5.04e-6, "m"), sized(0.6067, "rad")
    ('5 µm', '0.61 rad')
    """
    factor, small = scale(abs(value), unit)
    return f"{factor * value:.{digits}g} {small}".removesuffix(" 1")


def rounded(value: float, half: float | None, digits: int = 3) -> str:
    """Return a number with no more digits than half the width of its interval lets stand.

    Without an interval, with some digits.

    Examples
    --------
    >>> from locosweep.diagnosis.report.units import rounded
    >>> rounded(0.8499980573, 4.9e-6), rounded(0.0231, 0.004), rounded(5.99996, 1.4e-4)
    ('0.849998', '0.023', '5.99996')
    >>> rounded(0.8499980573, None)
    '0.85'
    """
    if not value or half is None or not math.isfinite(half) or half <= 0.0:
        return f"{value:.{digits}g}"
    place = math.floor(math.log10(half))
    # A half width of 1.4 digits more is two steps of the last digit.
    decimals = -place + (half / 10.0**place < 2.0)
    before = math.floor(math.log10(abs(value))) + 1
    if abs(before) > 4 or before + decimals > _MOST:
        return f"{value:.{min(max(before + decimals, 1), _MOST)}g}"
    return f"{value:.{max(decimals, 0)}f}"
