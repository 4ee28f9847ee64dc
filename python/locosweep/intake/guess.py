"""Guesses about the columns of a log: which is which, and in what unit, each with its reason."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import InputError
from locosweep.files import csv_text, stamps
from locosweep.files.csv_form import DECIMALS
from locosweep.files.runs import wanted_columns
from locosweep.files.table import listed
from locosweep.intake.names import ROLES, fits, points, unit_in

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import polars as pl
    from numpy.typing import NDArray

_NEEDED = ("t", "drive", "x")
_RISES = 0.9
"""Share of steps forward from which a column may be time: it goes back where a run begins."""
_LEAST = 20
"""Samples that a run needs: a column with more labels than that allows names no runs."""
_STEP, _FAR = 1.0, 10.0
"""Step of whole-numbered times in s, and span of a position in m, from which they are in
thousandths: rigs take 20 samples a second or more, and move by less than their own size of 10 m."""


def guess_columns(
    names: Sequence[str], frame: pl.DataFrame, columns: Mapping[str, str], path: str
) -> tuple[dict[str, tuple[str, str]], list[str]]:
    """Return their name of each column and why, by ours, and what stays open.

    Parameters
    ----------
    names : sequence of str
        Names in the file.
    frame : polars.DataFrame
        Its columns, in the same order.
    columns : mapping of str to str
        What the user says; it comes first.
    path : str
        What messages call the file.

    Raises
    ------
    InputError
        No column, or several alike, for time, drive or position: with the option that says it.
    """
    found = {role: (name, "as you say") for role, name in columns.items()}
    left = []
    free = [name for name in dict.fromkeys(names) if name not in columns.values()]
    values = dict(zip(names, frame.iter_columns(), strict=True))
    allowed = wanted_columns()
    for role in ROLES:
        if role in found:
            continue
        scores = {name: points(name, role, allowed[role]) for name in free}
        scores = {n: s for n, s in scores.items() if s and _can_be(role, values[n])}
        best = max(scores.values(), default=0)
        ahead = [name for name, score in scores.items() if score == best]
        if role in _NEEDED and len(ahead) > 1:
            raise InputError(
                f"{path}: {role} may be {' or '.join(ahead[:5])}: --column {role}={ahead[0]} "
                "settles it"
            )
        if len(ahead) > 1:
            left.append(f"{role} may be {' or '.join(ahead[:5])}: --column {role}=NAME takes one")
        elif ahead:
            found[role] = (ahead[0], "by its name" if ahead[0] != role else "named so")
            free.remove(ahead[0])
    if "t" not in found:
        rising = [name for name in free if _rises(values[name])]
        if len(rising) == 1:
            found["t"] = (rising[0], "the only column that rises from row to row")
            free.remove(rising[0])
    for role in _NEEDED:
        if role not in found:
            raise InputError(
                f"{path}: no column seems to be {role}: --column {role}=NAME says it, there are "
                f"{listed(free)}"
            )
    return found, left


def guess_units(
    names: Mapping[str, tuple[str, str]],
    stated: Mapping[str, str],
    given: Mapping[str, str],
    values: Mapping[str, NDArray[np.float64]],
    *,
    dates: bool = False,
) -> dict[str, tuple[str, str]]:
    """Return the unit of each column of numbers and why, by our names.

    Parameters
    ----------
    names : mapping
        What `guess_columns` returned.
    stated : mapping of str to str
        Units that the file states in brackets or in a row.
    given : mapping of str to str
        What the user says.
    values : mapping of str to array
        Times and positions as they stand in the file.
    dates : bool
        Whether times are dates.
    """  # fmt: skip
    found = {}
    for role, allowed in wanted_columns().items():
        if role not in names or not allowed:
            continue
        unit = unit_in(names[role][0])[1]
        if role in given:
            found[role] = (given[role], "as you say")
        elif role in stated:
            found[role] = (stated[role], "as the file states")
        elif unit and fits(role, unit, allowed):
            found[role] = (unit, "by its name")
        elif role == "t" and (dates or stamps.is_unix(values["t"])):
            found[role] = ("s", "dates" if dates else "Unix time")
        elif role == "t" and (finer := stamps.finer(values["t"])):
            found[role] = (finer, "as only that makes it Unix time")
        elif role == "t" and _coarse(values["t"]):
            found[role] = ("ms", "as whole-numbered steps of 1 s and more are too long for a rig")
        elif role == "x" and np.ptp(_known(values["x"])) > _FAR:
            span = float(np.ptp(_known(values["x"])))
            found[role] = ("mm", f"as a span of {span:.3g} m is too long for a rig")
        else:
            found[role] = (allowed[0], "nothing says another: check it")
    return found


def numbers_of(column: pl.Series) -> NDArray[np.float64]:
    """Return a column as numbers, NaN for all else; decimal commas are read, too."""
    import polars as pl

    if stamps.are_dates(column):
        try:
            return stamps.dates("", column, "")
        except InputError:
            return np.full(column.len(), np.nan)
    if column.dtype == pl.String:
        text = column.str.strip_chars().str.replace(DECIMALS["comma"], ".", literal=True)
        column = text.cast(pl.Float64, strict=False)
    elif not column.dtype.is_numeric():
        return np.full(column.len(), np.nan)
    values: NDArray[np.float64] = column.cast(pl.Float64).fill_null(np.nan).to_numpy()
    return values


def _can_be(role: str, column: pl.Series) -> bool:
    """Return whether the values of a column allow a role."""
    if role == "run":
        return column.n_unique() * _LEAST <= column.len()
    if role == "t":
        return _rises(column)
    text = column.cast(str).str.strip_chars().str.to_lowercase()
    given = int((~text.fill_null("").is_in(list(csv_text.MISSING))).sum())
    known = int(np.isfinite(numbers_of(column)).sum())
    # The first row may hold units.
    return known > 0 and known >= given - 1


def _rises(column: pl.Series) -> bool:
    known = _known(numbers_of(column))
    steps = np.diff(known)
    return bool(
        known.size >= _LEAST
        and known.size > 0.5 * column.len()
        and (steps >= 0.0).mean() > _RISES
        and (steps > 0.0).mean() > 0.5
    )


def _known(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values[np.isfinite(values)]


def _coarse(t: NDArray[np.float64]) -> bool:
    """Return whether times are whole numbers with steps that are long for seconds."""
    known = _known(t)
    steps = np.diff(known)
    steps = steps[steps > 0.0]
    whole = bool((known == np.round(known)).all())
    return bool(steps.size) and whole and float(np.median(steps)) >= _STEP and not stamps.is_unix(t)
