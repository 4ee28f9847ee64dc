"""Readings that are early or late: noise that grows with the speed.

A reading that is taken a moment before or after its stamp is off by the speed times that moment.
Servos on a serial bus do so by milliseconds: at speed, that is far more than an encoder's step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.white_noise import known, scaled_differences

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

_FEWEST = 400
"""Readings in motion from which on the noise is compared between slow and fast ones."""
_NORMAL = 0.6745
"""Median size of normal values of deviation 1."""
_ORDERS = (3, 7)
"""Orders of the differences that are compared, scaled by their own gain: of motion, the higher
one leaves less."""
_FLAT = 0.85
"""Least noise by the higher order over that by the lower one: noise gives 1, motion far less."""
_LOUDER = 2.0
"""Least noise of the fastest quarter of the readings over that of the slowest one."""
_GROWS = 0.6, 1.7
"""Noise over speed in the second quarter, over that in the fastest: 1 if stamps are off, less if a
part of the motion makes the noise, more if all readings have it."""


def stamp_jitter(channel: str, runs: Sequence[Run]) -> float:
    """Return the deviation in s by which readings of a channel are early or late.

    It is 0 where they do not show noise that grows in proportion to the speed: in all of 850 rigs
    whose stamps are right (`locosweep blind-check --draw-only`, the first 500 cases of seed 17171
    and all of `--only another-law --cases 200 --seed 18282`, `--only outside --cases 150 --seed
    18383`). Two servos show 3.0 and 3.0 ms, another one 0.4 ms (docs/blind-check.md).
    """
    parts = [_moving(*known(run, channel)) for run in runs if channel in run.channels]
    speed, first, last, rank = np.concatenate([np.zeros((4, 0)), *parts], axis=1)
    if speed.size < _FEWEST:
        return 0.0
    slow, mid, fast = rank < 0.25, (rank >= 0.25) & (rank < 0.5), rank >= 0.75
    floor = _level(last[slow])
    if _level(last[fast]) < max(_LOUDER * floor, _FLAT * _level(first[fast])):
        return 0.0
    late = np.sqrt(np.maximum(last**2 - (_NORMAL * floor) ** 2, 0.0)) / speed
    found = _level(late[fast])
    return found if _GROWS[0] * found < _level(late[mid]) < _GROWS[1] * found else 0.0


def _level(sizes: Floats) -> float:
    """Return the deviation of normal values of such sizes."""
    return float(np.median(sizes)) / _NORMAL


def _moving(t: Floats, x: Floats) -> Floats:
    """Return rows of the readings in motion: speed, sizes of differences of both orders, rank.

    The rank is that of the speed in its run, from 0 to 1: bad readings make a run fast.
    """
    width = _ORDERS[-1]
    if x.size <= width:
        return np.zeros((4, 0))
    count = x.size - width
    sizes = [np.abs(scaled_differences(t, x, order)[:count]) for order in _ORDERS]
    speed = np.abs(x[width:] - x[:-width]) / (t[width:] - t[:-width])
    rows = np.stack([speed, *sizes])[:, speed > 0.0]
    # Speeds of a coarse encoder tie by the hundred.
    order = np.argsort(rows[0], kind="stable")
    rank = np.argsort(order, kind="stable") / max(rows.shape[1], 1)
    return np.vstack([rows, rank])
