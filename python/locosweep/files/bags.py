"""ROS 2 bags (MCAP, SQLite) as columns of measured runs; needs the extra ``ros``, not ROS."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.errors import DataFileError, InputError, first_line
from locosweep.files.channels import CHANNELS
from locosweep.registry import unknown

if TYPE_CHECKING:
    from collections.abc import Mapping

    import polars as pl
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

SUFFIXES = (".mcap", ".db3")
"""Endings of single files of a bag."""
_CLOCK = "x"
"""Column whose messages become the rows."""
_COLUMNS = ("drive", *CHANNELS)
"""Columns that a bag is read into, beside the time of the messages."""
_SECOND = 1e9
"""Nanoseconds, in which bags count."""
_STEP = re.compile(r"\.([A-Za-z_]\w*)|\[(\d+)\]")
_USE = "allowed is /topic.field, with [i] for an element, for instance /joint_states.position[0]"


@dataclass(frozen=True)
class _Field:
    """A number in the messages of a topic."""

    column: str
    topic: str
    steps: tuple[str | int, ...]
    """Names of fields and numbers of elements that lead to it."""

    @property
    def path(self) -> str:
        """Return the steps as they are written."""
        return "".join(f".{s}" if isinstance(s, str) else f"[{s}]" for s in self.steps).lstrip(".")


@dataclass(frozen=True)
class _Series:
    """The values of one field, with when their messages were recorded and stamped."""

    recorded: NDArray[np.int64]
    stamped: NDArray[np.int64] | None
    """None where messages have no header, or one without a time."""
    values: Floats


def is_bag(path: Path) -> bool:
    """Return whether a path is a bag: a file of one, or its folder."""
    return path.suffix.lower() in SUFFIXES or (path.is_dir() and (path / "metadata.yaml").exists())


def read_bag(path: Path, fields: Mapping[str, str]) -> pl.DataFrame:
    """Return a row for each message of the topic of x, with columns t (s), drive and others.

    Parameters
    ----------
    path : Path
        A file of a bag (.mcap, .db3) or its folder.
    fields : mapping of str to str
        For each column its topic and field, for instance ``{"x": "/joint_states.position[0]"}``;
        drive and x are needed.

    Returns
    -------
    polars.DataFrame
        Times are those of the headers where all topics have them, else those at which messages
        were recorded. The drive of a row is the mean of the commands that hold until the next
        row, which keeps their impulse; rows before the first command are left out. Other
        columns have the message nearest to a row, within half a step, or no value.

    Raises
    ------
    InputError
        A column missing, or not of the form /topic.field; the extra missing.
    DataFileError
        No bag, a topic or field that is not there, a field that is no number: in one line.
    """
    import polars as pl

    wanted = [_field(path, column, text) for column, text in fields.items()]
    for needed in ("drive", _CLOCK):
        if needed not in fields:
            raise InputError(f"{path}: no topic is given for {needed}: --map {needed}=/topic.field")
    series = _read(path, wanted)
    stamped = all(one.stamped is not None for one in series.values())
    times = _times(series, stamped=stamped)
    order = np.argsort(times[_CLOCK], kind="stable")
    t, x = times[_CLOCK][order], series[_CLOCK].values[order]
    told = ~np.isnan(series["drive"].values)
    if not told.any():
        raise DataFileError(f"{path}: drive has no values")
    first = times["drive"][told].min()
    kept = t >= first
    if not kept.any():
        raise DataFileError(f"{path}: no message of x follows the first one of drive")
    t, x = t[kept], x[kept]
    columns = {"t": (t - t[0]) / _SECOND, "x": x}
    for column, one in series.items():
        if column == "drive":
            columns[column] = _held(times[column], one.values, t)
        elif column != _CLOCK:
            columns[column] = _nearest(times[column], one.values, t)
    return pl.DataFrame(columns)


def _field(path: Path, column: str, text: str) -> _Field:
    if column not in _COLUMNS:
        raise InputError(f"{path}: {unknown('column', column, _COLUMNS)}")
    topic, dot, rest = text.partition(".")
    steps = list(_STEP.finditer(dot + rest))
    if not topic.startswith("/") or "".join(s.group() for s in steps) != dot + rest or not steps:
        raise InputError(f"{path}: {column}={text}: {_USE}")
    return _Field(column, topic, tuple(s.group(1) or int(s.group(2)) for s in steps))


def _read(path: Path, fields: list[_Field]) -> dict[str, _Series]:
    """Read the fields out of all messages of their topics."""
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError(
            f"{path}: bags need the package rosbags: pip install '.[ros]' in a clone"
        ) from None
    if not path.exists():
        raise DataFileError(f"{path}: no such file")
    found: dict[str, list[tuple[int, int, float]]] = {field.column: [] for field in fields}
    try:
        # Bags of older recorders hold no definitions of their messages.
        with AnyReader([path], default_typestore=get_typestore(Stores.LATEST)) as reader:
            topics = sorted({c.topic for c in reader.connections})
            for field in fields:
                if field.topic not in topics:
                    there = ", ".join(topics[:20]) or "none"
                    raise DataFileError(f"{path}: no topic {field.topic}: there are {there}")
            wanted = {field.topic for field in fields}
            connections = [c for c in reader.connections if c.topic in wanted]
            for connection, recorded, raw in reader.messages(connections):
                message = reader.deserialize(raw, connection.msgtype)
                stamp = _stamp(message)
                for field in fields:
                    if field.topic == connection.topic:
                        value = _value(path, field, message)
                        found[field.column].append((recorded, stamp, value))
    except (AnyReaderError, OSError, ValueError, KeyError, AssertionError) as error:
        if isinstance(error, InputError):
            raise
        raise DataFileError(f"{path}: not a readable bag: {first_line(error)}") from None
    return {field.column: _series(path, field, found[field.column]) for field in fields}


def _series(path: Path, field: _Field, rows: list[tuple[int, int, float]]) -> _Series:
    if not rows:
        raise DataFileError(f"{path}: topic {field.topic} has no messages")
    recorded = np.array([row[0] for row in rows], dtype=np.int64)
    stamped = np.array([row[1] for row in rows], dtype=np.int64)
    values = np.array([row[2] for row in rows])
    return _Series(recorded, stamped if (stamped > 0).all() else None, values)


def _stamp(message: Any) -> int:
    """Return the time in the header of a message in ns, 0 without one."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if stamp is None:
        return 0
    return int(stamp.sec) * int(_SECOND) + int(stamp.nanosec)


