"""Files: robot descriptions (TOML) and results (Parquet). Nothing in them is executed."""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import tempfile
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.errors import DataFileError, InputError
from locosweep.registry import Status, unknown

if TYPE_CHECKING:
    from collections.abc import Iterator

    import polars as pl

    from locosweep.result import Result

__all__ = ["Robot", "check_place", "load", "load_robot", "replacing", "save_result"]

_FORMAT = "locosweep.result/1"


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
    for name, content in _effect_tables(path, document.pop("effects", {})):
        robot.effects[name] = _effect(path, name, content)
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
    return robot


def _effect_tables(path: Path, tables: object) -> list[tuple[str, object]]:
    if not isinstance(tables, dict):
        raise DataFileError(f"{path}: effects is not a table: write [effects.NAME]")
    return list(tables.items())


def _effect(path: Path, name: str, content: object) -> dict[str, float]:
    """Read the parameters of one effect; a mass or level that is not given is off."""
    records = {record.name: record for record in _core.effects()}
    if name not in records:
        raise DataFileError(f"{path}: {unknown('effect', name, records)}")
    if not isinstance(content, dict):
        raise DataFileError(f"{path}: effects.{name} is not a table: write [effects.{name}]")
    parameters = {p.name: p for p in records[name].parameters}
    found = {}
    for key, value in content.items():
        if key not in parameters:
            where = f"key in [effects.{name}]"
            raise DataFileError(f"{path}: {unknown(where, key, parameters)}")
        number = _number(path, (f"effects.{name}", key), value)
        low, high = parameters[key].range
        if not low <= number <= high:
            raise DataFileError(
                f"{path}: [effects.{name}] {key} is {number!r} {parameters[key].unit}: "
                f"allowed is {parameters[key].allowed}"
            )
        found[key] = number
    # The two forms of one error: the file's model says which of them counts.
    missing = [key for key in parameters if key not in found and not key.startswith("d_")]
    if missing:
        raise DataFileError(f"{path}: [effects.{name}] has no {missing[0]}")
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


