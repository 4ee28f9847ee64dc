"""Dropouts: readings that fall to one value, or repeat the last one while the head moves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtr, pdtrc

from locosweep.diagnosis.data.readings.finding import stretches_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]

_SAME_VALUE = 3
"""Spikes of exactly one value from which that value is a code for "no reading"."""
LONGEST_HOLD = 5
"""Repeats in a row that count as a dropout; more are a frozen encoder."""
LONGEST_CODE = 3
"""Readings of such a value in a row that are dropouts; more are rest."""
_BY_CHANCE = 0.02
"""Probability of a repeat under noise and rounding, above which it says nothing."""
_SURE = 1e-6
"""Probability under noise of as many repeats as there are, below which they are dropouts."""
_MOVES = 2.0
"""Least change between samples, in deviations, that a repeat is looked for in."""
_BEND = 0.25
"""Change between samples that a repeat hides, over what all forces at once could make of a
head that stops for a moment and goes on; pauses of the simulated rigs stay below 0.12."""
_NEVER = 1e-12
"""Probability below which none is computed to."""
_STEADY = 0.5
"""Least step into and out of a stretch of repeats, over what the speed around it makes."""


def dropped(x: Floats, off: Flags) -> Flags:
    """Return which of the readings `off` their neighbours fell to a value that many have."""
    found = off.copy()
    found[off] = np.isin(x[off], _codes(x[off])) | (x[off] == 0.0)
    return found


def coded(x: Floats, off: Flags) -> Flags:
    """Return readings of the values that others fell to, however near their neighbours they are.

    Where the head passes such a value, a dropout does not stand out; where it rests there, that
    value stays.
    """
    found = np.isin(x, _codes(x[off]))
    for first, last in stretches_of(found):
        if last - first >= LONGEST_CODE:
            found[first : last + 1] = off[first : last + 1]
    return found


def _codes(off: Floats) -> Floats:
    """Return the values that several readings off their neighbours have."""
    values, counts = np.unique(off, return_counts=True)
    return values[counts >= _SAME_VALUE]


def repeats(
    runs: Sequence[tuple[Floats, Floats, float]], noise: float, step: float, late: float = 0.0
) -> list[Flags]:
    """Return which readings repeat the one before while the head moves, run by run.

    Parameters
    ----------
    runs : sequence of (t, x, acceleration)
        Times in s and readings, all finite, and the acceleration of all forces at once.
    noise, step : float
        Deviation of the noise before rounding, and the step of rounding.
    late : float
        Deviation in s by which readings are early or late.

    Returns
    -------
    list of ndarray of bool
        All False where as many repeats may come from noise and rounding.
    """
    parts = [_repeats(t, x, (noise, late), step, acceleration) for t, x, acceleration in runs]
    seen = sum(int(same.sum()) for same, _ in parts)
    expected = float(sum(chance for _, chance in parts))
    if seen == 0 or pdtrc(seen - 1, expected) > _SURE:
        return [np.zeros(x.size, dtype=bool) for _, x, _ in runs]
    return [same for same, _ in parts]


def _repeats(
    t: Floats, x: Floats, sensor: tuple[float, float], step: float, acceleration: float
) -> tuple[Flags, float]:
    """Return the repeats that chance seldom makes, and how many of them it makes on average."""
    found = np.zeros(x.size, dtype=bool)
    if x.size < LONGEST_HOLD + 8:
        return found, 0.0
    same = np.concatenate([[False], np.diff(x) == 0.0])
    # Place of each reading in its stretch of equal ones: 0 for the first.
    index = np.arange(x.size)
    first = np.maximum.accumulate(np.where(same, 0, index))
    last = np.minimum.accumulate(np.where(np.append(same[1:], False), x.size, index)[::-1])[::-1]
    before, after = first - 3, np.minimum(last + 4, x.size - 1)
    inside = (before >= 0) & (last + 4 < x.size)
    before = np.maximum(before, 0)
    onward = np.minimum(last + 1, x.size - 1)
    slopes = [
        (x[high] - x[low]) / np.where(high > low, t[high] - t[low], 1.0)
        for low, high in ((before, first), (onward, after))
    ]
    steady = inside & (np.sign(slopes[0]) == np.sign(slopes[1]))
    slope = np.minimum(np.abs(slopes[0]), np.abs(slopes[1]))
    interval = np.diff(t, prepend=t[0])
    change = slope * interval
    noise = np.hypot(sensor[0], sensor[1] * slope)
    # The head goes on through the stretch: it arrives at its speed, and what was held back shows
    # in the step behind it.
    steps = np.diff(x, prepend=x[0]) * np.sign(slopes[0])
    steady &= steps[first] > _STEADY * change
    steady &= steps[onward] > _STEADY * change * (last - first + 1)
    chance = _chance(change, noise, step)
    looked = steady & (change > _MOVES * np.hypot(noise, step / np.sqrt(12.0)))
    looked &= change > 0.5 * _BEND * acceleration * interval**2
    looked &= (chance < _BY_CHANCE) & (index - first <= LONGEST_HOLD)
    return same & looked, float(chance[looked].sum())


def _chance(change: Floats, noise: Floats, step: float) -> Floats:
    """Return the probability that two readings a change apart are rounded to the same value."""
    spread = np.sqrt(2.0) * np.maximum(noise, 1e-12 * max(step, 1e-300))
    dense = step / spread * _density(change / spread)
    # The mean of 1 - |d|/step over the difference d of both, where that is positive.
    edges = [(change + k * step) / spread for k in (-1.0, 0.0, 1.0)]
    low, middle, high = (u * ndtr(u) + _density(u) for u in edges)
    found = np.clip(spread / max(step, 1e-300) * (low - 2.0 * middle + high), 0.0, 1.0)
    either: Floats = np.where(step < 0.5 * spread, dense, found + _NEVER)
    return either


def _density(u: Floats) -> Floats:
    """Return the density of the standard normal distribution."""
    found: Floats = np.exp(-0.5 * np.square(u)) / np.sqrt(2.0 * np.pi)
    return found
