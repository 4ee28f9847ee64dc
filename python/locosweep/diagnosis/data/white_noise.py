"""White noise that is in all readings of a channel, however the head moves."""

from __future__ import annotations

from math import comb, prod
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

_WINDOW = 32
"""Readings in a row that a level of noise is read off."""
_FEWEST = 6
"""Windows from which on a level is told."""
_LARGEST = 1e100
"""Largest difference that counts, so that its square is a number."""
_EVEN = 1e-3
"""Spread of the steps in time up to which they count as even."""
_ORDERS = (3, 5, 7)
"""Orders of the differences that are compared: those of white noise have one level, scaled by
their own gain; motion loses from order to order, and what is left at the last one is no less
than the noise."""
_QUIETEST, _BIAS = 0.2, 0.76
"""Share of the windows that are the quietest, and the level at that quantile of white noise of
deviation 1: the least of three orders, over a hundred windows and more."""
_FLAT = 0.6, 0.85
"""Least level of the last order, over those of the first and of the second one, at which the
quietest windows hold white noise: it gives 0.86 to 0.97 and 0.94 to 0.98."""
_AT_REST = 0.5
"""Least level before the drive first changes, over that of the quietest windows: what is
louder only in motion is motion."""
_RESTING = 12
"""Differences before the drive first changes from which on these are asked."""


UNDERSTATED = 2.0
"""White noise over the stated one from which it counts in its place: 1.4 at most on 600
simulated rigs with every effect in turn."""
OVERSTATED = 0.1
"""White noise over the stated one below which that is said to be far too large."""


def noise_beyond(stated: float, channel: str, runs: Sequence[Run]) -> float:
    """Return the white noise of a channel where it is clearly more than is stated; else 0."""
    seen = white_level(channel, runs)
    return seen if seen > UNDERSTATED * stated else 0.0


def white_level(channel: str, runs: Sequence[Run]) -> float:
    """Return the deviation of the white noise in all readings of a channel.

    It is the level of the quietest windows of all runs; 0 where these do not show white noise,
    or where the head at rest shows less of it.
    """
    levels = _levels([known(run, channel) for run in runs if channel in run.channels])
    # Windows of one value are a head at rest within a step of rounding, or a frozen encoder.
    levels = levels[:, levels[0] > 0.0]
    if levels.shape[1] < _FEWEST:
        return 0.0
    least = levels.min(axis=0)
    floor = float(np.quantile(least, _QUIETEST)) / _BIAS
    quiet = levels[:, least <= np.quantile(least, 1.5 * _QUIETEST)]
    first, second, last = np.sqrt((quiet**2).mean(axis=1))
    if floor <= 0.0 or last < max(_FLAT[0] * first, _FLAT[1] * second):
        return 0.0
    at_rest = _level_at_rest(channel, runs)
    return floor if at_rest is None or at_rest > _AT_REST * floor else 0.0


def known(run: Run, channel: str) -> tuple[Floats, Floats]:
    """Return times and values of the readings of a channel that are known."""
    values = run.channels[channel]
    there = np.isfinite(values)
    return run.since_start[there], values[there]


def scaled_differences(t: Floats, x: Floats, order: int) -> Floats:
    """Return differences of an order that noise of deviation 1 gives a deviation of 1.

    They are divided differences where times are not even: a reading that is early or late is no
    noise.
    """
    if x.size <= order:
        return np.zeros(0)
    steps = np.diff(t)
    if steps.max() <= (1.0 + _EVEN) * steps.min():
        even: Floats = np.diff(x, order) / np.sqrt(comb(2 * order, order))
        return even
    # In units of the mean step, so that products stay near 1.
    count, t = x.size - order, t / float(steps.mean())
    at = [t[i : i + count] for i in range(order + 1)]
    found, squares = np.zeros(count), np.zeros(count)
    for i, own in enumerate(at):
        weight = 1.0 / prod(own - other for j, other in enumerate(at) if j != i)
        found += weight * x[i : i + count]
        squares += weight**2
    return found / np.sqrt(squares)


def _levels(readings: Sequence[tuple[Floats, Floats]]) -> Floats:
    """Return root mean squares of the scaled differences in windows, a row an order."""
    parts = [np.zeros((len(_ORDERS), 0))]
    for t, x in readings:
        count = x.size // _WINDOW
        if count:
            rows = []
            for order in _ORDERS:
                found = scaled_differences(t, x, order)
                found = np.append(found, np.zeros(order))[: count * _WINDOW].clip(
                    -_LARGEST, _LARGEST
                )
                cut = found.reshape(count, _WINDOW)[:, : _WINDOW - order]
                rows.append(np.sqrt((cut**2).mean(axis=1)))
            parts.append(np.array(rows))
    return np.concatenate(parts, axis=1)


def _level_at_rest(channel: str, runs: Sequence[Run]) -> float | None:
    """Return the level before the drive first changes from 0, where there are enough readings."""
    thirds = [np.zeros(0)]
    for run in runs:
        changes = np.flatnonzero(run.drive != run.drive[0])
        if channel in run.channels and changes.size and run.drive[0] == 0.0:
            t, x = known(run, channel)
            still = t <= run.since_start[changes[0]]
            thirds.append(scaled_differences(t[still], x[still], 3))
    third = np.concatenate(thirds)
    return float(np.sqrt(np.mean(third**2))) if third.size >= _RESTING else None
