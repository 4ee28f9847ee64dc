"""Slips: jumps of a position that stay, further than any force could move the head."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.readings.lines import off_line

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_DEVIATIONS = 6.0
"""Deviations of noise by which a slip stands off the lines on both of its sides: motions of
every effect of the simulated rigs that could be one stay below 5."""
_BEND = 0.4
"""The same distance, over what all forces at once could make; such motions stay below 0.12
where they stand off the noise."""


_STAYS = 0.5
"""Part of a slip that the second reading on either side has to show as well."""


def slips(
    t: Floats, x: Floats, noise: float | Floats, acceleration: float
) -> list[tuple[int, float]]:
    """Return the last reading before each slip, and how far it goes.

    `t`, `x`, `noise` and `acceleration` are those of `spikes`.
    """
    if t.size < 4:
        return []
    before = np.arange(1, t.size - 2)
    noise = np.broadcast_to(noise, t.shape)
    left = off_line(t, x, before + 1, before - 1, before)
    right = off_line(t, x, before, before + 2, before + 1)
    sizes = [
        np.abs(part.size)
        / np.maximum(_DEVIATIONS * noise[before] * part.gain, _BEND * acceleration * part.bend)
        for part in (left, right)
    ]
    further = [
        off_line(t, x, before + 2, before - 1, before).size,
        -off_line(t, x, before - 1, before + 2, before + 1).size,
    ]
    # A kink between the two readings lies off the lines on one side of them, a slip on both.
    slipped = np.sign(left.size) == -np.sign(right.size)
    least = np.where(slipped, np.minimum(*sizes), 0.0)
    jump = 0.5 * (left.size - right.size)
    stays = np.min([one * np.sign(jump) for one in further], axis=0) > _STAYS * np.abs(jump)
    least = np.where(stays, least, 0.0)
    found = []
    for i in np.flatnonzero(least >= 1.0).tolist():
        around = least[max(i - 2, 0) : i + 3]
        if least[i] == around.max():
            found.append((int(before[i]), float(jump[i])))
    return found
