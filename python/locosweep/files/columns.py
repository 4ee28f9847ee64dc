"""Columns of measured runs: numbers in SI units, labels and times, run by run."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import DataFileError, InputError
from locosweep.files import stamps as clock
from locosweep.files.csv_text import MISSING
from locosweep.files.raw import stored
from locosweep.files.table import listed
from locosweep.files.units import factor
from locosweep.registry import unknown

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Collection, Iterator, Mapping, Sequence

    import polars as pl
    from numpy.typing import NDArray

    from locosweep.files.table import Table

    MendStamps = Callable[[str, NDArray[np.float64]], NDArray[np.float64]]
    """From label and times of a run to times that rise, or those given."""

LEAST_SAMPLES = 20
"""Samples that a run needs: 20 tell its noise to a third (spread of `noise_of` over draws)."""
_LONGEST = 200
"""Characters of a label, at most: labels stand in every table and message."""


def checksum(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file, in hexadecimal digits."""
    return hashlib.sha256(stored(Path(path))).hexdigest()


def number_column(path: str, column: pl.Series, label: str) -> NDArray[np.float64]:
    """Return one column as numbers, missing ones as NaN.

    Raises
    ------
    DataFileError
        Text or an infinite value, with its row (the first below the names, and below the
        units if a row has them, is 1).
    """
    import polars as pl

    if column.dtype == pl.String:
        text = column.str.strip_chars()
        empty = text.is_null() | text.str.to_lowercase().is_in(MISSING)
        numbers = text.cast(pl.Float64, strict=False)
        wrong = (numbers.is_null() & ~empty).arg_true()
        if len(wrong):
            row = int(wrong[0])
            raise DataFileError(
                f"{path}: row {row + 1}, column {label}: {shown(column[row])} is not a number"
            )
    elif column.dtype.is_numeric() or column.dtype == pl.Null:
        numbers = column.cast(pl.Float64)
    else:
        raise DataFileError(f"{path}: column {label} has type {column.dtype}: allowed are numbers")
    values = numbers.fill_null(float("nan")).to_numpy().astype(np.float64)
    infinite = np.flatnonzero(np.isinf(values))
    if infinite.size:
        raise DataFileError(f"{path}: row {infinite[0] + 1}, column {label}: infinite")
    return values


def shown(text: str) -> str:
    """Return a text in quotes for a message, cut where it is long."""
    return repr(text if len(text) <= 40 else f"{text[:37]}...")


def labels_of(path: str, frame: pl.DataFrame) -> pl.Series:
    """Return the run label of every row, as text; "0" without a column of labels."""
    import polars as pl

    if "run" not in frame.columns:
        return pl.repeat("0", frame.height, eager=True)
    column = frame["run"]
    if column.dtype.is_nested() or column.dtype in (pl.Binary, pl.Object):
        raise DataFileError(
            f"{path}: column run has type {column.dtype}: allowed are text and numbers"
        )
    if column.dtype.is_float():
        whole = column.cast(int, strict=False)
        if bool((whole.cast(column.dtype) == column).fill_null(value=False).all()):
            column = whole
    labels = column.cast(str)
    missing = labels.is_null().arg_true()
    if len(missing):
        raise DataFileError(f"{path}: row {int(missing[0]) + 1}, column run: no label")
    long = (labels.str.len_chars() > _LONGEST).arg_true()
    if len(long):
        raise DataFileError(
            f"{path}: row {int(long[0]) + 1}, column run: a label of more than {_LONGEST} "
            "characters"
        )
    return labels


def check_units(units: Mapping[str, str], names: Sequence[str]) -> None:
    """Refuse units of columns that there are not."""
    for name in units:
        if name not in names:
            raise InputError(f"unit: {unknown('column', name, names)}")


def check_units_used(units: Mapping[str, str], tables: Sequence[Table]) -> None:
    """Refuse units of columns that none of some tables has."""
    there = list(dict.fromkeys(name for table in tables for name in table.frame.columns))
    for name in units:
        if name not in there:
            where = tables[0].path if len(tables) == 1 else f"none of {len(tables)} files"
            no = "no" if len(tables) == 1 else "a"
            raise InputError(f"unit: {where} has {no} column {name}: there are {listed(there)}")


