"""Spikes: one or a few readings that leave their neighbours' line and come back to it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.readings.lines import off_line

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.data.readings.lines import Misfit

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]
    Indices = NDArray[np.intp]

DEVIATIONS = 5.0
"""Deviations of noise by which a spike stands off each line: motions of every effect of the
simulated rigs reach 3.6 between two lines, the two measured rigs 3.9."""
BOTH_SIDES, ONE_SIDE = 0.1, 1.0
"""Distance of one reading from the lines, over what all forces at once could make: off the lines
of both sides, and off that of one side where the other holds another spike. Motions that reach
`DEVIATIONS` off one side lie below 0.12."""
SEVERAL = 1.0, 2.5
"""The same two for several readings in a row, which may also lie on a bend of the motion: a head
that was hit and brakes leaves the line of one side by up to 2."""
CONTINUES = 0.35
"""Misfit of the first reading behind a spike from the line before it, over the spike's size."""
END_DEVIATIONS, END_STEPS = 6.0, 3.0
"""Deviations by which the first and the last reading of a run, which have one side only, stand
off it, and their distance over the largest step between other readings of the run."""
LONGEST = 4
"""Readings in a row that count as a spike; longer ones may be motion."""
_ROUNDS = 40
"""Rounds of a search, at most: in each the largest spikes are taken out first."""


def spikes(t: Floats, x: Floats, noise: float | Floats, acceleration: float) -> Flags:
    """Return which readings are spikes.

    Parameters
    ----------
    t, x : ndarray
        Times in s and readings, all finite.
    noise : float or ndarray
        Deviation of the readings, or of each, in their unit.
    acceleration : float
        Acceleration of all forces at once, in the reading's unit a s^2.
    """
    kept = np.arange(t.size)
    noise = np.broadcast_to(noise, t.shape)
    for _ in range(_ROUNDS):
        if kept.size < LONGEST + 4:
            break
        bad = _largest(t[kept], x[kept], noise[kept], acceleration)
        if not bad.any():
            break
        kept = kept[~bad]
    found = np.ones(t.size, dtype=bool)
    found[kept] = False
    return found


def _largest(t: Floats, x: Floats, noise: Floats, acceleration: float) -> Flags:
    """Return the spikes that are larger than all others among their neighbours."""
    rows = []
    for length in range(1, LONGEST + 1):
        first, size, agree = _sizes(t, x, length, noise, acceleration)
        at = np.flatnonzero(size >= 1.0)
        rows += [(bool(agree[i]), float(size[i]), int(first[i]), length) for i in at]
    rows += [(True, size, i, 1) for size, i in _ends(t, x, noise)]
    taken = np.zeros(t.size, dtype=bool)
    bad = np.zeros(t.size, dtype=bool)
    # First those whose neighbours agree with each other: between two spikes a good reading is
    # off both.
    for _, _, start, length in sorted(rows, key=lambda row: (-row[0], -row[1], *row[2:])):
        around = slice(max(start - 2, 0), start + length + 2)
        if not taken[around].any():
            bad[start : start + length] = True
            taken[around] = True
    return bad


def _sizes(
    t: Floats, x: Floats, length: int, noise: Floats, acceleration: float
) -> tuple[Indices, Floats, Flags]:
    """Return groups of readings, their sizes, from 1 on a spike, and whether neighbours agree."""
    first = np.arange(2, t.size - length - 1)
    a, b, c, d = first - 2, first - 1, first + length, first + length + 1
    left = [off_line(t, x, first + k, a, b) for k in range(length)]
    right = [off_line(t, x, first + k, c, d) for k in range(length)]
    chord = [off_line(t, x, first + k, b, c) for k in range(length)]
    deviation = noise[first]
    both, one = (BOTH_SIDES, ONE_SIDE) if length == 1 else SEVERAL
    best = _least([*left, *right, *chord], deviation, acceleration, both)
    agree = np.zeros(first.size, dtype=bool)
    for side, behind in ((left, off_line(t, x, c, a, b)), (right, off_line(t, x, b, c, d))):
        off = np.min([np.abs(part.size) for part in [*side, *chord]], axis=0)
        size = _least([*side, *chord], deviation, acceleration, one)
        continues = np.abs(behind.size) < CONTINUES * off
        best = np.where(continues, np.maximum(best, size), best)
        agree |= continues
    return first, best, agree


def _least(parts: list[Misfit], noise: Floats, acceleration: float, bend: float) -> Floats:
    """Return the least size over the limits among misfits of one sign, 0 where signs differ."""
    signs = np.sign([part.size for part in parts])
    one_sign = (signs == signs[0]).all(axis=0)
    sizes = [
        np.abs(part.size)
        / np.maximum(DEVIATIONS * noise * part.gain, bend * acceleration * part.bend)
        for part in parts
    ]
    least: Floats = np.where(one_sign, np.min(sizes, axis=0), 0.0)
    return least


def _ends(t: Floats, x: Floats, noise: Floats) -> list[tuple[float, int]]:
    """Return size and index of a spike at the first and at the last reading."""
    n = t.size
    found = []
    step = float(np.abs(np.diff(x[1:-1])).max())
    for at, near, far in ((0, 1, 2), (n - 1, n - 2, n - 3)):
        part = off_line(t, x, *(np.array([i]) for i in (at, near, far)))
        limit = max(END_DEVIATIONS * float(noise[at] * part.gain[0]), END_STEPS * step)
        size = abs(float(part.size[0])) / limit
        if size >= 1.0:
            found.append((size, at))
    return found
