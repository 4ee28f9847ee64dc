"""All faults of single readings: found in every run, masked, and named."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.checks import usable
from locosweep.diagnosis.data.noise import grain_of, noise_of
from locosweep.diagnosis.data.readings.bounds import largest_acceleration, resistance
from locosweep.diagnosis.data.readings.dropouts import LONGEST_HOLD, coded, dropped, repeats
from locosweep.diagnosis.data.readings.finding import Finding, stretches_of
from locosweep.diagnosis.data.readings.frozen import frozen
from locosweep.diagnosis.data.readings.slips import slips
from locosweep.diagnosis.data.readings.spikes import spikes
from locosweep.diagnosis.data.stamp_jitter import stamp_jitter
from locosweep.diagnosis.data.white_noise import known as known_readings
from locosweep.diagnosis.data.white_noise import scaled_differences, white_level
from locosweep.files.channels import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.noise import Noise
    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]

_FEWEST = 12
"""Readings of a column from which on its faults are looked for."""
_NORMAL = 0.6745
"""Median size of normal values of deviation 1."""
_START = 0.3
"""Share of a run's readings before its first slip from which these are kept, and not more of them
behind it."""
_STILL, _BAND = 8, 5.0
"""Readings in a row within so many deviations of their level that show no motion."""
_GRAIN = 0.1
"""Quantile of the differences between values that is the step of rounding: bad readings, which
are few, may lie between two steps."""
_AROUND = 3
"""Readings to either side that tell the speed at a reading."""
_POSITIONS = tuple(name for name, channel in CHANNELS.items() if channel.sensor == "position")


@dataclass(frozen=True)
class Checked:
    """Runs whose bad readings are masked, and what was found."""

    runs: tuple[Run, ...]
    findings: tuple[Finding, ...] = ()
    warnings: tuple[str, ...] = ()
    """Further notices about the runs."""

    @property
    def hopeless(self) -> bool:
        """True if a column is not what it is called: no cause can be looked for in it."""
        return any(not found.masked for found in self.findings)

    def without(self, flags: Sequence[Flags], findings: Sequence[Finding]) -> Checked:
        """Return the same with further readings of x masked, run by run of those with enough."""
        masked = {run.label: own for run, own in zip(usable(self.runs)[0], flags, strict=True)}
        runs = []
        for run in self.runs:
            x = run.channels["x"]
            gone = masked.get(run.label, np.zeros(x.size, dtype=bool))
            runs.append(replace(run, channels={**run.channels, "x": np.where(gone, np.nan, x)}))
        return replace(self, runs=tuple(runs), findings=(*self.findings, *findings))


@dataclass
class _Column:
    """Readings of one column of one run on the way to what is left of them."""

    run: Run
    name: str
    noise: float
    """Deviation of a reading at rest, the larger of what is stated and of what the run shows."""
    late: float
    """Deviation in s by which readings are early or late."""
    acceleration: float
    kinds: dict[str, Flags]
    """Samples that are masked, by kind of fault."""

    @property
    def bad(self) -> Flags:
        """Samples that are missing or masked."""
        gone = ~np.isfinite(self.run.channels[self.name])
        for flags in self.kinds.values():
            gone |= flags
        return gone

    def good(self) -> tuple[NDArray[np.intp], Floats, Floats]:
        """Return index, time and value of the readings that are left."""
        at = np.flatnonzero(~self.bad)
        return at, self.run.since_start[at], self.run.channels[self.name][at]

    def noise_at(self, t: Floats, x: Floats) -> Floats:
        """Return the deviation of each of some readings."""
        return np.hypot(self.noise, self.late * _speeds(t, x))

    def mark(self, kind: str, at: NDArray[np.intp]) -> None:
        """Mask samples."""
        flags = self.kinds.setdefault(kind, np.zeros(self.run.t.size, dtype=bool))
        flags[at] = True


def check_readings(
    runs: Sequence[Run], nominal: Mapping[str, float], sensor: Mapping[str, float]
) -> Checked:
    """Find spikes, dropouts, frozen stretches and slips of positions, and mask them.

    Parameters
    ----------
    runs : sequence of Run
        Measured runs, columns in the right units.
    nominal : mapping of str to float
        Parameters of the nominal model.
    sensor : mapping of str to float
        Noise and steps of the sensors as the nominal file states them.
    """
    masked = [dict(run.channels) for run in runs]
    findings: list[Finding] = []
    for name in _POSITIONS:
        own = [i for i, run in enumerate(runs) if name in run.channels]
        columns = _checked([runs[i] for i in own], name, nominal, sensor)
        for i, (column, said) in zip(own, columns, strict=True):
            if column.kinds:
                masked[i][name] = np.where(column.bad, np.nan, runs[i].channels[name])
            findings += said
    spoilt = {found.run for found in findings}
    kept = tuple(
        replace(run, channels=channels) if run.label in spoilt else run
        for run, channels in zip(runs, masked, strict=True)
    )
    order = {run.label: i for i, run in enumerate(runs)}
    findings.sort(key=lambda one: (order[one.run], one.column, one.t0))
    return Checked(kept, tuple(findings))


def _checked(
    runs: Sequence[Run], name: str, nominal: Mapping[str, float], sensor: Mapping[str, float]
) -> list[tuple[_Column, list[Finding]]]:
    """Check one column in all runs that have it."""
    late = stamp_jitter(name, runs)
    columns = [_column(run, name, nominal, sensor, late) for run in runs]
    for column in columns:
        _outliers(column)
    left = [_left(column) for column in columns]
    noise = noise_of(name, left, sensor)
    noise = replace(noise, step=max(noise.step, grain_of(name, left)))
    flicker = _flicker(name, left, noise)
    for column in columns:
        at, t, x = column.good()
        if at.size < _FEWEST:
            continue
        pushed = np.abs(column.run.drive[at]) * nominal["gain"] > resistance(column.run, nominal)
        stuck = frozen(t, x, noise, flicker, column.acceleration, pushed)
        if stuck.any():
            column.mark("frozen", at[stuck])
            _outliers(column)
    _held(columns, noise)
    swings = "gravity_torque" in nominal
    return [(column, _findings(column, _slipped(column, swings=swings))) for column in columns]


def _column(
    run: Run, name: str, nominal: Mapping[str, float], sensor: Mapping[str, float], late: float
) -> _Column:
    kind = CHANNELS[name].sensor
    grains = np.diff(np.unique(known_readings(run, name)[1]))
    grain = float(np.quantile(grains, _GRAIN)) if grains.size else 0.0
    step = max(sensor.get(f"{kind}_resolution", 0.0), grain)
    stated = float(np.hypot(sensor.get(f"{kind}_noise", 0.0), step / np.sqrt(12.0)))
    third = np.abs(scaled_differences(*known_readings(run, name), 3))
    seen = float(np.median(third)) / _NORMAL if third.size else 0.0
    noise = max(stated, seen, 1e-300)
    return _Column(run, name, noise, late, largest_acceleration(run, nominal), {})


def _speeds(t: Floats, x: Floats) -> Floats:
    """Return the size of the slope around each reading, of `_AROUND` steps to either side."""
    index = np.arange(t.size)
    low, high = np.maximum(index - _AROUND, 0), np.minimum(index + _AROUND, t.size - 1)
    return np.abs(x[high] - x[low]) / (t[high] - t[low])


def _left(column: _Column) -> Run:
    """Return the run with what is left of its column."""
    values = np.where(column.bad, np.nan, column.run.channels[column.name])
    return replace(column.run, channels={column.name: values})


def _flicker(name: str, runs: Sequence[Run], noise: Noise) -> float:
    """Return the noise before rounding that all readings are seen to have, at rest too.

    What readings have that are early or late, they do not have at rest.
    """
    if noise.late > 0.0:
        return 0.0
    seen = white_level(name, runs)
    return float(np.sqrt(max(seen**2 - noise.step**2 / 12.0, 0.0)))


def _outliers(column: _Column) -> None:
    """Mask readings that leave their neighbours and come back."""
    at, t, x = column.good()
    if at.size < _FEWEST:
        return
    off = spikes(t, x, column.noise_at(t, x), column.acceleration)
    if not off.any():
        return
    fell = dropped(x, off) | (off & np.concatenate([[False], np.diff(x) == 0.0]))
    column.mark("spike", at[off & ~fell])
    column.mark("dropout", at[fell | coded(x, off)])


def _held(columns: Sequence[_Column], noise: Noise) -> None:
    """Mask readings that repeat the last one while the head moves."""
    parts = [column.good() for column in columns]
    bounds = [column.acceleration for column in columns]
    runs = [(t, x, most) for (_, t, x), most in zip(parts, bounds, strict=True)]
    found = repeats(runs, noise.gaussian, noise.step, noise.late)
    for column, (at, _, _), same in zip(columns, parts, found, strict=True):
        if same.any():
            column.mark("dropout", at[same])


def _slipped(column: _Column, *, swings: bool) -> list[Finding]:
    """Mask all but one part between slips: readings beyond one are off by its jump."""
    at, t, x = column.good()
    if at.size < _FEWEST:
        return []
    found = slips(t, x, column.noise_at(t, x), column.acceleration)
    if not found:
        return []
    cuts = [0, *(i + 1 for i, _ in found), at.size]
    parts = list(pairwise(cuts))
    # Before the first slip the start of the run is known, and on a pendulum where it hangs.
    kept = max(parts, key=lambda part: part[1] - part[0])
    if parts[0][1] > (_FEWEST if swings else _START * at.size):
        kept = parts[0]
    said = []
    for k, (i, jump) in enumerate(found):
        # Each slip spoils the part on its far side, as seen from the part that is kept.
        first, last = parts[k + 1] if cuts[k + 1] >= kept[1] else parts[k]
        still = _still_before(x, i, column.noise)
        column.mark("slip", at[first:last])
        column.mark("slip", at[still : i + 1])
        times = (float(column.run.t[at[i]]), float(column.run.t[at[i + 1]]))
        where = "behind" if first > i else "before"
        note = (
            f"{column.name} jumps by {jump:.3g} between {times[0]:.4g} and {times[1]:.4g} s, "
            f"further than its drive can move it: slipped? {last - first} readings {where} "
            "the jump are left out"
        )
        if still <= i:
            note += f", and {i + 1 - still} of no motion before it, which may have been frozen"
        said.append(
            Finding(column.run.label, *times, column.name, "slip", last - first, True, note)
        )
    return said


def _still_before(x: Floats, last: int, noise: float) -> int:
    """Return the first reading of a stretch without motion up to `last`, if it is one.

    An encoder that was frozen jumps to where the head has gone.
    """
    level = float(np.median(x[max(last + 1 - _STILL, 0) : last + 1]))
    away = np.flatnonzero(np.abs(x[: last + 1] - level) > _BAND * noise)
    first = int(away[-1]) + 1 if away.size else 0
    return first if last + 1 - first >= _STILL else last + 1


def _findings(column: _Column, slipped: list[Finding]) -> list[Finding]:
    """Return a finding for each stretch of masked readings, and the slips."""
    found = list(slipped)
    for kind, flags in column.kinds.items():
        if kind == "slip":
            continue
        gap = 1 if kind == "frozen" else LONGEST_HOLD
        for first, last in stretches_of(flags, gap):
            count = int(flags[first : last + 1].sum())
            times = (float(column.run.t[first]), float(column.run.t[last]))
            found.append(Finding(column.run.label, *times, column.name, kind, count, True))
    return found
