"""Units of columns by Pint, held against what a column measures."""

from __future__ import annotations

import functools
import re
from typing import TYPE_CHECKING, Any

from locosweep.errors import InputError
from locosweep.registry import unknown

if TYPE_CHECKING:
    from collections.abc import Sequence

_USUAL = (
    "m", "cm", "mm", "um", "inch", "s", "ms", "us", "N", "mN", "kN", "N m", "rad", "deg", "m/s",
    "cm/s", "mm/s", "rad/s", "deg/s", "W", "mW", "1", "percent",
)  # fmt: skip
"""Units that a wrong name is compared with."""
_SPELT = {"Nm": "N m", "Nmm": "N mm", "mNm": "mN m", "kNm": "kN m", "Ncm": "N cm",
          "%": "percent", "1": "dimensionless", "-": "dimensionless",
          "sec": "s", "pct": "percent", "amps": "ampere"}  # fmt: skip
"""Ways of writing that Pint reads as something else or not at all."""
_FORM = re.compile(r"(?:[A-Za-zµμ°Ω]+(?:[\^*]{0,2}-?\d)?[ */·]{0,3}(?![ */·])){1,6}")
"""Names with exponents of one digit: Pint computes what else stands there."""
_LONGEST = 24
"""Characters of a unit, at most: 'kilogram meter / second' has 23."""

_BRACKETS = re.compile(r"(.*?)\s*[\[(]\s*([^\[\]()]+?)\s*[\])]")

DRIVES = ("N", "N m", "V", "A", "Pa", "1")
"""What a drive column may count in; the gain is the force per unit of it."""


@functools.lru_cache(maxsize=1)
def _registry() -> Any:
    # 0.6 s of processor time: only units that differ from SI pay for it.
    import pint

    return pint.UnitRegistry()


@functools.lru_cache(maxsize=256)
def _base(unit: str) -> tuple[float, str] | None:
    """Return factor and SI base units, radians among them; None for what is no unit."""
    text = _SPELT.get(unit, unit)
    if len(text) > _LONGEST or not _FORM.fullmatch(text):
        return None
    registry = _registry()
    import pint

    try:
        scale, base = registry.get_base_units(registry.parse_units(text))
    # Those of Python as well, for instance where "m-1" is read as a subtraction.
    except (pint.PintError, AssertionError, TypeError, ValueError):
        return None
    return float(scale), str(base)


def is_unit(text: str) -> bool:
    """Return whether a text is a unit, of whatever kind.

    Examples
    --------
    >>> from locosweep.files.units import is_unit
    >>> is_unit("mm/s"), is_unit("left"), is_unit("9**9**9")
    (True, False, False)
    """
    return text in _USUAL or _base(text) is not None


def bracketed(name: str) -> tuple[str, str]:
    """Return a name without the unit in brackets at its end, and that unit; empty without one.

    Examples
    --------
    >>> from locosweep.files.units import bracketed
    >>> bracketed("x [mm]"), bracketed("x (left)")
    (('x', 'mm'), ('x (left)', ''))
    """
    found = _BRACKETS.fullmatch(name)
    return (found[1], found[2]) if found and is_unit(found[2]) else (name, "")


def alike(unit: str, other: str) -> bool:
    """Return whether two units measure the same.

    Examples
    --------
    >>> from locosweep.files.units import alike
    >>> alike("mm", "inch"), alike("V", "N")
    (True, False)
    """
    if unit == other:
        return True
    one, two = _base(unit), _base(other)
    return one is not None and two is not None and one[1] == two[1]


def factor(column: str, unit: str, allowed: Sequence[str]) -> float:
    """Return by what a column is multiplied to be in one of the `allowed` units.

    Raises
    ------
    InputError
        No unit, or one that measures something else than the column.

    Examples
    --------
    >>> from locosweep.files.units import factor
    >>> factor("x", "mm", ["m"])
    0.001
    >>> factor("slope_deg", "deg", ["deg"])
    1.0
    """
    if unit in allowed:
        return 1.0
    found = _base(unit)
    if found is None:
        raise InputError(f"unit of {column}: {unknown('unit', unit, _USUAL)}")
    for one in allowed:
        scale, kind = _base(one) or (1.0, "")
        if kind == found[1]:
            return found[0] / scale
    like = [one for one in _USUAL if one not in allowed and _fits(one, allowed)]
    others = f", for instance {', '.join(like[:3])}" if like else ""
    raise InputError(
        f"unit of {column}: {unit} measures something else, "
        f"allowed is a unit of {' or '.join(allowed)}{others}"
    )


def _fits(unit: str, allowed: Sequence[str]) -> bool:
    kinds = {found[1] for one in allowed if (found := _base(one))}
    one = _base(unit)
    return one is not None and one[1] in kinds
