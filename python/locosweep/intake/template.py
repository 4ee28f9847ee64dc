"""The first nominal file for a log: what was given, what readings show, what is to fill in."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from locosweep import _core
from locosweep.diagnosis.report.units import rotary_unit
from locosweep.errors import InputError
from locosweep.files.channels import CHANNELS
from locosweep.registry import unknown

if TYPE_CHECKING:
    from collections.abc import Mapping

    from locosweep._core import Parameter
    from locosweep.intake.log import Log

UNKNOWN = "?"
"""Value that no command takes: no default may stand in for a mass that nobody weighed."""
_LINEAR = {
    "robot": ("segments", "mass", "gravity"),
    "surface": ("mu_coulomb", "coulomb_force", "viscous", "slope_deg"),
    "drive": ("gain", "limit"),
}
_NEEDED = {("robot", "mass"), ("surface", "mu_coulomb")}
_ROTARY = {
    "robot": ("mass",),
    "surface": ("coulomb_force", "viscous"),
    "drive": ("gain", "limit"),
    "bench": ("kind", "gravity_torque"),
}
_NEEDED_ROTARY = {("robot", "mass"), ("surface", "coulomb_force"), ("bench", "gravity_torque")}
_HINTS = {
    ("robot", "mass"): "weigh the moving part",
    ("drive", "gain"): "here of the column drive",
}
_DIGITS = 2
"""Significant digits of a noise: it is known to a tenth."""
_HEAD = """\
# The nominal model of the rig: what you believe before any diagnosis. SI units.
# Values are taken as exact: what differs is found, not refitted. Lines that begin with # are
# not read; a value in quotes, "?", is missing: `locosweep diagnose` names it until it is there.
"""


def keys_of(*, rotary: bool) -> dict[str, tuple[str, str]]:
    """Return table and key of each value of a template, by the name that a user gives it."""
    tables = _ROTARY if rotary else _LINEAR
    return {key: (table, key) for table, keys in tables.items() for key in keys if key != "kind"}


def nominal_text(log: Log, given: Mapping[str, float]) -> tuple[str, list[str]]:
    """Return the text of a nominal file, and the names of values that are still missing.

    Parameters
    ----------
    log : Log
        What was read: whether positions are angles, and the noise of its readings.
    given : mapping of str to float
        Values by key, for instance ``{"mass": 0.27}``.

    Raises
    ------
    InputError
        A key that a template does not have, or a value out of its range.
    """
    keys = keys_of(rotary=log.rotary)
    for name in given:
        if name not in keys:
            raise InputError(f"--set: {unknown('key', name, keys)}")
    records = {p.file_key: p for p in (*_core.parameters(), *_core.file_keys()) if p.file_key}
    needed = set(_NEEDED_ROTARY if log.rotary else _NEEDED)
    if not log.drive_in_force:
        needed.add(("drive", "gain"))
    if "coulomb_force" in given:
        if "mu_coulomb" in given:
            raise InputError("--set gives mu_coulomb and coulomb_force: allowed is one")
        needed.discard(("surface", "mu_coulomb"))
    lines, missing = [_HEAD.rstrip()], []
    for table, names in (_ROTARY if log.rotary else _LINEAR).items():
        lines += ["", f"[{table}]"]
        for key in names:
            entry = (table, key)
            if key == "kind":
                lines.append('kind = "rotary"')
                continue
            record = records[entry]
            if key in given:
                lines.append(
                    _line(f"{key} = {record.check(given[key])!r}", record, entry, rotary=log.rotary)
                )
            elif entry in needed:
                missing.append(f"{table}.{key}")
                lines.append(_line(f'{key} = "{UNKNOWN}"', record, entry, rotary=log.rotary))
            elif record.default is not None and math.isfinite(record.default):
                lines.append(_line(f"{key} = {record.default!r}", record, entry, rotary=log.rotary))
            else:
                lines.append(_line(f"# {key} =", record, entry, rotary=log.rotary))
    return "\n".join([*lines, *_sensor(log), ""]), missing


def _line(setting: str, record: Parameter, entry: tuple[str, str], *, rotary: bool) -> str:
    if rotary and entry == ("robot", "mass"):
        return f"{setting:<22} # moment of inertia [kg m^2]"
    counted = rotary_unit(record.unit) if rotary else record.unit
    unit = "" if counted == "1" else f" [{counted}]"
    hint = f"; {_HINTS[entry]}" if entry in _HINTS else ""
    return f"{setting:<22} # {record.meaning}{unit}{hint}"


def _sensor(log: Log) -> list[str]:
    """Return the table of the sensors, as the readings show their noise."""
    lines: dict[str, str] = {}
    for channel, noise in log.noise.items():
        record = CHANNELS[channel]
        unit = record.unit_on(rotary=log.rotary)
        if noise.gaussian > 0.0:
            key = f"{record.sensor}_noise"
            lines.setdefault(key, f"{key} = {noise.gaussian:.{_DIGITS}g}".ljust(34) + f"# {unit}")
        if noise.step > 0.0 and record.has_offset:
            key = f"{record.sensor}_resolution"
            lines.setdefault(
                key, f"{key} = {noise.step:.{_DIGITS}g}".ljust(34) + f"# {unit}, steps"
            )
    if not lines:
        return []
    said = "# As the readings show it, motion included: a data sheet may say less, never more."
    return ["", "[sensor]", said, *lines.values()]
