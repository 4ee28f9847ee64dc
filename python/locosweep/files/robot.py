"""Robot files: the nominal model of a robot as TOML. Nothing in it is executed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from locosweep import _core
from locosweep.errors import InputError
from locosweep.files import toml
from locosweep.registry import unknown

if TYPE_CHECKING:
    import os
    from collections.abc import Collection


@dataclass(frozen=True)
class Robot:
    """A robot file: parameters for sweeps, and the keys that other commands use.

    Attributes
    ----------
    parameters : dict of str to float
        Parameters of the closed forms, by name.
    other : dict of str to float or str
        Further keys as ``table.key`` (sensor, motor, uncertainty, bench, gain).
    effects : dict of str to dict of str to float
        Parameters of the effects that the file adds to its nominal model, by name.
    """

    parameters: dict[str, float] = field(default_factory=dict)
    other: dict[str, float | str] = field(default_factory=dict)
    effects: dict[str, dict[str, float]] = field(default_factory=dict)


def load_robot(path: str | os.PathLike[str]) -> Robot:
    """Read a robot file (TOML with the tables robot, surface, drive, gait, ...).

    Parameters
    ----------
    path : path-like
        The file. Every key, its unit and range are those of the registry.

    Returns
    -------
    Robot

    Raises
    ------
    DataFileError
        No such file, not TOML, an unknown table or key (with the nearest known
        one), a value of the wrong kind or out of range.

    Examples
    --------
    >>> import locosweep as ls
    >>> robot = ls.load_robot("examples/locosnake.toml")
    >>> robot.parameters["segments"]
    4.0
    """
    document = toml.read(path)
    with toml.refusing(path):
        return _robot(document)


def _robot(document: dict[str, Any]) -> Robot:
    parameters = {p.file_key: p for p in _core.parameters() if p.file_key}
    records = {p.file_key: p for p in _core.file_keys() if p.file_key} | parameters
    choices = {(table, key): words for table, key, words in _core.file_choices()}
    known = [*records, *choices]
    toml.check_keys("table", document, [*dict.fromkeys(t for t, _ in known), "effects"])
    robot = Robot()
    for table in [name for name in document if name != "effects"]:
        content = toml.table(document, table)
        toml.check_keys(f"key in [{table}]", content, [key for t, key in known if t == table])
        for key, value in content.items():
            where, entry = f"[{table}] {key}", (table, key)
            if entry in choices:
                if value not in choices[entry]:
                    allowed = ", ".join(choices[entry])
                    raise InputError(f"{where} is {value!r}: allowed is {allowed}")
                robot.other[f"{table}.{key}"] = value
            elif entry in parameters:
                record = parameters[entry]
                robot.parameters[record.name] = toml.value_of(where, record, value)
            else:
                robot.other[f"{table}.{key}"] = toml.value_of(where, records[entry], value)
    if "surface.coulomb_force" in robot.other and "mu_coulomb" in robot.parameters:
        raise InputError("[surface] has mu_coulomb and coulomb_force: give one")
    level = "coulomb_force" if "surface.coulomb_force" in robot.other else "mu_coulomb"
    effects = toml.table(document, "effects")
    robot.effects.update({name: _effect(name, effects, level) for name in effects})
    _check_places(effects)
    return robot


def _check_places(given: Collection[str]) -> None:
    """Refuse effects that stand in each other's place."""
    for record in _core.effects():
        both = [name for name in record.excludes if name in given]
        if record.name in given and both:
            raise InputError(
                f"[effects.{record.name}] and [effects.{both[0]}] stand in the same place: give one"
            )


def _effect(name: str, tables: dict[str, Any], level: str) -> dict[str, float]:
    """Read the parameters of one effect, beside a Coulomb level that is given as `level`."""
    records = {record.name: record for record in _core.effects()}
    if name not in records:
        raise unknown("effect", name, records)
    parameters = {p.name: p for p in records[name].parameters}
    content = toml.table(tables, name, f"effects.{name}")
    toml.check_keys(f"key in [effects.{name}]", content, parameters)
    found = {}
    for key, value in content.items():
        where = f"[effects.{name}] {key}"
        number = toml.number(where, value)
        record = parameters[key]
        # A fit may end next to 0: within its range every size is read back, bit for bit.
        if not record.range[0] <= number <= record.range[1]:
            allowed = record.allowed
            raise InputError(f"{where} is {number!r} {record.unit}: allowed is {allowed}")
        found[key] = number
    for fit in records[name].fits:
        used = fit.only_with in (None, level)
        if used and fit.name not in found:
            raise InputError(f"[effects.{name}] has no {fit.name}")
        if not used and fit.name in found:
            raise InputError(
                f"[effects.{name}] has {fit.name}, which goes with {fit.only_with}: "
                f"the model's Coulomb level is given as {level}"
            )
    return found


def is_rotary(robot: Robot) -> bool:
    """Return whether the robot is a rotary bench: positions are angles, forces are torques."""
    return robot.other.get("bench.kind") == "rotary"