def _value(path: Path, field: _Field, message: Any) -> float:
    """Follow the steps of a field into a message."""
    at, where = message, f"{path}: topic {field.topic}"
    for step in field.steps:
        if isinstance(step, int):
            count = len(at) if hasattr(at, "__len__") else None
            if count is None or step >= count:
                has = "no elements" if count is None else f"{count} of them"
                raise DataFileError(f"{where}, {field.path}: no element {step}, there are {has}")
            at = at[step]
        elif not hasattr(at, step):
            there = [name for name in getattr(at, "__dataclass_fields__", {}) if name[0] != "_"]
            names = ", ".join(there) or "none"
            raise DataFileError(f"{where}: no field {step} of {field.path}: there are {names}")
        else:
            at = getattr(at, step)
    if isinstance(at, str | bytes) or not isinstance(at, bool | int | float | np.number):
        raise DataFileError(f"{where}: {field.path} is no number, {_USE}")
    if math.isinf(at):
        raise DataFileError(f"{where}: {field.path} is infinite")
    return float(at)


def _times(series: Mapping[str, _Series], *, stamped: bool) -> dict[str, Floats]:
    """Return the times of all messages in ns, from the first one on."""
    chosen = {
        c: one.stamped if stamped and one.stamped is not None else one.recorded
        for c, one in series.items()
    }
    # Whole numbers first: since 1970 have passed more ns than a float has digits for.
    begin = min(int(times.min()) for times in chosen.values())
    return {c: (times - begin).astype(np.float64) for c, times in chosen.items()}


def _held(times: Floats, values: Floats, t: Floats) -> Floats:
    """Return means of held values over the steps from each time to the next."""
    order = np.argsort(times, kind="stable")
    # Controllers send NaN before their first command.
    order = order[~np.isnan(values[order])]
    times, values = times[order], values[order]
    impulse = np.concatenate([[0.0], np.cumsum(values[:-1] * np.diff(times))])
    changes = np.concatenate([[0], np.cumsum(np.diff(values) != 0.0)])
    last = np.searchsorted(times, t, side="right") - 1
    until = impulse[last] + values[last] * (t - times[last])
    step = np.diff(t)
    # A value that holds stays as it was sent, to the last digit.
    mixed = (np.diff(changes[last]) > 0) & (step > 0.0)
    means = values[last].copy()
    means[:-1][mixed] = np.diff(until)[mixed] / step[mixed]
    return means


def _nearest(times: Floats, values: Floats, t: Floats) -> Floats:
    """Return the value nearest to each time, NaN where none is within half a usual step."""
    order = np.argsort(times, kind="stable")
    times, values = times[order], values[order]
    after = np.clip(np.searchsorted(times, t), 1, max(times.size - 1, 1))
    before = after - 1
    after = np.minimum(after, times.size - 1)
    near = np.where(np.abs(times[after] - t) < np.abs(t - times[before]), after, before)
    reach = 0.5 * float(np.median(np.diff(t))) if t.size > 1 else 0.0
    return np.where(np.abs(times[near] - t) <= reach, values[near], np.nan)
