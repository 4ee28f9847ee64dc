"""How far readings lie off straight lines through their neighbours, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Misfit:
    """Distances of readings from lines, how noise and acceleration add to them."""

    size: Floats
    """Reading less line, in the unit of the reading."""
    gain: Floats
    """Deviation of `size` by white noise of deviation 1."""
    bend: Floats
    """Largest `size` that an acceleration of 1 makes, s^2."""


def off_line(t: Floats, x: Floats, at: Indices, first: Indices, second: Indices) -> Misfit:
    """Return how far readings `at` lie off the lines through two others each."""
    share = (t[at] - t[first]) / (t[second] - t[first])
    size = x[at] - (x[first] * (1.0 - share) + x[second] * share)
    gain = np.sqrt(1.0 + (1.0 - share) ** 2 + share**2)
    # The remainder of a linear interpolation, x''/2 (t - t1) (t - t2), bounds both cases.
    bend = 0.5 * np.abs((t[at] - t[first]) * (t[at] - t[second]))
    return Misfit(size, gain, bend)
