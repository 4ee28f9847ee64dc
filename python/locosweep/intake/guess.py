"""Guesses about the columns of a file: which is which, each with its reason."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import InputError
from locosweep.files import csv_text, stamps
from locosweep.files.columns import LEAST_SAMPLES, shown
from locosweep.files.csv_form import DECIMALS
from locosweep.files.runs import wanted_columns
from locosweep.files.table import GROUPED, listed, unit_in_cells, units_row, without_unit
from locosweep.intake.names import ANGLES, ROLES, fits, speaks_for, unit_in, words_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import polars as pl
    from numpy.typing import NDArray

NEEDED = ("t", "drive", "x")
_FORWARD, _MOVES = 0.9, 0.5
"""Shares of steps that do not go back, and that go forward, from which a column may be time: it
goes back where a run begins, and stands where a logger rounds it."""


def guess_columns(
    names: Sequence[str],
    frame: pl.DataFrame,
    columns: Mapping[str, str],
    units: Mapping[str, str],
    path: str,
) -> tuple[dict[str, tuple[str, str]], list[str]]:
    """Return their name of each column and why, by ours, and what stays open.

    Parameters
    ----------
    names : sequence of str
        Names in the file.
    frame : polars.DataFrame
        Its columns, in the same order.
    columns, units : mapping of str to str
        What the user says; it comes first.
    path : str
        What messages call the file.

    Raises
    ------
    InputError
        No column, or several alike, for time, drive or position: with the option that says it,
        or with the cell that keeps a column from being one.
    """
    found = {role: (name, "as you say") for role, name in columns.items()}
    left = []
    free = [name for name in dict.fromkeys(names) if name not in columns.values()]
    values = dict(zip(names, frame.iter_columns(), strict=True))
    # A row of units below the names says as much as brackets behind them.
    spelt = {name: _with_unit_below(name, column) for name, column in values.items()}
    rotary: bool | None = None
    for role in ROLES:
        if role not in found:
            wanted = wanted_columns(rotary)
            rank = {name: speaks_for(spelt[name], role, wanted) for name in free}
            spoken = {name: score for name, score in rank.items() if score is not None}
            faults = {name: why_not(role, values[name]) for name in spoken}
            best = max((score for name, score in spoken.items() if not faults[name]), default=None)
            ahead = [n for n, score in spoken.items() if score == best and not faults[n]]
            if len(ahead) == 1:
                name = ahead[0]
                found[role] = (name, "by its name" if name != role else "named so")
                free.remove(name)
            elif role in NEEDED and ahead:
                raise InputError(
                    f"{path}: {role} may be {' or '.join(ahead[:5])}: --column {role}={ahead[0]} "
                    "settles it"
                )
            elif ahead:
                several = " or ".join(ahead[:5])
                left.append(f"{role} may be {several}: --column {role}=NAME takes one")
            elif role == "t" and (rising := _only_rising(free, spelt, values)) is not None:
                found[role] = (rising, "the only column that rises from row to row")
                free.remove(rising)
            elif role in NEEDED:
                raise InputError(f"{path}: {_none(role, faults, free)}")
            else:
                left += [f"{n} is not taken for {role}: {why}" for n, why in faults.items()]
        if role == "x":
            rotary = _is_angle(units.get("x", ""), spelt[found["x"][0]])
    return found, left


def _with_unit_below(name: str, column: pl.Series) -> str:
    """Return a name with the unit in brackets that all cells or the first one give."""
    import polars as pl

    unit = unit_in_cells(column) if column.dtype == pl.String else ""
    if not unit and np.isfinite(numbers_of(column[1:2])).any():
        unit = units_row({name: column}).get(name, "")
    return f"{name} [{unit}]" if unit else name


def _none(role: str, faults: Mapping[str, str], free: Sequence[str]) -> str:
    """Return why no column was found."""
    if faults:
        told = "; ".join(f"{name}: {why}" for name, why in list(faults.items())[:3])
        return f"no column can be {role}: {told}"
    return f"no column seems to be {role}: --column {role}=NAME says it, there are {listed(free)}"


def _is_angle(given: str, name: str) -> bool:
    """Return whether positions are angles, by their unit or their name."""
    unit = given or unit_in(name)[1]
    return fits("x", unit, ["rad"]) if unit else bool(ANGLES & set(words_of(name)))


def _only_rising(
    free: Sequence[str], spelt: Mapping[str, str], values: Mapping[str, pl.Series]
) -> str | None:
    """Return the only column that rises and speaks for nothing; None if it may number rows."""
    wanted = wanted_columns()
    nameless = [n for n in free if not any(speaks_for(spelt[n], role, wanted) for role in ROLES)]
    rising = [name for name in nameless if not why_not("t", values[name])]
    if len(rising) != 1:
        return None
    known = _known(numbers_of(values[rising[0]]))
    return None if bool((np.diff(known) == 1.0).all()) else rising[0]


def numbers_of(column: pl.Series) -> NDArray[np.float64]:
    """Return a column as numbers, NaN for all else; commas are read, too, whatever they are."""
    import polars as pl

    if stamps.are_dates(column):
        try:
            return stamps.dates("", column, "")
        except InputError:
            return np.full(column.len(), np.nan)
    if stamps.is_span(column):
        return stamps.spans(column)
    if column.dtype == pl.String:
        text = without_unit(column, unit_in_cells(column))
        grouped = text.str.contains(GROUPED) & text.str.contains(".", literal=True)
        plain = pl.select(
            pl.when(grouped)
            .then(text.str.replace_all(",", "", literal=True))
            .otherwise(text.str.replace(DECIMALS["comma"], ".", literal=True))
        ).to_series()
        column = plain.cast(pl.Float64, strict=False)
    elif not column.dtype.is_numeric():
        return np.full(column.len(), np.nan)
    values: NDArray[np.float64] = column.cast(pl.Float64).fill_null(np.nan).to_numpy()
    return values


def why_not(role: str, column: pl.Series) -> str:
    """Return what keeps a column from a role: its first cell of text, or what its values do."""
    if role == "run":
        many = column.n_unique()
        few = many * LEAST_SAMPLES <= column.len()
        return "" if few else f"it has {many} labels in {column.len()} rows"
    values = numbers_of(column)
    if stamps.are_dates(column) and not np.isfinite(values).any():
        # Reading names the date that is none.
        return ""
    wrong = _first_text(column, values)
    if wrong:
        dates = f" and no time as in {stamps.ALLOWED_DATES}" if role == "t" else ""
        return f"{wrong}, which is no number{dates}"
    if not np.isfinite(values).any():
        return "it has no numbers"
    return "it does not rise from row to row" if role == "t" and not _rises(values) else ""


def _first_text(column: pl.Series, values: NDArray[np.float64]) -> str:
    """Return row and text of the first cell that is no number; the first row may hold units."""
    import polars as pl

    if column.dtype != pl.String:
        return ""
    missing = column.str.strip_chars().str.to_lowercase().is_in(csv_text.MISSING)
    rows = np.flatnonzero(np.isnan(values) & ~missing.fill_null(value=True).to_numpy())
    above = 1 if rows.size and rows[0] == 0 and units_row({"": column}) else 0
    rows = rows[above:]
    return f"row {rows[0] + 1 - above} has {shown(column[int(rows[0])])}" if rows.size else ""


def _rises(values: NDArray[np.float64]) -> bool:
    known = _known(values)
    steps = np.diff(known)
    return bool(
        known.size >= LEAST_SAMPLES
        and known.size > 0.5 * values.size
        and (steps >= 0.0).mean() > _FORWARD
        and (steps > 0.0).mean() > _MOVES
    )


def _known(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values[np.isfinite(values)]
