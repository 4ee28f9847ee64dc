"""Measured runs: drive commands and what the sensors read, run by run."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.errors import DataFileError
from locosweep.files import channels
from locosweep.files.bags import is_bag, read_bag
from locosweep.files.columns import (
    check_units,
    check_units_used,
    labels_of,
    number_columns,
    rows_by_run,
)
from locosweep.files.sources import files_of, is_frame, names_of
from locosweep.files.table import Table, listed, read_table
from locosweep.files.units import DRIVES

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.files.columns import MendStamps
    from locosweep.files.csv_form import CsvForm

CHANNELS = {name: channel.meaning for name, channel in channels.CHANNELS.items()}
"""Measured channels, beside time and drive."""


def wanted_columns(rotary: bool | None = None) -> dict[str, tuple[str, ...]]:
    """Return the allowed units of each column: on a rotary bench, on another rig, or on either."""
    measured = {
        name: (c.unit, c.rotary_unit) if rotary is None else (c.unit_on(rotary=rotary),)
        for name, c in channels.CHANNELS.items()
    }
    return {"run": (), "t": ("s",), "drive": DRIVES, **measured, "slope_deg": ("deg",)}


@dataclass(frozen=True)
class Run:
    """One measured run.

    Attributes
    ----------
    label : str
        Its name in the file.
    t : ndarray
        Times in s, strictly rising.
    drive : ndarray
        Drive command as sent, held until the next sample.
    channels : dict of str to ndarray
        What was measured (`CHANNELS`), in SI units; NaN where a value is missing.
    slope_deg : float or None
        Slope of this run, where it differs from the model's.
    drive_deviation : ndarray or None
        Standard deviation of `drive` where rows miss and it is known only within bounds, 0
        elsewhere; None where all of it is known.
    """

    label: str
    t: NDArray[np.float64]
    drive: NDArray[np.float64]
    channels: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    slope_deg: float | None = None
    drive_deviation: NDArray[np.float64] | None = None

    @property
    def since_start(self) -> NDArray[np.float64]:
        """Seconds since the first sample."""
        since: NDArray[np.float64] = self.t - self.t[0]
        return since

    @property
    def sliding_distance(self) -> float:
        """Distance moved forward since the last rest or turn at the first sample: none is known."""
        return 0.0

    @property
    def start(self) -> tuple[float, float]:
        """Position and speed at which a replay begins.

        The mean of the samples before the drive first changes, as the first one
        carries noise like every other; the speed is the first measured one, and 0
        without any.
        """
        x = self.channels.get("x")
        if x is None or not np.isfinite(x).any():
            position = 0.0
        else:
            changes = np.flatnonzero(self.drive != self.drive[0])
            still = int(changes[0]) + 1 if changes.size and self.drive[0] == 0.0 else 1
            before = x[:still][np.isfinite(x[:still])]
            position = float(before.mean()) if before.size else float(x[np.isfinite(x)][0])
        v = self.channels.get("v")
        known = v[np.isfinite(v)] if v is not None else np.empty(0)
        return position, float(known[0]) if known.size else 0.0

    def at_start(self, channel: str) -> tuple[float, bool, float]:
        """Return a channel's level before the drive first changes, if it is known, and its span."""
        y = self.channels.get(channel, np.full(self.t.size, np.nan))
        changes = np.flatnonzero(self.drive != self.drive[0])
        still = int(changes[0]) + 1 if changes.size and self.drive[0] == 0.0 else 1
        before, known = y[:still][np.isfinite(y[:still])], y[np.isfinite(y)]
        if not known.size:
            return 0.0, False, 0.0
        level = before.mean() if before.size else known[0]
        return float(level), before.size > 0, float(np.ptp(known))


