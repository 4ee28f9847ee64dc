"""Rows that miss in a log of an even clock: put in without readings, their drive within bounds.

The drive of such a row is not known. What the rows on either side let expect is taken for it,
and how far it may lie off belongs to the noise of all that follows (`estimate/drive_gaps.py`).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.ticks import tick_numbers

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

MOST = 0.5
"""Largest share of rows that may miss; where it is more, steps are no rows left out."""
_SIDE = 4
"""Rows on either side of a gap that say how the drive goes on."""
_SMOOTH = 0.5
"""Largest difference of one order over those of the order before, up to which the drive goes on
by these: a sine of 20 samples a period has 0.3, a step 1."""
_NEAR = (2, 8)
"""Rows that miss up to which a drive goes on by a parabola, and by a line; else it is held."""
_TRIED = 400
"""Rows of a run at which bridging is tried where the drive is known, at most."""
_LITTLE = 0.05
"""Difference of what both sides expect, in spans of the drive, up to which no jump makes it."""
_ALIKE = 1e-9
"""Difference of what both sides expect, in spans of the drive, from which they differ."""


def with_missing_rows(run: Run) -> tuple[Run, list[tuple[float, float, int]]]:
    """Return a run with a row for every tick of its clock, and its gaps.

    A gap is the times of the rows before and after, in s, and the number of rows between.
    Rows that missed have no readings, the drive that both sides let expect, and its deviation
    in `drive_deviation`. A run without such rows is returned as it is.
    """
    found = tick_numbers(run.t)
    if found is None:
        return run, []
    ticks, _ = found
    count = int(ticks[-1]) + 1
    if count == run.t.size or count - run.t.size > MOST * count:
        return run, []
    every = np.arange(count)
    drive = np.full(count, np.nan)
    drive[ticks] = run.drive
    channels = {}
    for name, values in run.channels.items():
        channels[name] = np.full(count, np.nan)
        channels[name][ticks] = values
    t = np.interp(every, ticks, run.t)
    t[ticks] = run.t
    before = np.flatnonzero(np.diff(ticks) > 1)
    drive, deviation = _bridged(drive, [(int(ticks[i]) + 1, int(ticks[i + 1])) for i in before])
    times = [
        (float(run.t[i]), float(run.t[i + 1]), int(ticks[i + 1] - ticks[i]) - 1) for i in before
    ]
    whole = replace(run, t=t, drive=drive, channels=channels, drive_deviation=deviation)
    return whole, times


def _bridged(drive: Floats, gaps: list[tuple[int, int]]) -> tuple[Floats, Floats]:
    """Return the drive with its gaps (first row, one beyond the last) bridged, and deviations."""
    known = drive[np.isfinite(drive)]
    span = float(np.ptp(known))
    limits = (float(known.min()), float(known.max()))
    filled, deviation = drive.copy(), np.zeros(drive.size)
    usual: dict[int, tuple[float, float]] = {}
    for a, b in gaps:
        rows = b - a
        if rows not in usual:
            usual[rows] = _usual_errors(drive, rows, span, limits)
        values, apart = _between(drive, a, b, limits)
        filled[a:b] = values
        # The drive changes from what one side expects to what the other does in any row.
        own = apart * np.sqrt(rows * (rows + 2.0) / 12.0) / rows
        deviation[a:b] = np.hypot(own, usual[rows][int(apart > _ALIKE * span)])
    return filled, deviation


def _between(drive: Floats, a: int, b: int, limits: tuple[float, float]) -> tuple[Floats, float]:
    """Return the drive in a gap, and how far apart lies what both sides expect of it."""
    rows = b - a
    left = _goes_on(drive[max(a - _SIDE, 0) : a][::-1], rows)
    right = _goes_on(drive[b : b + _SIDE], rows)[::-1]
    left, right = np.clip(left, *limits), np.clip(right, *limits)
    share = np.arange(1, rows + 1) / (rows + 1.0)
    values: Floats = left + share * (right - left)
    return values, float(np.abs(right - left).mean())


def _goes_on(side: Floats, rows: int) -> Floats:
    """Continue the drive over a gap from the rows on one side, the nearest one first."""
    gone = np.flatnonzero(np.isnan(side))
    side = side[: gone[0]] if gone.size else side
    ahead = np.arange(1.0, rows + 1.0)
    first = np.diff(side)
    second, third = np.diff(first), np.diff(first, 2)
    if rows <= _NEAR[0] and third.size and np.abs(third).max() <= _SMOOTH * np.abs(second).max():
        bent = second[0] * ahead * (ahead + 1.0) / 2.0
        return np.asarray(side[0] - first[0] * ahead + bent)
    if rows <= _NEAR[1] and second.size and abs(second[0]) <= _SMOOTH * np.abs(first[:2]).max():
        return np.asarray(side[0] - first[0] * ahead)
    return np.full(rows, side[0])


def _usual_errors(
    drive: Floats, rows: int, span: float, limits: tuple[float, float]
) -> tuple[float, float]:
    """Return usual errors of bridging where the drive is known: where both sides agree, or not.

    A drive may leave its way for fewer rows than miss, which neither side shows, and rounding of
    commands is larger where a parabola goes on from them.
    """
    known = np.isfinite(drive)
    whole = np.flatnonzero(np.convolve(known, np.ones(rows + 2), mode="valid") == rows + 2)
    stride = max(1, whole.size // _TRIED)
    errors: tuple[list[float], list[float], list[float]] = ([], [], [])
    for a in (whole[::stride] + 1).tolist():
        values, apart = _between(drive, a, a + rows, limits)
        kind = int(apart > _ALIKE * span) + int(apart > _LITTLE * span)
        errors[kind].append(float(np.mean(values - drive[a : a + rows])))
    # Where sides differ by much, their distance alone says how far off the drive may be.
    agree, differ, _ = (np.abs(kind) if kind else np.zeros(1) for kind in errors)
    return float(np.sqrt(np.mean(agree**2))), 1.4826 * float(np.median(differ))
