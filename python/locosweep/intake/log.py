"""A log of one's own as runs in SI units: what was guessed, why, and how noisy the readings are."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.data.noise import noise_of
from locosweep.diagnosis.data.readings.columns import LARGEST
from locosweep.errors import DataFileError, InputError
from locosweep.files.bags import is_bag
from locosweep.files.channels import CHANNELS
from locosweep.files.columns import check_units, labels_of, number_columns
from locosweep.files.csv_form import CsvForm
from locosweep.files.runs import Run, wanted_columns
from locosweep.files.sources import files_of, names_of
from locosweep.files.stamps import are_dates
from locosweep.files.table import Table, listed, read_table, whole_table
from locosweep.files.units import factor
from locosweep.intake.guess import guess_columns, guess_units, numbers_of
from locosweep.registry import unknown

if TYPE_CHECKING:
    from collections.abc import Mapping

    import polars as pl
    from numpy.typing import NDArray

    from locosweep.diagnosis.data.noise import Noise

    Floats = NDArray[np.float64]

LEAST = 20
"""Samples that a run needs."""
PAUSE, _STEPS = 1.0, 100.0
"""Least length in s, and in steps, of a pause that ends a run: stretches that a log loses are
shorter, and a rig that is set up anew takes longer."""


@dataclass(frozen=True)
class Log:
    """A log that was read: its runs, and what was guessed about it."""

    frame: pl.DataFrame
    """The runs in SI units under the names of the contract."""
    notes: list[str]
    """What was guessed and why, a sentence each."""
    columns: dict[str, str] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    noise: dict[str, Noise] = field(default_factory=dict)
    """Noise of each measured channel, as its readings show it."""
    runs: int = 0

    @property
    def rotary(self) -> bool:
        """True if positions are angles."""
        return "x" in self.units and _is_angle(self.units["x"])

    @property
    def drive_in_force(self) -> bool:
        """True if the drive counts in N, or N m where positions are angles."""
        try:
            factor("drive", self.units["drive"], ["N m" if self.rotary else "N"])
        except InputError:
            return False
        return True


def read_log(
    data: Any,
    *,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    form: CsvForm | None = None,
    pause: float | None = None,
) -> Log:
    r"""Read a log as it was exported, and guess columns, units, runs and noise.

    Parameters
    ----------
    data : path-like or list of path-like
        Files or a folder of them, as for a diagnosis.
    columns, units : mapping of str to str, optional
        Their names of columns by ours, and units: they come before guesses.
    form : CsvForm, optional
        Separator and decimal character, where the text leaves them open.
    pause : float, optional
        Seconds without a sample that end a run; found from the times if not given.

    Returns
    -------
    Log

    Raises
    ------
    DataFileError
        A file that cannot be read, or of which no part has enough samples for a run.
    InputError
        A column that no name tells, or several alike.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from locosweep.intake.log import read_log
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "log.csv"
    >>> rows = [f"{k * 10};0,5;{k / 4:.2f}".replace(".", ",") for k in range(40)]
    >>> _ = file.write_text("\n".join(["Zeit_ms;Soll_N;Weg_mm", *rows]))
    >>> log = read_log(file)
    >>> log.columns
    {'t': 'Zeit_ms', 'drive': 'Soll_N', 'x': 'Weg_mm'}
    >>> log.frame["x"][4], log.runs
    (0.001, 1)
    """
    files = files_of(data)
    columns, units = dict(columns or {}), dict(units or {})
    wanted = wanted_columns()
    for role in columns:
        if role not in wanted:
            raise InputError(f"column: {unknown('column', role, wanted)}")
    check_units(units, [name for name, allowed in wanted.items() if allowed])
    parts, notes = [], []
    seen: tuple[dict[str, str], dict[str, str]] = ({}, {})
    for path, name in zip(files, names_of(files), strict=True):
        if is_bag(path):
            raise InputError(f"{path}: a bag names its topics: locosweep diagnose --map takes it")
        table, own, said = _read(path, columns, units, form or CsvForm())
        notes += [note for note in said if note not in notes]
        for mine, its in zip(seen, own, strict=True):
            mine.update(its)
        numbers, _ = number_columns(table, own[1])
        _check_sizes(table, numbers)
        notes += [note for note in table.notices if note not in notes]
        runs, said = _runs(table, numbers, name if len(files) > 1 else "", pause)
        parts += runs
        notes += said
    frame, noise = _joined(parts), _noise(parts)
    notes += [
        f"{channel}: noise of {one.gaussian:.2g} {_si(channel, seen[1])}"
        + (f", steps of {one.step:.2g}" if one.step else "")
        for channel, one in noise.items()
    ]
    return Log(frame, notes, *seen, noise, len(parts))


def _read(
    path: Path, columns: Mapping[str, str], units: Mapping[str, str], form: CsvForm
) -> tuple[Table, tuple[dict[str, str], dict[str, str]], list[str]]:
    """Return the columns of a file, their names and units, and why these are what they seem."""
    wanted = wanted_columns()
    names, frame = whole_table(path, form)
    for role, name in columns.items():
        if name not in names:
            raise DataFileError(
                f"{path}: no column {name} (given for {role}): there are {listed(names)}"
            )
    there = {name: place for place, name in reversed([*enumerate(names)])}
    frame = frame.select(frame[str(place)].alias(name) for name, place in there.items())
    found, left = guess_columns(list(there), frame, columns, str(path))
    chosen = {role: name for role, (name, _) in found.items()}
    table = read_table(path, wanted, tuple(chosen), chosen, form)
    values = {role: numbers_of(table.frame[role]) for role in ("t", "x")}
    dates = are_dates(table.frame["t"])
    measured = guess_units(found, table.units, units, values, dates=dates)
    said = []
    for role, (name, why) in found.items():
        unit, because = measured.get(role, ("", ""))
        said.append(f"{role} is {name} ({why})" + (f", in {unit} ({because})" if unit else ""))
    said += left
    if table.others:
        said.append(f"not used: {listed(table.others)}")
    return table, (chosen, {role: unit for role, (unit, _) in measured.items()}), said


def _check_sizes(table: Table, numbers: Mapping[str, Floats]) -> None:
    """Refuse numbers whose squares are none."""
    for name, values in numbers.items():
        size = float(np.nanmax(np.abs(values), initial=0.0))
        if size > LARGEST:
            raise DataFileError(
                f"{table.path}: column {table.labels[name]} has {size:.2g}, allowed is up to "
                f"{LARGEST:g}"
            )


def _runs(
    table: Table, numbers: Mapping[str, Floats], file: str, pause: float | None
) -> tuple[list[Run], list[str]]:
    """Cut a file into runs: by labels, and where time jumps back or pauses."""
    t = numbers["t"]
    known = np.flatnonzero(np.isfinite(t))
    labels = labels_of(table.path, table.frame).to_numpy()
    steps = np.diff(t[known])
    usual = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0
    longest = max(PAUSE, _STEPS * usual) if pause is None else pause
    given = "run" in table.frame.columns
    new = labels[known][1:] != labels[known][:-1]
    jumps = (steps < 0.0) | (steps > longest)
    cuts = new if given else jumps
    parts = np.split(known, np.flatnonzero(cuts) + 1)
    notes, runs = [], []
    if known.size < t.size:
        notes.append(f"{t.size - known.size} rows of {table.path} have no time: left out")
    for count, rows in enumerate(parts):
        label = str(labels[rows[0]]) if given and rows.size else str(count)
        label = ":".join(part for part in (file, label if given or len(parts) > 1 else "") if part)
        if rows.size < LEAST:
            notes.append(
                f"{rows.size} samples of {label or 'the log'} are too few for a run: left out"
            )
            continue
        channels = {name: numbers[name][rows] for name in CHANNELS if name in numbers}
        slope = numbers["slope_deg"][rows] if "slope_deg" in numbers else np.array([np.nan])
        level = slope[np.isfinite(slope)]
        runs.append(Run(label or "0", t[rows] - t[rows[0]], numbers["drive"][rows], channels,
                        float(np.median(level)) if level.size else None))  # fmt: skip
    if not runs:
        raise DataFileError(f"{table.path}: no run of {LEAST} samples or more")
    doubled = [run.label for run in runs]
    if len(set(doubled)) < len(doubled):
        runs = [replace(run, label=f"{run.label}.{k}") for k, run in enumerate(runs)]
    how = "by their labels" if given else f"cut where time jumps back or pauses for {longest:.3g} s"
    if len(runs) > 1:
        notes.insert(0, f"{len(runs)} runs in {table.path}, {how}")
    return runs, notes


def _joined(runs: list[Run]) -> pl.DataFrame:
    """Return runs in long form, with the columns that any of them has."""
    import polars as pl

    names = [name for name in CHANNELS if any(name in run.channels for run in runs)]
    sloped = any(run.slope_deg is not None for run in runs)
    parts = []
    for run in runs:
        columns: dict[str, Any] = {"t": run.t, "drive": run.drive}
        columns |= {n: run.channels.get(n, np.full(run.t.size, np.nan)) for n in names}
        frame = pl.DataFrame(columns).fill_nan(None)
        frame = frame.select(pl.lit(run.label).alias("run"), pl.all())
        if sloped:
            frame = frame.with_columns(slope_deg=pl.lit(run.slope_deg, dtype=pl.Float64))
        parts.append(frame)
    return pl.concat(parts)


def _noise(runs: list[Run]) -> dict[str, Noise]:
    found = {}
    for name in CHANNELS:
        own = [run for run in runs if name in run.channels]
        if any(np.isfinite(run.channels[name]).sum() >= LEAST for run in own):
            found[name] = noise_of(name, own, {})
    return found


def _si(channel: str, units: Mapping[str, str]) -> str:
    return CHANNELS[channel].unit_on(rotary=_is_angle(units["x"]))


def _is_angle(unit: str) -> bool:
    try:
        factor("x", unit, ["rad"])
    except InputError:
        return False
    return True
