"""Frozen encoders: one reading repeated in a stretch that neither rest nor motion explains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtr

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.data.noise import Noise

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]

SHORTEST = 4
"""Equal readings in a row that may be a frozen encoder; fewer are dropouts."""
_DEVIATIONS = 6.0
"""Deviations by which the reading after a frozen stretch jumps away from it."""
_JUMP = 3.0
"""The same jump, over what all forces at once could make of a head at rest."""
_SURE = 1e-9
"""Probability that noise rounds as many readings in a row to one value."""
_AFTER = 3
"""Readings after a frozen stretch over which the head has to move on."""
_CAUGHT_UP = 2.5
"""The jump over the largest step among these readings: an impact sets the head off at a speed
that it has in the next steps too."""


def frozen(
    t: Floats, x: Floats, noise: Noise, flicker: float, acceleration: float, pushed: Flags
) -> Flags:
    """Return which readings are frozen; the first of equal readings may be a true one.

    Parameters
    ----------
    t, x : ndarray
        Times in s and readings, all finite.
    noise : Noise
        Of the channel.
    flicker : float
        Noise that all readings are seen to have before they are rounded, also at rest; 0 where
        it is not known that they have any.
    acceleration : float
        Acceleration of all forces at once, in the reading's unit a s^2.
    pushed : ndarray of bool
        Samples at which the drive exceeds what holds the nominal head at rest.
    """
    found = np.zeros(x.size, dtype=bool)
    for first, last in _equal(x):
        if _by_chance(last - first + 1, flicker, noise.step) < _SURE or (
            pushed[first : last + 1].any() and _leaves(t, x, last, noise.sd, acceleration)
        ):
            found[first + 1 : last + 1] = True
    return found


def _equal(x: Floats) -> list[tuple[int, int]]:
    """Return first and last index of stretches of equal readings, `SHORTEST` or more."""
    ends = np.flatnonzero(np.diff(x) != 0.0)
    firsts = np.concatenate([[0], ends + 1])
    lasts = np.concatenate([ends, [x.size - 1]])
    long = lasts - firsts + 1 >= SHORTEST
    return list(zip(firsts[long].tolist(), lasts[long].tolist(), strict=True))


def _by_chance(count: int, noise: float, step: float) -> float:
    """Bound the probability that a head at rest gives as many equal readings in a row."""
    if noise == 0.0:
        return 1.0
    # The likeliest value holds most of the readings where the head rests in its middle.
    share = 1.0 - 2.0 * float(ndtr(-0.5 * step / noise))
    return float(share ** (count - 1))


def _leaves(t: Floats, x: Floats, last: int, noise: float, acceleration: float) -> bool:
    """Return whether readings jump off the stretch further than from rest, and move on.

    A head that rests on after a jump did not catch up with anything: its encoder slipped.
    """
    after = last + 1 + _AFTER
    if after >= x.size:
        return False
    jump = float(x[last + 1] - x[last])
    reach = 0.5 * acceleration * float(t[last + 1] - t[last]) ** 2
    on = float(x[after] - x[last + 1]) * np.sign(jump)
    steps = np.abs(np.diff(x[last + 1 : after + 1])) / np.diff(t[last + 1 : after + 1])
    step = float(steps.max()) * float(t[last + 1] - t[last])
    spread = np.sqrt(2.0) * noise
    least = max(_DEVIATIONS * spread, _JUMP * reach, _CAUGHT_UP * step)
    return bool(abs(jump) > least and on > _DEVIATIONS * spread)
