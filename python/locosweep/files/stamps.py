"""Times of measured runs: numbers, Unix time, or dates as ISO 8601 and Germans write them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import DataFileError
from locosweep.files.csv_text import MISSING

if TYPE_CHECKING:
    import polars as pl
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

UNIX = (9.4e8, 4.2e9)
"""Unix time in s from 1999 to 2103. A run that starts so late after its own start does not exist:
it would have lasted 30 years."""
_SLOWEST = 1.0
"""Longest usual step of Unix time in s. Counters of us or ns since a start may be as large as Unix
time, but then step by far more: no rig takes a sample a second."""
_DAY, _GERMAN_DAY = r"\d{4}-\d\d-\d\d", r"(\d\d)\.(\d\d)\.(\d{4})"
_DATE = rf"^(({_DAY}|{_GERMAN_DAY})[T ]\d\d:\d\d|\d\d:\d\d:\d\d)"
ALLOWED_DATES = "2026-11-25T12:53:01.25, 25.11.2026 12:53:01,25 or 12:53:01.25"
_ZONE = r"(Z|[+-]\d\d:?\d\d)$"
_DIGITS = 9
"""Decimal digits of a second that are kept of a Unix time: nanoseconds."""
_FINER = {"ms": 1e3, "us": 1e6, "ns": 1e9}


def are_dates(column: pl.Series) -> bool:
    """Return whether a column holds dates and times, as a type or as text."""
    import polars as pl

    if column.dtype != pl.String:
        return column.dtype in (pl.Date, pl.Datetime)
    text = column.drop_nulls().str.strip_chars()
    known = text.filter(~text.str.to_lowercase().is_in(MISSING)).head(1)
    return bool(known.len()) and re.match(_DATE, known[0]) is not None


def is_span(column: pl.Series) -> bool:
    """Return whether a column holds spans of time as a type."""
    import polars as pl

    return column.dtype == pl.Duration


def spans(column: pl.Series) -> Floats:
    """Return spans of time in s."""
    import polars as pl

    seconds = column.dt.total_nanoseconds().cast(pl.Float64) / 1e9
    values: Floats = seconds.fill_null(np.nan).to_numpy()
    return values


def dates(path: str, column: pl.Series, label: str) -> Floats:
    """Return seconds since the earliest of the dates in a column of text or of times.

    DataFileError for text that is none, with its row.
    """
    import polars as pl

    if column.dtype == pl.String:
        text = column.str.strip_chars().str.replace(" ", "T", literal=True)
        text = text.str.replace(",", ".", literal=True)
        text = text.str.replace(f"^{_GERMAN_DAY}T", "${3}-${2}-${1}T")
        # A time of day alone: which day it was does not matter.
        text = text.str.replace(r"^(\d\d:)", "1970-01-01T$1")
        zone = text.str.extract(_ZONE)
        bare = text.str.replace(_ZONE, "")
        parsed = bare.str.to_datetime("%Y-%m-%dT%H:%M:%S%.f", time_unit="ns", strict=False)
        parsed = parsed.fill_null(
            bare.str.to_datetime("%Y-%m-%dT%H:%M", time_unit="ns", strict=False)
        )
        empty = text.is_null() | text.str.to_lowercase().is_in(MISSING)
        wrong = (parsed.is_null() & ~empty).arg_true()
        if len(wrong):
            row = int(wrong[0])
            raise DataFileError(
                f"{path}: row {row + 1}, column {label}: {column[row]!r} is no date and time, "
                f"others are: allowed is {ALLOWED_DATES}"
            )
        zoned = zone.is_not_null() | empty
        if zone.is_not_null().any() and not zoned.all():
            row = int((~zoned).arg_true()[0])
            raise DataFileError(
                f"{path}: row {row + 1}, column {label}: {column[row]!r} has no time zone, "
                "others have"
            )
        nanoseconds = parsed.cast(pl.Int64) - _offsets(zone)
    else:
        nanoseconds = column.cast(pl.Datetime("ns")).cast(pl.Int64)
    first = nanoseconds.min()
    return (nanoseconds - first).cast(pl.Float64).fill_null(np.nan).to_numpy() / 1e9


def _offsets(zone: pl.Series) -> pl.Series:
    """Return what a time zone is ahead of UTC, in ns."""
    import polars as pl

    digits = zone.str.replace_all(r"[^0-9]", "")
    hours = digits.str.slice(0, 2).cast(pl.Int64, strict=False).fill_null(0)
    minutes = digits.str.slice(2, 2).cast(pl.Int64, strict=False).fill_null(0)
    sign = pl.Series([-1 if z is not None and z[0] == "-" else 1 for z in zone.to_list()])
    return sign * (hours * 60 + minutes) * 60_000_000_000


def from_first(column: pl.Series) -> pl.Series:
    """Return numbers less the whole part of the first one, without loss of their last digits.

    Unix time has more digits than a float: 0.2 us are the least it can show.
    """
    import polars as pl

    if column.dtype.is_integer():
        first = column.drop_nulls()
        return column.cast(pl.Int64) - int(first[0]) if first.len() else column
    if column.dtype == pl.String:
        exact = column.str.strip_chars().cast(pl.Decimal(38, _DIGITS), strict=False)
        numbers = column.str.strip_chars().cast(pl.Float64, strict=False)
        # An exponent, or a word for a missing value, is no decimal.
        if (exact.is_not_null() == numbers.is_not_null()).all():
            first = exact.drop_nulls()
            return exact - first[0].__floor__() if first.len() else column
    return column


def is_unix(times: Floats) -> bool:
    """Return whether times in s count from 1970."""
    known = times[np.isfinite(times)]
    within = known.size > 1 and known.min() > UNIX[0] and known.max() < UNIX[1]
    return bool(within and np.median(np.diff(known)) <= _SLOWEST)


def finer(times: Floats) -> str:
    """Return the unit in which numbers would be Unix time, at most one; empty without one."""
    return next((unit for unit, scale in _FINER.items() if is_unix(times / scale)), "")
