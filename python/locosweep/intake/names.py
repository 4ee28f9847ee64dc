"""What a column is by its name: words of loggers in English and German, and units in names."""

from __future__ import annotations

import re

from locosweep.errors import InputError
from locosweep.files.units import factor, is_unit

ROLES: dict[str, tuple[str, ...]] = {
    "run": ("run", "trial", "experiment", "versuch", "lauf", "series", "repeat"),
    "t": ("t", "time", "zeit", "timestamp", "stamp", "datetime", "date", "elapsed", "uhrzeit",
          "epoch", "clock", "datum"),
    "drive": ("drive", "command", "cmd", "setpoint", "soll", "sollwert", "duty", "pwm", "u",
              "voltage", "spannung", "current", "strom", "tau", "torque", "effort", "input",
              "stellwert", "antrieb", "actuation"),
    "x_rear": ("rear", "body", "tail", "anchor", "hinten", "heck"),
    "slope_deg": ("slope", "incline", "inclination", "tilt", "neigung", "steigung"),
    "v": ("v", "velocity", "vel", "speed", "geschwindigkeit", "omega"),
    "power": ("power", "leistung", "watt"),
    "force": ("force", "kraft", "load", "loadcell"),
    "x": ("x", "position", "pos", "displacement", "disp", "weg", "travel", "encoder", "distance",
          "angle", "theta", "winkel", "ort"),
}  # fmt: skip
"""Words for each column, those that say most first."""
_ASKED = {"command", "cmd", "setpoint", "soll", "sollwert", "target", "ref", "reference", "desired"}
"""Words of what was asked for: such a column is the drive, or no reading at all."""
_EXACT, _ASKED_FOR, _UNIT, _WORD = 100, 40, 5, 20
"""Points: the contract's own name; a command in the name; a unit that fits; a word."""
_COMPOUND = r"^(soll|ist)(?=\w{3})"
_BRACKETS = re.compile(r"(.*?)\s*[\[(]\s*([^\[\]()]+?)\s*[\])]")
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
    bracket = _BRACKETS.fullmatch(name)
    if bracket and is_unit(bracket[2]):
        return bracket[1], bracket[2]
    parts = re.split(r"([_. ])", name)
    for count in (2, 1):
        tail = [part for part in parts[-2 * count :: 1] if part not in "_. "]
        rest = "".join(parts[: -2 * count])
        unit = "/".join(tail)
        if len(tail) == count and rest and is_unit(unit):
            return rest, unit
    slash = _SLASH.fullmatch(name)
    return (slash[1], slash[2]) if slash and is_unit(slash[2]) else (name, "")


def fits(role: str, unit: str, allowed: tuple[str, ...]) -> bool:
    """Return whether a unit measures what a column of this role does."""
    try:
        factor(role, unit, allowed)
    except InputError:
        return False
    return True


def points(name: str, role: str, allowed: tuple[str, ...]) -> int:
    """Return how much a name speaks for a role; 0 where it does not."""
    if name == role:
        return _EXACT
    bare, unit = unit_in(name)
    unit_fits = bool(unit) and bool(allowed) and fits(role, unit, allowed)
    words = words_of(bare)
    known = ROLES[role]
    found = [known.index(word) for word in words if word in known]
    asked = bool(_ASKED & set(words))
    if not found or (unit and allowed and not unit_fits):
        return 0
    if role == "drive":
        return _WORD - min(found) + (_ASKED_FOR if asked else 0) + (_UNIT if unit_fits else 0)
    if asked or (role == "x" and set(words) & set(ROLES["x_rear"])):
        return 0
    return _WORD - min(found) + (_UNIT if unit_fits else 0)