def load_runs(
    data: Any,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    *,
    needs: tuple[str, ...] = ("t", "drive", "x"),
    stamps: MendStamps | None = None,
    form: CsvForm | None = None,
    rotary: bool | None = None,
) -> tuple[list[Run], list[str]]:
    """Read measured runs from CSV or Parquet, long form, one row a sample, or from a bag.

    Parameters
    ----------
    data : path-like, list of path-like, or frame
        A file, several, a folder of them or ``-`` for standard input; or columns in memory: a
        Polars or pandas frame, an Arrow table, a mapping of arrays. What the text of a CSV file
        shows is found from it: separator, decimal character, comments, a row of units. Times
        that are dates or Unix time count from each run's start.
    columns : mapping of str to str, optional
        Their name of a column by ours, for instance ``{"drive": "tau"}``; of a bag, topic and
        field, for instance ``{"drive": "/cmd.effort[0]"}``.
    units : mapping of str to str, optional
        Unit of a column, for instance ``{"x": "mm"}``; what the file states, or SI, where not
        given. It has to measure what the column measures.
    needs : tuple of str
        Columns that must be there.
    stamps : callable, optional
        Given the label and the times of a run, which may repeat, returns times that rise.
    form : CsvForm, optional
        Separator and decimal character, where the text leaves them open.
    rotary : bool, optional
        Whether positions are angles; either is allowed where not given.

    Returns
    -------
    runs : list of Run
        In the order of their first rows. Of several files, one without a column ``run`` is one
        run under the file's name, and labels that come in several have that name before them.
    notices : list of str
        What was not as expected but could be read all the same.

    Raises
    ------
    DataFileError
        Not readable, a column missing, text or an infinite value in a column of
        numbers, a row that is too short or too long, time that does not rise, fewer than 20
        samples in a run: one line with file, run, row and column.
    InputError
        A unit that is none, that measures something else than its column, or of a column that
        is not there.
    """
    columns, units = dict(columns or {}), dict(units or {})
    wanted = wanted_columns(rotary)
    check_units(units, [name for name, allowed in wanted.items() if allowed])
    if is_frame(data):
        table = read_table(data, wanted, needs, columns, name="runs")
        check_units_used(units, [table])
        return _runs(table, units, stamps)
    files = files_of(data)
    tables = [
        read_table(read_bag(path, columns), wanted, needs, name=str(path))
        if is_bag(path)
        else read_table(path, wanted, needs, columns, form)
        for path in files
    ]
    check_units_used(units, tables)
    runs, notices = [], []
    for table in tables if len(tables) == 1 else _named(tables, names_of(files)):
        found, said = _runs(table, units, stamps)
        runs += found
        notices += said
    return runs, notices


def _named(tables: Sequence[Table], names: Sequence[str]) -> list[Table]:
    """Return the tables of several files with labels that differ from file to file."""
    import polars as pl

    labels = [
        labels_of(table.path, table.frame) if "run" in table.frame.columns else None
        for table in tables
    ]
    seen = Counter(one for own in labels if own is not None for one in own.unique())
    seen.update(name for name, own in zip(names, labels, strict=True) if own is None)
    renamed = []
    for table, name, own in zip(tables, names, labels, strict=True):
        frame = table.frame
        if own is None:
            frame = frame.with_columns(run=pl.lit(name))
        elif any(seen[one] > 1 for one in own.unique()):
            frame = frame.with_columns(run=name + ":" + own)
        renamed.append(replace(table, frame=frame))
    return renamed


def runs_from_frame(
    frame: Any, name: str = "runs", *, stamps: MendStamps | None = None
) -> list[Run]:
    """Take measured runs from a frame (`load_runs`) with the columns of a file."""
    table = read_table(frame, wanted_columns(), ("t", "drive", "x"), name=name)
    return _runs(table, {}, stamps)[0]


def _runs(
    table: Table, units: Mapping[str, str], stamps: MendStamps | None
) -> tuple[list[Run], list[str]]:
    numbers, calendar = number_columns(table, units)
    notices = [*table.notices]
    if table.others:
        notices.insert(0, f"{table.path}: columns not used: {listed(table.others)}")
    runs = []
    for label, where, rows, t in rows_by_run(
        table, numbers["t"], stamps=stamps, from_start=calendar
    ):
        drive = _held(numbers["drive"][rows], where, notices)
        measured = {name: numbers[name][rows] for name in CHANNELS if name in numbers}
        slope = _slope(numbers, rows, where)
        runs.append(Run(label, t, drive, measured, slope))
    return runs, notices


def _held(drive: NDArray[np.float64], where: str, notices: list[str]) -> NDArray[np.float64]:
    """Fill missing commands with the one before: that is what a drive does."""
    known = np.isfinite(drive)
    if not known.any():
        raise DataFileError(f"{where}, column drive: no values")
    if known.all():
        return drive
    notices.append(f"{where}: {int((~known).sum())} missing drive values, held from before")
    last = np.maximum.accumulate(np.where(known, np.arange(drive.size), -1))
    return drive[np.where(last < 0, np.flatnonzero(known)[0], last)]


def _slope(
    numbers: Mapping[str, NDArray[np.float64]], rows: NDArray[np.intp], where: str
) -> float | None:
    if "slope_deg" not in numbers:
        return None
    slopes = np.unique(numbers["slope_deg"][rows][np.isfinite(numbers["slope_deg"][rows])])
    if slopes.size > 1:
        raise DataFileError(
            f"{where}, column slope_deg: {slopes[0]:g} and {slopes[1]:g}, allowed is one per run"
        )
    if slopes.size and abs(slopes[0]) > 90.0:
        raise DataFileError(f"{where}, column slope_deg: {slopes[0]:g}, allowed is -90 to 90")
    return float(slopes[0]) if slopes.size else None
