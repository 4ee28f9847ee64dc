"""Data files of others: plain columns of CSV and Parquet, read with suspicion."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import DataFileError, InputError
from locosweep.registry import unknown

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Collection, Iterator, Sequence

    import polars as pl
    from numpy.typing import NDArray

    MendStamps = Callable[[str, NDArray[np.float64]], NDArray[np.float64]]
    """From label and times of a run to times that rise, or those given."""

UNITS = {
    "m": 1.0,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "inch": 0.0254,
    "s": 1.0,
    "ms": 1e-3,
    "us": 1e-6,
    "N": 1.0,
    "mN": 1e-3,
    "kN": 1e3,
    "N m": 1.0,
    "rad": 1.0,
    "deg": np.pi / 180.0,
    "m/s": 1.0,
    "cm/s": 1e-2,
    "mm/s": 1e-3,
    "rad/s": 1.0,
    "deg/s": np.pi / 180.0,
    "W": 1.0,
    "mW": 1e-3,
    "1": 1.0,
    "percent": 1e-2,
}
"""Factors to the SI unit of a column."""
_LEAST = 20
"""Samples that a run needs."""


def checksum(path: str | os.PathLike[str]) -> str:
    """Return the SHA-256 of a file, in hexadecimal digits."""
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError as error:
        raise DataFileError(f"{path}: {error.strerror or error}") from None


def _file(path: Path) -> pl.DataFrame:
    """Read a Parquet file, or any other as CSV, whose columns stay text."""
    import polars as pl

    if not path.is_file():
        raise DataFileError(f"{path}: no such file")
    try:
        if path.suffix == ".parquet":
            return pl.read_parquet(path)
        # As text: a number that is none is then found with its row.
        frame = pl.read_csv(path, infer_schema=False, truncate_ragged_lines=False)
        return frame.rename(str.strip)
    except pl.exceptions.NoDataError:
        raise DataFileError(f"{path}: empty, allowed is at least a line of names") from None
    except (OSError, pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        first = str(error).splitlines()[0] if str(error) else type(error).__name__
        kind = "Parquet" if path.suffix == ".parquet" else "CSV"
        raise DataFileError(f"{path}: not a readable {kind} file: {first}") from None


def _frame(data: pl.DataFrame | Mapping[str, object]) -> pl.DataFrame:
    import polars as pl

    try:
        return data if isinstance(data, pl.DataFrame) else pl.DataFrame(dict(data))
    except (pl.exceptions.PolarsError, TypeError, ValueError) as error:
        first = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(f"data: not columns of one length: {first}") from None


def read_frame(
    data: str | os.PathLike[str] | pl.DataFrame | Mapping[str, object],
    wanted: Collection[str],
    needed: Collection[str],
    columns: Mapping[str, str] | None = None,
) -> tuple[pl.DataFrame, list[str]]:
    """Return the wanted columns of a file, a frame or arrays by our names, and the others' names.

    `needed` columns must be there; `columns` maps our names to those of the file. Refuses
    what cannot be read, is empty, or lacks a column or has it twice: a file with
    DataFileError, a frame with InputError.
    """
    import polars as pl

    columns = dict(columns or {})
    for name in columns:
        if name not in wanted:
            raise InputError(f"column: {unknown('column', name, wanted)}")
    if isinstance(data, pl.DataFrame | Mapping):
        path, frame, refused = "data", _frame(data), InputError
    else:
        path, frame, refused = str(Path(data)), _file(Path(data)), DataFileError
    theirs = {name: columns.get(name, name) for name in wanted}
    for name in frame.columns:
        if name.removesuffix("_duplicated_0") in theirs.values() and name not in theirs.values():
            twice = name.removesuffix("_duplicated_0")
            raise refused(f"{path}: column {twice} is there twice")
    for name in (*needed, *columns):
        if theirs[name] not in frame.columns:
            hint = "" if theirs[name] == name else f" (given for {name})"
            there = ", ".join(frame.columns[:20])
            raise refused(f"{path}: no column {theirs[name]}{hint}: there are {there}")
    if frame.height == 0:
        raise refused(f"{path}: no rows")
    present = {theirs[name]: name for name in wanted if theirs[name] in frame.columns}
    others = [name for name in frame.columns if name not in present]
    return frame.select(list(present)).rename(present), others


def number_column(
    path: str | os.PathLike[str],
    frame: pl.DataFrame,
    name: str,
    unit: str | None = None,
    *,
    label: str | None = None,
) -> NDArray[np.float64]:
    """Return one column as numbers, missing ones as NaN.

    Raises
    ------
    DataFileError
        Text or an infinite value, with its row (the first below the names is 1).
    """
    import polars as pl

    column, label = frame[name], label or name
    if column.dtype == pl.String:
        text = column.str.strip_chars()
        empty = text.is_null() | text.str.to_lowercase().is_in(["", "nan", "na", "null"])
        numbers = text.cast(pl.Float64, strict=False)
        wrong = (numbers.is_null() & ~empty).arg_true()
        if len(wrong):
            row = int(wrong[0])
            raise DataFileError(
                f"{path}: row {row + 1}, column {label}: {column[row]!r} is not a number"
            )
    elif column.dtype.is_numeric():
        numbers = column.cast(pl.Float64)
    else:
        raise DataFileError(f"{path}: column {label} has type {column.dtype}: allowed are numbers")
    values = numbers.fill_null(float("nan")).to_numpy().astype(np.float64)
    infinite = np.flatnonzero(np.isinf(values))
    if infinite.size:
        raise DataFileError(f"{path}: row {infinite[0] + 1}, column {label}: infinite")
    if unit is None:
        return values
    if unit not in UNITS:
        raise InputError(f"unit of {name}: {unknown('unit', unit, UNITS)}")
    return values * UNITS[unit]


def label_of(path: str | os.PathLike[str], frame: pl.DataFrame) -> list[str]:
    """Return the run label of every row, as text; "0" without a column of labels."""
    if "run" not in frame.columns:
        return ["0"] * frame.height
    column = frame["run"]
    if column.dtype.is_float():
        whole = column.cast(int, strict=False)
        if bool((whole.cast(column.dtype) == column).fill_null(value=False).all()):
            column = whole
    labels = column.cast(str)
    missing = labels.is_null().arg_true()
    if len(missing):
        raise DataFileError(f"{path}: row {int(missing[0]) + 1}, column run: no label")
    return labels.to_list()


def check_units(units: Mapping[str, str], names: Sequence[str]) -> None:
    """Refuse units of columns that there are not."""
    for name in units:
        if name not in names:
            raise InputError(f"unit: {unknown('column', name, names)}")


def number_columns(
    path: str | os.PathLike[str],
    frame: pl.DataFrame,
    names: Sequence[str],
    units: Mapping[str, str] | None = None,
    columns: Mapping[str, str] | None = None,
) -> dict[str, NDArray[np.float64]]:
    """Return those of `names` that a frame has, as numbers in SI units."""
    units, columns = units or {}, columns or {}
    return {
        name: number_column(path, frame, name, units.get(name), label=columns.get(name))
        for name in names
        if name in frame.columns
    }


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


def rows_by_run(
    path: str,
    frame: pl.DataFrame,
    t: NDArray[np.float64],
    wanted: Collection[str] | None = None,
    stamps: MendStamps | None = None,
) -> Iterator[tuple[str, str, NDArray[np.intp], NDArray[np.float64]]]:
    """Yield label, name in messages, rows and times of every run, in the order of first rows.

    Times are those of `t`, or what `stamps` makes of them.

    Raises
    ------
    DataFileError
        Fewer than 20 samples in a run, or time that is missing or does not rise.
    InputError
        No run of a label that is wanted.
    """
    labels = np.array(label_of(path, frame))
    there = list(dict.fromkeys(labels.tolist()))
    for label in wanted or ():
        if label not in there:
            raise InputError(f"runs: {unknown('run', label, there)}")
    for label in there:
        if wanted is not None and label not in wanted:
            continue
        rows = np.flatnonzero(labels == label)
        where = f"{path}: run {label}"
        if rows.size < _LEAST:
            raise DataFileError(f"{where}: {rows.size} samples, allowed are {_LEAST} or more")
        check_complete(f"{where}, ", "t", t[rows], rows)
        times = t[rows] if stamps is None else stamps(label, t[rows])
        check_rising(f"{where}, ", times, rows)
        yield label, where, rows, times
