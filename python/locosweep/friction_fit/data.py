"""Measured friction: motion and friction force, run by run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import DataFileError, InputError
from locosweep.files.columns import check_units, check_units_used, number_columns, rows_by_run
from locosweep.files.table import listed, read_table

if TYPE_CHECKING:
    import os
    from collections.abc import Collection, Mapping

    import polars as pl
    from numpy.typing import NDArray

    from locosweep.files.csv_form import CsvForm

COLUMNS = {
    "run": "label of the run",
    "t": "time [s]",
    "x": "position [m]",
    "v": "velocity [m/s]",
    "force": "friction force [N], with the sign of the motion that it opposes",
    "drive": "force of the drive [N], from which friction follows where the mass is known",
    "load": "load that presses the surfaces together [N]",
}
"""Columns of a data file."""

_UNITS = {
    "run": (),
    "t": ("s",),
    "x": ("m", "rad"),
    "v": ("m/s", "rad/s"),
    "force": ("N", "N m"),
    "drive": ("N", "N m"),
    "load": ("N",),
}
"""Allowed units; those of a rotary bench as well."""


@dataclass(frozen=True)
class FrictionRun:
    """One measured run as it stands in the file, in SI units.

    Arrays have the shape (n,): times `t`, strictly rising, and `columns` by name, NaN
    where a value is missing.
    """

    label: str
    t: NDArray[np.float64]
    columns: dict[str, NDArray[np.float64]]


def read_friction(
    data: str | os.PathLike[str] | pl.DataFrame | Mapping[str, object],
    *,
    mass: float | None = None,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    runs: Collection[str] | None = None,
    form: CsvForm | None = None,
) -> tuple[list[FrictionRun], list[str]]:
    """Read measured friction from a file, a frame or arrays, one row a sample.

    Columns are those of `COLUMNS`: ``t``, ``x`` or ``v``, ``force`` or with a mass [kg]
    ``drive``, and optionally ``run`` and ``load``. `columns` maps our names to those of the
    data, `units` gives units other than SI, `runs` the labels of the runs to take, `form` what
    the text of a CSV file leaves open. Returns the runs in the order of their first rows, and
    notices of what was unexpected but readable.

    Raises
    ------
    DataFileError
        Not readable, a column missing, text or an infinite value among numbers,
        time that does not rise, fewer than 20 samples in a run.
    InputError
        An unknown column, unit or run.

    Examples
    --------
    >>> import numpy as np
    >>> from locosweep.friction_fit import read_friction
    >>> t = np.linspace(0, 1, 50)
    >>> found, notices = read_friction({"t": t, "v": np.cos(t), "force": 0 * t + 2})
    >>> found[0].label, sorted(found[0].columns)
    ('0', ['force', 'v'])
    """
    columns, units = dict(columns or {}), dict(units or {})
    check_units(units, [name for name, allowed in _UNITS.items() if allowed])
    table = read_table(data, _UNITS, ("t",), columns, form)
    check_units_used(units, [table])
    name, frame, others = table.path, table.frame, table.others
    for either in (("x", "v"), ("force", "drive")):
        if not set(either) & set(frame.columns):
            there = listed([*frame.columns, *others])
            one, other = (columns.get(c, c) for c in either)
            raise DataFileError(
                f"{name}: no column {one}, and no {other} either: there are {there}"
            )
    if "force" not in frame.columns and mass is None:
        raise InputError(
            "mass is missing: friction is the drive force less mass times acceleration, "
            "allowed is a mass in kg or a column force"
        )
    numbers, calendar = number_columns(table, units)
    for column, values in numbers.items():
        if np.isnan(values).all():
            raise DataFileError(f"{name}: column {table.labels[column]}: no values")
    notices = [f"{name}: columns not used: {listed(others)}"] if others else []
    notices += table.notices
    found = []
    for label, _, rows, t in rows_by_run(table, numbers["t"], runs, from_start=calendar):
        rest = {column: values[rows] for column, values in numbers.items() if column != "t"}
        found.append(FrictionRun(label, t, rest))
    return found, notices
