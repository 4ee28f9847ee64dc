"""What a column is by its name: words of loggers in English and German, and units in names."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from locosweep.errors import InputError
from locosweep.files.units import bracketed, factor

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

ROLES: dict[str, tuple[str, ...]] = {
    "run": ("run", "trial", "experiment", "versuch", "lauf", "series", "repeat"),
    "t": ("t", "time", "zeit", "timestamp", "stamp", "datetime", "date", "elapsed", "uhrzeit",
          "epoch", "clock", "datum", "millis", "micros"),
    "drive": ("drive", "command", "cmd", "setpoint", "soll", "sollwert", "duty", "pwm", "u",
              "voltage", "spannung", "current", "strom", "tau", "torque", "effort", "input",
              "stellwert", "antrieb", "actuation"),
    "x": ("x", "position", "pos", "displacement", "disp", "weg", "travel", "encoder", "distance",
          "angle", "theta", "winkel", "ort"),
    "x_rear": ("rear", "body", "tail", "anchor", "hinten", "heck"),
    "slope_deg": ("slope", "incline", "inclination", "tilt", "neigung", "steigung"),
    "v": ("v", "velocity", "vel", "speed", "geschwindigkeit", "omega"),
    "power": ("power", "leistung", "watt"),
    "force": ("force", "kraft", "load", "loadcell"),
}  # fmt: skip
"""Words for each column, those that say most first; x comes before those whose unit goes by it."""
_MOTION = {word for role in ("x", "x_rear", "v") for word in ROLES[role]}
_ASKED = {"command", "cmd", "setpoint", "soll", "sollwert", "target", "ref", "reference", "desired"}
"""Words of what was asked for: such a column is the drive, or no reading at all."""
ANGLES = {"angle", "theta", "winkel"}
COUNTED = {"encoder", "count", "counts", "tick", "ticks", "adc"}
"""Words of readings that may be plain counts."""
WORD_UNITS = {
    **dict.fromkeys(("voltage", "spannung"), "V"), **dict.fromkeys(("current", "strom"), "A"),
    **dict.fromkeys(("duty", "pwm"), "1"), "torque": "N m", "millis": "ms", "micros": "us",
}  # fmt: skip
"""Units of drives and times whose name says what they are."""
_UNIT_WORDS = """
m cm mm um µm km inch mps mmps s ms us µs ns sec secs msec usec seconds millis micros rpm Hz kHz
N mN kN newton newtons Nm mNm Nmm V mV volt volts A mA amp amps W mW kW Pa kPa bar g kg degC
% pct percent ° deg rad mrad
"""
_UNITS = frozenset(_UNIT_WORDS.split())
"""Units that end names; others count in brackets only, as Pint knows act, link, pin and a, too."""
_SECONDS = {"s", "sec"}
_SIDE = "A"
"""The unit that is a letter of a pair, too: force_A and force_B."""
_COMPOUND = r"^(soll|ist)(?=\w{3})"
_SLASH = re.compile(r"([^/]+)/(.+)")


def words_of(name: str) -> list[str]:
    """Return the words of a name, in lower case.

    Examples
    --------
    >>> from locosweep.intake.names import words_of
    >>> words_of("motorCmd_N (raw)")
    ['motor', 'cmd', 'n', 'raw']
    """
    parts = re.sub(r"(?<=[a-zäöü])(?=[A-Z])", " ", name)
    words = [word for word in re.split(r"[\W_\d]+", parts.lower()) if word]
    # German writes them as one: Sollkraft, Istposition.
    return [part for word in words for part in re.sub(_COMPOUND, r"\1 ", word).split()]


def unit_in(name: str) -> tuple[str, str]:
    """Return a name without the unit at its end, and that unit; empty where there is none.

    Examples
    --------
    >>> from locosweep.intake.names import unit_in
    >>> unit_in("Position_mm"), unit_in("speed [mm/s]"), unit_in("pos_left")
    (('Position', 'mm'), ('speed', 'mm/s'), ('pos_left', ''))
    """
    bare, unit = bracketed(name)
    if unit:
        return bare, unit
    parts = re.split(r"([_. ])", re.sub(r"[_. ]per[_. ]", "/", name))
    for count in (2, 1):
        rest, tail = "".join(parts[: -2 * count]), parts[1 - 2 * count :: 2]
        units = [_usual(part) for part in tail]
        if rest and len(tail) == count and all(units):
            return rest, ("/" if units[-1] in _SECONDS else " ").join(units)
    slash = _SLASH.fullmatch(name)
    unit = _usual(slash[2]) if slash else ""
    return (slash[1], unit) if slash and unit else (name, "")


def _usual(text: str) -> str:
    """Return a text as a unit that ends names, which may be in capitals; empty if it is none."""
    parts = [part if part in _UNITS else part.lower() for part in text.split("/")]
    return "/".join(parts) if all(part in _UNITS for part in parts) else ""


def fits(role: str, unit: str, allowed: Sequence[str]) -> bool:
    """Return whether a unit measures what a column of this role does."""
    try:
        factor(role, unit, allowed)
    except InputError:
        return False
    return True


def unit_for(name: str, role: str, allowed: Sequence[str]) -> str:
    """Return the unit at the end of a name if it fits a role; empty without one.

    Examples
    --------
    >>> from locosweep.intake.names import unit_for
    >>> unit_for("motor_A", "drive", ["A"]), unit_for("force_A", "force", ["N"])
    ('A', '')
    """
    unit = unit_in(name)[1]
    return unit if unit and fits(role, unit, allowed) else ""


def speaks_for(
    name: str, role: str, wanted: Mapping[str, Sequence[str]]
) -> tuple[bool, bool, int, bool] | None:
    """Return how much a name speaks for a role, to compare; None where it does not.

    What counts first: that it is our own name, that it was asked for (the drive), which word it
    has, and that it has a unit that fits.
    """
    own = bracketed(name)[0] == role
    bare, unit = unit_in(name)
    fit = bool(wanted[role]) and bool(unit_for(name, role, wanted[role]))
    if (unit == _SIDE and not fit) or unit.lower() in COUNTED:
        bare, unit = name, ""
    words = words_of(bare)
    found = [ROLES[role].index(word) for word in words if word in ROLES[role]]
    asked = bool(_ASKED & set(words))
    if own and (fit or not unit):
        return True, False, 0, fit
    if not found or (unit and wanted[role] and not fit):
        return None
    if role == "drive":
        # A set point of a position is no drive: the rig's controller stands between.
        if asked and not fit and _MOTION & set(words):
            return None
        return False, asked, -min(found), fit
    if asked or (role == "x" and _is_another_reading(name, wanted)):
        return None
    return False, False, -min(found), fit


def _is_another_reading(name: str, wanted: Mapping[str, Sequence[str]]) -> bool:
    others = ("x_rear", "slope_deg", "v", "power", "force")
    return any(speaks_for(name, role, wanted) for role in others)
