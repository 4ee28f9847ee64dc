"""TOML: the one reader and the one writer, and checks of what stands in a file."""

from __future__ import annotations

import contextlib
import os
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from locosweep.errors import DataFileError, InputError
from locosweep.files.raw import stored
from locosweep.registry import unknown

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from locosweep._core import Parameter

_MOST_BYTES = 16 << 20
"""A file of a robot has 1 kB, one of a sweep with a million values on an axis 10 MB."""


def read(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the content of a TOML file; DataFileError if it is not one."""
    try:
        text = stored(Path(path), _MOST_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DataFileError(f"{path}: not TOML: {error}") from None
    return parse(text, path)


def parse(text: str, source: object) -> dict[str, Any]:
    """Return the content of a TOML text; `source` is what messages call it."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also a number of too many digits
        raise DataFileError(f"{source}: not TOML: {error}") from None


def write(document: Mapping[str, Any]) -> str:
    """Return a TOML text that reads back to the same bits.

    Parameters
    ----------
    document : mapping
        Keys and tables in order. A table inside a table stands on one line; None and
        empty tables are left out.

    Examples
    --------
    >>> from locosweep.files.toml import write
    >>> print(write({"q": None, "axes": {"mass": {"from": 0.1, "to": 1.0}}}), end="")
    [axes]
    mass = {from = 0.1, to = 1.0}
    """
    import tomlkit

    kept: dict[str, Any] = {}
    for key, value in document.items():
        if isinstance(value, dict):
            rows = {name: _item(one) for name, one in value.items() if one is not None}
            kept |= {key: rows} if rows else {}
        elif value is not None:
            kept[key] = _item(value)
    return tomlkit.dumps(kept)


def _item(value: Any) -> Any:
    import tomlkit

    if isinstance(value, dict):
        inline = tomlkit.inline_table()
        inline.update({key: _item(one) for key, one in value.items() if one is not None})
        return inline
    if isinstance(value, list | tuple) and all(type(one) in (int, float) for one in value):
        return _numbers(value)
    if isinstance(value, list | tuple):
        return [_item(one) for one in value]
    return value if isinstance(value, str | int) else float(value)


def _numbers(values: Sequence[int | float]) -> Any:
    """Return an array that is written as a text: item by item 10 000 numbers take 40 s."""
    from tomlkit.items import Array, Trivia

    text = f"[{', '.join(map(repr, values))}]"

    class Numbers(Array):
        def as_string(self) -> str:
            return text

    return Numbers([], Trivia())


@contextlib.contextmanager
def refusing(source: object) -> Iterator[None]:
    """Turn an InputError into a DataFileError that begins with the file's name."""
    try:
        yield
    except InputError as error:
        raise DataFileError(f"{source}: {error}") from None


def check_format(document: Mapping[str, Any], form: str) -> None:
    """Refuse a file of another format; one that names none is taken as this one."""
    if document.get("format", form) != form:
        raise InputError(f"format is {document['format']!r}: this version reads {form!r}")


def check_keys(kind: str, given: Iterable[str], known: Iterable[str]) -> None:
    """Refuse an unknown key, with the nearest known one."""
    known = list(known)
    for key in given:
        if key not in known:
            raise unknown(kind, key, known)


def table(document: Mapping[str, Any], key: str, name: str | None = None) -> dict[str, Any]:
    """Return a table, empty if it is not there; `name` is its full name where it is nested."""
    found = document.get(key, {})
    if not isinstance(found, dict):
        raise InputError(f"{name or key} is not a table: write [{name or key}]")
    return found


def number(where: str, value: object, allowed: str = "a number") -> float:
    """Return a value as a float; `where` is what messages call it."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{where} is {value!r}: allowed is {allowed}")
    try:
        return float(value)
    except OverflowError:
        # Whole numbers of TOML have no limit.
        raise InputError(f"{where} is too large: allowed is {allowed}") from None


def value_of(where: str, record: Parameter, value: object) -> float:
    """Return the value of a parameter within its range; `where` is its name in messages."""
    found = number(where, value, record.allowed)
    try:
        return record.check(found)
    except InputError as error:
        text = str(error)
        raise InputError(where + text.removeprefix(record.name)) from None


def word(where: str, value: object) -> str:
    """Return a value that has to be a text that is not empty."""
    if not isinstance(value, str) or not value:
        raise InputError(f"{where} is {value!r}: allowed is a word in quotes")
    return value


def moved(file: str | None, old: Path, new: Path) -> str | None:
    """Return a path that is relative to the folder `old` as one relative to `new`."""
    if file is None or Path(file).is_absolute() or old.resolve() == new.resolve():
        return file
    target = (old / file).resolve()
    try:
        return Path(os.path.relpath(target, new.resolve())).as_posix()
    except ValueError:  # another drive of Windows
        return target.as_posix()