def number_columns(
    table: Table, units: Mapping[str, str] | None = None
) -> tuple[dict[str, NDArray[np.float64]], bool]:
    """Return the columns of numbers in SI units, and whether times are those of a calendar.

    `units` come before those that the file states itself. Dates and Unix time count from the
    first one, and a notice says so.
    """
    found = {}
    calendar = False
    for name, allowed in table.wanted.items():
        if not allowed or name not in table.frame.columns:
            continue
        given = (units or {}).get(name)
        unit = given or table.units.get(name, "")
        try:
            scale = factor(name, unit or allowed[0], allowed)
        except InputError as error:
            # What the user gives is an argument, what the file states is not.
            raise (error if given else table.refused(f"{table.path}: {error}")) from None
        if name == "t":
            found[name], calendar = _times(table, scale, stated=bool(unit))
        else:
            found[name] = scaled(
                number_column(table.path, table.frame[name], table.labels[name]), scale
            )
    return found, calendar


def scaled(values: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
    """Return values in SI units; those that are keep their bits."""
    return values if scale == 1.0 else values * scale


def _times(table: Table, scale: float, *, stated: bool) -> tuple[NDArray[np.float64], bool]:
    """Return times in s, and whether they are those of a calendar, then from the first one on."""
    column, label = table.frame["t"], table.labels["t"]
    since = f"{table.path}: {label or '(no name)'} is %s: times count from the start of each run"
    if clock.are_dates(column):
        table.notices.append(since % "a date and time")
        return clock.dates(table.path, column, label), True
    if clock.is_span(column):
        return clock.spans(column), False
    times = scaled(number_column(table.path, column, label), scale)
    if clock.is_unix(times):
        table.notices.append(since % "Unix time")
        near = number_column(table.path, clock.from_first(column), label)
        return scaled(near, scale), True
    if not stated and (unit := clock.finer(times)):
        raise DataFileError(
            f"{table.path}: column {label}: {times[0]:.10g} is no time in s: "
            f"--unit t={unit} takes it as Unix time in {unit}"
        )
    return times, False


def check_complete(
    where: str, name: str, values: NDArray[np.float64], rows: NDArray[np.intp]
) -> None:
    """Refuse missing values; `rows` are theirs in the file."""
    gone = np.flatnonzero(np.isnan(values))
    if gone.size:
        raise DataFileError(f"{where}row {rows[gone[0]] + 1}, column {name}: missing")


def check_rising(where: str, times: NDArray[np.float64], rows: NDArray[np.intp]) -> None:
    """Refuse times that do not rise; `rows` as in `check_complete`."""
    back = np.flatnonzero(np.diff(times) <= 0.0)
    if back.size:
        at = back[0] + 1
        raise DataFileError(
            f"{where}row {rows[at] + 1}, column t: {times[at]:g} s after {times[at - 1]:g} s, "
            "time must rise"
        )


def rows_of(table: Table) -> dict[str, NDArray[np.intp]]:
    """Return the rows of each label, wherever they stand, in the order of first rows."""
    import polars as pl

    labels = labels_of(table.path, table.frame).alias("label")
    groups = pl.DataFrame({"label": labels, "row": np.arange(labels.len(), dtype=np.intp)})
    found = groups.group_by("label", maintain_order=True).agg("row").iter_rows()
    return {label: np.array(rows, dtype=np.intp) for label, rows in found}


def rows_by_run(
    table: Table,
    t: NDArray[np.float64],
    wanted: Collection[str] | None = None,
    stamps: MendStamps | None = None,
    *,
    from_start: bool = False,
) -> Iterator[tuple[str, str, NDArray[np.intp], NDArray[np.float64]]]:
    """Yield label, name in messages, rows and times of every run, in the order of first rows.

    Times are those of `t`, or what `stamps` makes of them, and `from_start` those since the
    first one of the run.

    Raises
    ------
    DataFileError
        Fewer than 20 samples in a run, or time that is missing or does not rise.
    InputError
        No run of a label that is wanted.
    """
    there = rows_of(table)
    for label in wanted or ():
        if label not in there:
            raise InputError(f"runs: {unknown('run', label, list(there))}")
    for label, rows in there.items():
        if wanted is not None and label not in wanted:
            continue
        where = f"{table.path}: run {label}"
        if rows.size < LEAST_SAMPLES:
            raise DataFileError(
                f"{where}: {rows.size} samples, allowed are {LEAST_SAMPLES} or more"
            )
        check_complete(f"{where}, ", "t", t[rows], rows)
        times = t[rows] - t[rows[0]] if from_start else t[rows]
        times = times if stamps is None else stamps(label, times)
        check_rising(f"{where}, ", times, rows)
        yield label, where, rows, times
