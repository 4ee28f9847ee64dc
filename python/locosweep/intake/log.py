"""A log of one's own as runs in SI units: what was guessed, why, and how noisy the readings are."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.data.noise import noise_of
from locosweep.diagnosis.data.readings.columns import LARGEST
from locosweep.errors import DataFileError, InputError
from locosweep.files.channels import CHANNELS
from locosweep.files.columns import (
    LEAST_SAMPLES,
    check_units,
    check_units_used,
    number_columns,
    rows_of,
)
from locosweep.files.csv_form import CsvForm
from locosweep.files.runs import Run, wanted_columns
from locosweep.files.sources import files_of, names_of
from locosweep.files.table import listed
from locosweep.files.units import factor
from locosweep.intake.guess import NEEDED
from locosweep.intake.names import fits
from locosweep.intake.sheet import opened
from locosweep.intake.units import is_angle, settled_units
from locosweep.registry import unknown

if TYPE_CHECKING:
    from collections.abc import Mapping

    import polars as pl
    from numpy.typing import NDArray

    from locosweep.diagnosis.data.noise import Noise
    from locosweep.files.table import Table
    from locosweep.intake.sheet import Sheet
    from locosweep.intake.units import Reasoned

    Floats = NDArray[np.float64]

PAUSE, _STEPS = 1.0, 100.0
"""Least length in s, and in usual steps, of a pause that ends a run: stretches that a log loses are
shorter (a buffer of 100 samples), and a rig that is set up anew takes longer."""
_LATE = 3.0
"""Usual steps by which rows may go back and belong to the same run: packets overtake each other by
so much. A clock that begins anew goes back by a run, which has 20 samples or more."""
_LEVEL = 1.0
"""Degrees by which a slope may vary within a run: so much a tilt sensor shakes."""
_NO_NOISE = 1e-8
"""Share of a channel's span below which its noise is that of computed numbers: 26 bits, and no
sensor of a rig resolves more than 24."""


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
        return "x" in self.units and is_angle(self.units["x"])

    @property
    def drive_in_force(self) -> bool:
        """True if the drive counts in N, or N m where positions are angles."""
        return fits("drive", self.units["drive"], ["N m" if self.rotary else "N"])


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
    if pause is not None and not pause > 0.0:
        raise InputError(f"pause is {pause}: allowed is a number of seconds above 0")
    files = files_of(data)
    columns, units = dict(columns or {}), dict(units or {})
    wanted = wanted_columns()
    for role in columns:
        if role not in wanted:
            raise InputError(f"column: {unknown('column', role, wanted)}")
    check_units(units, [name for name, allowed in wanted.items() if allowed])
    sheets = [opened(path, columns, units, form or CsvForm()) for path in files]
    check_units_used(units, [sheet.table for sheet in sheets])
    settled = settled_units(sheets, units)
    parts: list[Run] = []
    notes: list[str] = []
    names = names_of(files) if len(files) > 1 else [""]
    for sheet, own, name in zip(sheets, settled, names, strict=True):
        _check_wanted(sheet, own)
        numbers, _ = number_columns(sheet.table, {role: unit for role, (unit, _) in own.items()})
        for role in NEEDED:
            if not np.isfinite(numbers[role]).any():
                raise DataFileError(f"{sheet.path}: column {sheet.names[role]}: no values")
        _check_sizes(sheet.table, numbers)
        runs, said = _runs(sheet.table, numbers, name, pause)
        parts += runs
        told = [*_guesses(sheet, own), *sheet.table.notices, *said]
        notes += [note for note in told if note not in notes]
    frame, noise = _joined(parts), _noise(parts)
    columns = {role: name for sheet in reversed(sheets) for role, name in sheet.names.items()}
    units = {role: unit for own in reversed(settled) for role, (unit, _) in own.items()}
    log = Log(frame, notes, columns, units, noise, len(parts))
    for channel in CHANNELS:
        if channel in noise:
            one, unit = noise[channel], CHANNELS[channel].unit_on(rotary=log.rotary)
            parts_of = {"noise": one.gaussian, "steps": one.step}
            shown = (f"{what} of {size:.2g} {unit}" for what, size in parts_of.items() if size)
            notes.append(f"{channel}: {', '.join(shown)}")
        elif channel in columns:
            notes.append(f"{channel}: no noise to be seen, as in computed numbers")
    return log


def _guesses(sheet: Sheet, units: Mapping[str, Reasoned]) -> list[str]:
    """Return what each column is and why, and what is not used."""
    said = []
    for role, name in sheet.names.items():
        unit, because = units.get(role, ("", ""))
        measured = f", in {unit} ({because})" if unit else ""
        said.append(
            f"{role} is {name or 'the column without a name'} ({sheet.why[role]}){measured}"
        )
    if sheet.table.others:
        said.append(f"not used: {listed([name or '(no name)' for name in sheet.table.others])}")
    return [*said, *sheet.left]


def _check_wanted(sheet: Sheet, units: Mapping[str, Reasoned]) -> None:
    """Refuse units that measure something else on this kind of rig."""
    wanted = wanted_columns(rotary=is_angle(units["x"][0]))
    for role, (unit, _) in units.items():
        try:
            factor(role, unit, wanted[role])
        except InputError as error:
            raise InputError(f"{sheet.path}: {sheet.names[role]}: {error}") from None


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
    labelled = "run" in table.frame.columns
    groups = {label: rows[np.isfinite(t[rows])] for label, rows in rows_of(table).items()}
    forward = np.concatenate([np.diff(t[rows]) for rows in groups.values()])
    forward = forward[forward > 0.0]
    usual = float(np.median(forward)) if forward.size else 0.0
    # Labels say where runs end: only a pause that is asked for cuts them.
    longest = pause if pause is not None else (np.inf if labelled else max(PAUSE, _STEPS * usual))
    notes, runs, short = [], [], []
    if untimed := int(np.isnan(t).sum()):
        notes.append(f"{table.path}: rows without a time, left out: {untimed}")
    for label, rows in groups.items():
        steps = np.diff(t[rows])
        ends = (steps < -_LATE * usual) | (steps > longest)
        parts = np.split(rows, np.flatnonzero(ends) + 1)
        for count, part in enumerate(parts):
            own = ".".join(
                [*([label] if labelled else []), *([str(count)] if len(parts) > 1 else [])]
            )
            name = ":".join(word for word in (file, own) if word) or "0"
            late = int((np.diff(t[part]) < 0.0).sum())
            part = part[np.argsort(t[part], kind="stable")]
            if part.size < LEAST_SAMPLES:
                short.append(f"{name} ({part.size})")
                continue
            channels = {c: numbers[c][part] for c in CHANNELS if c in numbers}
            slope, said = _slope(table, numbers, part, name)
            notes += said
            if late:
                notes.append(f"run {name}: rows that came late, put in their place: {late}")
            undriven = int(np.isnan(numbers["drive"][part]).sum())
            if undriven:
                gone = f"{undriven} of {part.size} rows have no drive"
                notes.append(f"run {name}: {gone}: a diagnosis holds the one before")
            runs.append(Run(name, t[part] - t[part[0]], numbers["drive"][part], channels, slope))
    if not runs:
        raise DataFileError(f"{table.path}: no run of {LEAST_SAMPLES} samples or more")
    if short:
        notes.append(f"too few samples for a run, left out: {listed(short)}")
    names = [run.label for run in runs]
    if len(set(names)) < len(names):
        runs = [replace(run, label=f"{run.label}.{k}") for k, run in enumerate(runs)]
    how = ["by their labels"] if labelled else []
    if not labelled or len(runs) + len(short) > len(groups):
        pauses = f" or pauses for {longest:.3g} s" if np.isfinite(longest) else ""
        how.append(f"cut where time jumps back{pauses}")
    if len(runs) > 1:
        notes.insert(0, f"{len(runs)} runs in {table.path}, {' and '.join(how)}")
    return runs, notes


def _slope(
    table: Table, numbers: Mapping[str, Floats], rows: NDArray[np.intp], run: str
) -> tuple[float | None, list[str]]:
    """Return the slope of a run, and what is to be said of it."""
    if "slope_deg" not in numbers:
        return None, []
    known = numbers["slope_deg"][rows]
    known = known[np.isfinite(known)]
    if not known.size:
        return None, []
    low, high, middle = float(known.min()), float(known.max()), float(np.median(known))
    if high - low > _LEVEL:
        raise DataFileError(
            f"{table.path}: run {run}, column {table.labels['slope_deg']}: {low:.4g} to "
            f"{high:.4g} deg, allowed is one slope per run, within {_LEVEL:g} deg"
        )
    said = f"slope_deg of run {run} is {low:.4g} to {high:.4g} deg: {middle:.4g} is taken"
    return middle, [said] if high > low else []


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
    """Return the noise of each channel that shows some."""
    found = {}
    for name in CHANNELS:
        own = [run for run in runs if name in run.channels]
        known = [run.channels[name][np.isfinite(run.channels[name])] for run in own]
        known = [values for values in known if values.size >= LEAST_SAMPLES]
        span = max((float(np.ptp(values)) for values in known), default=0.0)
        if span > 0.0:
            noise = noise_of(name, own, {})
            if noise.gaussian <= _NO_NOISE * span:
                noise = replace(noise, gaussian=0.0)
            if noise.gaussian or noise.step:
                found[name] = noise
    return found
