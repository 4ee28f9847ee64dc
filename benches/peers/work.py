"""The work to compare on, and what one way of doing it is."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

GRAVITY = 9.81
STROKE = 0.02
COUNTS = np.arange(2.0, 65.0)

# W1: mean velocity at every point, NaN where the robot does not move.
REUSED = "W1 used array"
FRESH = "W1 fresh array"
# W2: the count from 2 to 64 with the highest mean velocity, for every cell.
SEARCH = "W2 search"
CLOSED = "W2 closed form"


@dataclass(frozen=True)
class Axes:
    """Axes of a grid; ``segments`` is empty where the best count is searched."""

    mu_static: Array
    mu_coulomb: Array
    slope_deg: Array
    segments: Array

    @property
    def cos(self) -> Array:
        """Cosine of each slope."""
        return np.cos(np.radians(self.slope_deg))

    @property
    def sin(self) -> Array:
        """Sine of each slope."""
        return np.sin(np.radians(self.slope_deg))

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each axis."""
        axes = (self.mu_static, self.mu_coulomb, self.slope_deg, self.segments)
        return tuple(axis.size for axis in axes if axis.size)

    @property
    def size(self) -> int:
        """Number of points."""
        return int(np.prod(self.shape))


# Friction axes without common multiples: no acceleration is zero and no two counts
# tie up to rounding, where right answers may differ.
def dense_axes(scale: float) -> Axes:
    """W1: 200 x 200 x 100 x 25 points, scaled along the first axis."""
    return _axes(max(2, round(200 * scale)), np.arange(2.0, 27.0))


def design_axes(scale: float) -> Axes:
    """W2: 100 x 200 x 100 cells, scaled along the first axis."""
    return _axes(max(10, round(100 * scale)), np.empty(0))


def _axes(first: int, segments: Array) -> Axes:
    mu_static = np.linspace(0.1013, 0.99713, first)
    return Axes(mu_static, np.linspace(0.05071, 0.79337, 200), np.linspace(0, 25, 100), segments)


@dataclass(frozen=True)
class Variant:
    """One way to do a piece of work, on some threads."""

    key: str
    label: str
    threads: int
    call: Callable[[], Any]
    kind: str = "peer"
    """``ours``, ``peer`` or ``limit``; a limit computes nothing to check."""
    around: Callable[[], AbstractContextManager[Any]] = field(default=nullcontext)
    """Sets the number of threads, outside of the measured time."""
    share: float = 1.0
    """Part of the first axis that is computed; times are per point anyway."""
