"""Files: robot descriptions (TOML) and results (Parquet). Nothing in them is executed."""

from __future__ import annotations

import math
import os
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from locosweep import _core
from locosweep.errors import DataFileError, InputError
from locosweep.registry import unknown

if TYPE_CHECKING:
    pass

__all__ = ["Robot", "load_robot"]


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
    path = Path(path)
    try:
        document = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except OSError as error:
        raise DataFileError(f"{path}: {error.strerror or error}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise DataFileError(f"{path}: not TOML: {error}") from None
    records = {p.file_key: p for p in _core.parameters() if p.file_key}
    others = {p.file_key: p for p in _core.file_keys() if p.file_key}
    choices = {(table, key): words for table, key, words in _core.file_choices()}
    known = [*records, *others, *choices]
    robot = Robot()
    effects = _effect_tables(path, document.pop("effects", {}))
    for table, content in document.items():
        tables = list(dict.fromkeys(t for t, _ in known))
        if table not in tables:
            raise DataFileError(f"{path}: {unknown('table', table, [*tables, 'effects'])}")
        if not isinstance(content, dict):
            raise DataFileError(f"{path}: {table} is not a table: write [{table}]")
        for key, value in content.items():
            place = (table, key)
            if place in choices:
                robot.other[f"{table}.{key}"] = _word(path, place, value, choices[place])
            elif place in records or place in others:
                record = records.get(place) or others[place]
                number = _number(path, place, value)
                try:
                    number = record.check(number)
                except InputError as error:
                    raise DataFileError(f"{path}: [{table}] {error}") from None
                if place in records:
                    robot.parameters[record.name] = number
                else:
                    robot.other[f"{table}.{key}"] = number
            else:
                keys = [k for t, k in known if t == table]
                raise DataFileError(f"{path}: {unknown(f'key in [{table}]', key, keys)}")
    if "surface.coulomb_force" in robot.other and "mu_coulomb" in robot.parameters:
        raise DataFileError(f"{path}: [surface] has mu_coulomb and coulomb_force: give one")
    level = "coulomb_force" if "surface.coulomb_force" in robot.other else "mu_coulomb"
    for name, content in effects:
        robot.effects[name] = _effect(path, name, content, level)
    return robot


def _effect_tables(path: Path, tables: object) -> list[tuple[str, object]]:
    if not isinstance(tables, dict):
        raise DataFileError(f"{path}: effects is not a table: write [effects.NAME]")
    return list(tables.items())


def _effect(path: Path, name: str, content: object, level: str) -> dict[str, float]:
    """Read the parameters of one effect, beside a Coulomb level that is given as `level`."""
    records = {record.name: record for record in _core.effects()}
    if name not in records:
        raise DataFileError(f"{path}: {unknown('effect', name, records)}")
    where = f"[effects.{name}]"
    if not isinstance(content, dict):
        raise DataFileError(f"{path}: effects.{name} is not a table: write {where}")
    parameters = {p.name: p for p in records[name].parameters}
    found = {}
    for key, value in content.items():
        if key not in parameters:
            raise DataFileError(f"{path}: {unknown(f'key in {where}', key, parameters)}")
        number = _number(path, (f"effects.{name}", key), value)
        low, high = parameters[key].range
        # A fit may end next to 0: within its range every size is read back, bit for bit.
        if not low <= number <= high:
            raise DataFileError(
                f"{path}: {where} {key} is {number!r} {parameters[key].unit}: "
                f"allowed is {parameters[key].allowed}"
            )
        found[key] = number
    for fit in records[name].fits:
        used = fit.only_with in (None, level)
        if used and fit.name not in found:
            raise DataFileError(f"{path}: {where} has no {fit.name}")
        if not used and fit.name in found:
            raise DataFileError(
                f"{path}: {where} has {fit.name}, which goes with {fit.only_with}: "
                f"the model's Coulomb level is given as {level}"
            )
    return found


def _number(path: Path, place: tuple[str, str], value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataFileError(f"{path}: [{place[0]}] {place[1]} is {value!r}: allowed is a number")
    try:
        return float(value)
    except OverflowError:
        # Whole numbers of TOML have no limit; the range check refuses this one.
        return math.inf if value > 0 else -math.inf


def _word(path: Path, place: tuple[str, str], value: object, words: list[str]) -> str:
    if value not in words:
        allowed = ", ".join(words)
        raise DataFileError(f"{path}: [{place[0]}] {place[1]} is {value!r}: allowed is {allowed}")
    return str(value)