def check_place(path: str | os.PathLike[str]) -> Path:
    """Refuse a path that cannot become a file: a folder, or in none that exists."""
    path = Path(path)
    if "\0" in str(path):
        raise InputError(f"{str(path)!r}: a file name cannot have a NUL in it")
    if path.is_dir():
        raise InputError(f"{path} is a folder: name a file")
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist")
    return path


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path that replaces `path` when all went well.

    Nothing half-written is left under the final name, whatever happens.
    """
    path = check_place(path)
    try:
        handle, name = tempfile.mkstemp(suffix=path.suffix, prefix=".locosweep-", dir=path.parent)
    except OSError as error:
        raise InputError(f"{path}: cannot write: {error.strerror}") from None
    os.close(handle)
    try:
        yield Path(name)
        mask = os.umask(0)
        os.umask(mask)
        Path(name).chmod(0o666 & ~mask)
        Path(name).replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot write: {error.strerror or error}") from None
    finally:
        Path(name).unlink(missing_ok=True)


def save_result(result: Result, path: str | os.PathLike[str]) -> None:
    """Write a result as a Parquet table with everything needed to read it back."""
    import polars as pl

    header: dict[str, Any] = {
        "format": _FORMAT,
        "version": _core.version(),
        "axes": {name: [_text(v) for v in axis] for name, axis in result.axes.items()},
        "fixed": {name: _text(value) for name, value in result.fixed.items()},
        "over": result.over,
        "rivals": None if result.rivals is None else [_text(v) for v in result.rivals],
        "q": result.q,
        "outputs": [[o.quantity, o.reduce, result[o.name].dtype.name] for o in result.outputs],
        "how": result.how,
    }
    header["sha256"] = _digest(header, result)
    frame = result.to_polars()
    with replacing(path) as temporary:
        try:
            frame.write_parquet(temporary, metadata={"locosweep": json.dumps(header)})
        except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
            raise InputError(f"{path}: cannot write: {error}") from None


def _text(value: float) -> str:
    """Shortest text that reads back to the same bits."""
    return repr(float(value))


def _digest(header: dict[str, Any], result: Result) -> str:
    """Hash everything that is read back."""
    rest = {key: value for key, value in header.items() if key != "sha256"}
    digest = hashlib.sha256(json.dumps(rest, sort_keys=True).encode())
    for output in result.outputs:
        digest.update(np.ascontiguousarray(result[output.name]).tobytes())
        digest.update(np.ascontiguousarray(result.status_of(output.name)).tobytes())
    return digest.hexdigest()


def load(path: str | os.PathLike[str]) -> Result:
    """Read a result that `Result.save` wrote.

    Parameters
    ----------
    path : path-like
        The Parquet file.

    Returns
    -------
    Result
        With the same bits as when it was saved.

    Raises
    ------
    DataFileError
        No such file, no Parquet, not a result of this package, or altered since.

    Examples
    --------
    >>> import locosweep as ls, tempfile, pathlib
    >>> r = ls.sweep("optimal_segments", mu_static=[0.4, 0.5], mu_coulomb=0.3)
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "r.parquet"
    >>> r.save(file)
    >>> bool((ls.load(file).values == r.values).all())
    True
    """
    import polars as pl

    from locosweep.result import Result

    path = Path(path)
    if not path.is_file():
        raise DataFileError(f"{path}: no such file")
    try:
        header = _header(path, pl.read_parquet_metadata(path).get("locosweep"))
        frame = pl.read_parquet(path)
    except (OSError, pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise DataFileError(f"{path}: not a readable Parquet file: {first}") from None
    try:
        outputs, axes, fixed, values, statuses = _unpack(header, frame)
    except (AttributeError, KeyError, TypeError, ValueError, pl.exceptions.PolarsError) as error:
        raise DataFileError(f"{path}: not a result of locosweep: {error}") from None
    rivals, q = header["rivals"], header["q"]
    result = Result(
        outputs,
        axes,
        fixed,
        values,
        over=header["over"],
        rivals=None if rivals is None else np.array([float(v) for v in rivals]),
        q=None if q is None else float(q),
        statuses=statuses,
        how={str(key): str(value) for key, value in header.get("how", {}).items()},
    )
    if _digest(header, result) != header.get("sha256"):
        raise DataFileError(f"{path}: altered or damaged since it was written (hash differs)")
    return result


def _header(path: Path, text: str | None) -> dict[str, Any]:
    try:
        header = json.loads(text or "")
    except (ValueError, RecursionError):
        header = None
    if not isinstance(header, dict) or "format" not in header:
        raise DataFileError(f"{path}: a Parquet file, but not a result of locosweep")
    if header["format"] != _FORMAT:
        raise DataFileError(f"{path}: format {header['format']!r}: this version reads {_FORMAT!r}")
    return header


def _unpack(header: dict[str, Any], frame: pl.DataFrame) -> tuple[Any, ...]:
    import polars as pl

    from locosweep.result import Output

    over = header["over"]
    axes = {name: np.array([float(v) for v in axis]) for name, axis in header["axes"].items()}
    fixed = {name: float(value) for name, value in header["fixed"].items()}
    shape = tuple(len(axis) for axis in axes.values())
    if frame.height != math.prod(shape):
        raise ValueError(f"{frame.height} rows for a grid of {math.prod(shape)} cells")
    outputs, values, statuses = [], [], {}
    single = len(header["outputs"]) == 1
    for name, reduce, dtype in header["outputs"]:
        output = Output.of(name, reduce, over)
        column = frame[output.name].to_numpy()
        if dtype not in ("float64", "float32") or column.dtype.name != dtype:
            raise ValueError(f"column {output.name} has type {column.dtype}")
        label = "status" if single else f"{output.name}_status"
        codes = {status.name.lower(): int(status) for status in Status}
        read = frame[label].cast(str).replace_strict(codes, return_dtype=pl.UInt8)
        outputs.append(output)
        values.append(np.ascontiguousarray(column).reshape(shape))
        statuses[output.name] = np.ascontiguousarray(read.to_numpy()).reshape(shape)
    return outputs, axes, fixed, values, statuses
