"""Units of the columns of a log, settled over all of its files, each with its reason."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import InputError
from locosweep.files import stamps
from locosweep.files.runs import wanted_columns
from locosweep.files.units import alike
from locosweep.intake.guess import numbers_of
from locosweep.intake.names import ANGLES, COUNTED, WORD_UNITS, fits, unit_for, words_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.intake.sheet import Sheet

Reasoned = tuple[str, str]
"""A unit, and why it is that."""

_FAR = 10.0
"""Span of a position in m from which it is in mm: rigs stand in a room, and move by less."""
_TURN = 2.0 * np.pi
"""Span of an angle in rad from which it is in degrees: rotary benches swing, they do not spin."""
_COUNTERS = {"ms": (1.0, 1e3), "us": (1e3, 1e6), "ns": (1e6, np.inf)}
"""Usual steps of times without a unit, by the unit that makes them 1 ms to 1 s: that is what rigs
log at, and the next unit is a factor of a thousand away."""
_PLAIN = "nothing says another: check it"


def settled_units(sheets: Sequence[Sheet], given: Mapping[str, str]) -> list[dict[str, Reasoned]]:
    """Return the unit of each column of numbers of each file and why, by our names.

    What no file says is guessed once over all files. `given` is what the user says, for all.

    Raises
    ------
    InputError
        Positions that may be plain counts, or files whose units differ without saying so.
    """
    units = [_said(sheet, given) for sheet in sheets]
    said = [set(own) for own in units]
    silent = [sheet for sheet, own in zip(sheets, units, strict=True) if "x" not in own]
    position = _position(silent) if silent else ("", "")
    for sheet, own in zip(sheets, units, strict=True):
        own.setdefault("t", _time(sheet))
        own.setdefault("x", position)
        wanted = wanted_columns(rotary=is_angle(own["x"][0]))
        for role in sheet.why:
            if wanted[role] and role not in own:
                own[role] = _like_position(sheet, role, own["x"][0], wanted[role])
    _check_agreement(sheets, units, said)
    return units


def is_angle(unit: str) -> bool:
    """Return whether a unit is one of angles."""
    return fits("x", unit, ["rad"])


def _said(sheet: Sheet, given: Mapping[str, str]) -> dict[str, Reasoned]:
    """Return the units that the user, the file or names give."""
    found = {}
    for role, allowed in wanted_columns().items():
        if role not in sheet.why or not allowed:
            continue
        name = sheet.names[role]
        if role in given:
            found[role] = (given[role], "as you say")
        elif role in sheet.table.units:
            found[role] = (sheet.table.units[role], "as the file states")
        elif unit := unit_for(name, role, allowed):
            found[role] = (unit, "by its name")
        elif role in ("t", "drive"):
            unit = next((WORD_UNITS[word] for word in words_of(name) if word in WORD_UNITS), "")
            if unit and fits(role, unit, allowed):
                found[role] = (unit, "by its name")
    return found


def _time(sheet: Sheet) -> Reasoned:
    """Return the unit of times that nothing names, by their size."""
    column = sheet.table.frame["t"]
    if stamps.are_dates(column) or stamps.is_span(column):
        return "s", "dates" if stamps.are_dates(column) else "spans of time"
    times = numbers_of(column)
    if stamps.is_unix(times):
        return "s", "Unix time"
    if finer := stamps.finer(times):
        return finer, "as only that makes it Unix time"
    steps = np.diff(times[np.isfinite(times)])
    steps = steps[steps > 0.0]
    usual = float(np.median(steps)) if steps.size else 0.0
    for unit, (least, most) in _COUNTERS.items():
        if least <= usual < most:
            return unit, f"as usual steps of {usual:.3g} s are too long for a rig"
    return "s", _PLAIN


def _position(sheets: Sequence[Sheet]) -> Reasoned:
    """Return the unit of positions that nothing names, by the longest span of all files."""
    words = set().union(*(words_of(sheet.names["x"]) for sheet in sheets))
    if words & COUNTED:
        raise InputError(
            f"{sheets[0].path}: {sheets[0].names['x']} may be in any unit or plain counts: "
            "--unit x=mm or x=deg says it, counts are to be converted before"
        )
    spans = [float(np.ptp(known)) for sheet in sheets if (known := _known(sheet)).size]
    span = max(spans, default=0.0)
    if words & ANGLES:
        if span > _TURN:
            return "deg", f"as a span of {span:.3g} rad is {span / _TURN:.3g} turns"
        return "rad", _PLAIN
    if span > _FAR:
        return "mm", f"as a span of {span:.3g} m is too long for a rig"
    return "m", _PLAIN


def _known(sheet: Sheet) -> NDArray[np.float64]:
    values = numbers_of(sheet.table.frame["x"])
    return values[np.isfinite(values)]


def _like_position(sheet: Sheet, role: str, position: str, allowed: Sequence[str]) -> Reasoned:
    """Return the unit of a column that nothing names, where it may go by that of x."""
    unit = {"x_rear": position, "v": f"{position}/s"}.get(role, "")
    if unit and unit != allowed[0] and fits(role, unit, allowed):
        return unit, f"as {sheet.names['x']} is in {position}"
    # A rotary bench turns by N m.
    return "N m" if role == "drive" and is_angle(position) else allowed[0], _PLAIN


def _check_agreement(
    sheets: Sequence[Sheet], units: Sequence[Mapping[str, Reasoned]], said: Sequence[set[str]]
) -> None:
    """Refuse files whose columns measure different things, or differ in units by guesses only."""
    first: dict[str, int] = {}
    for k, (sheet, own) in enumerate(zip(sheets, units, strict=True)):
        for role, (unit, why) in own.items():
            one = first.setdefault(role, k)
            other, because = units[one][role]
            both = role in said[k] and role in said[one]
            if unit != other and not (both and alike(unit, other)):
                alone = ": allowed are files of one rig"
                hint = (
                    f": --unit {role}=UNIT says one for all files" if alike(unit, other) else alone
                )
                raise InputError(
                    f"{sheet.path}: {role} is in {unit} ({why}), but in {other} ({because}) in "
                    f"{sheets[one].path}{hint}"
                )
