"""What the machine allows at best on one core, beside which our times are set.

The rate of arithmetic is that of a matrix product in the same process. How many
multiply-adds a work needs at least is counted by hand from its formulas: an exponential takes
17 (11 of its polynomial, 6 around it), a logarithm 20, a division or a root 4.
"""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass

import numpy as np

from common.threads import one_processor
from dynamics_peers.replays import SAMPLES
from dynamics_peers.work import PULSES, REPLAY, ROBOT, STRIBECK

# Multiply-adds of one unit, and the name of the unit.
COUNTS: dict[str, tuple[int, str]] = {
    # Four stages of two exponentials, a division and ten more, less what they share.
    STRIBECK: (4 * 39, "step"),
    # Twelve phases of two pieces: a logarithm, an exponential, a division and ten more.
    PULSES: (12 * 2 * 51, "trajectory"),
    # Three joints of 13, four segments of 25, two divisions in each pass that decides who
    # sticks, of which there is at least one.
    ROBOT: (3 * 13 + 4 * 25 + 4 * 8, "step"),
    # An exponential, a logarithm, a division and fourteen more.
    REPLAY: (55, "sample"),
}
# A replay writes position, speed, force and the body's position of every sample.
REPLAY_BYTES = 4 * 8


@dataclass(frozen=True)
class Machine:
    """Rates of one core."""

    multiply_adds: float
    """Per second."""
    written: float
    """Bytes per second, to memory that was used before."""

    def seconds(self, work: str) -> float | None:
        """Return the least time of a unit of a work, None where it cannot be counted."""
        if work not in COUNTS:
            return None
        least = COUNTS[work][0] / self.multiply_adds
        return max(least, REPLAY_BYTES / self.written) if work == REPLAY else least


def units(work: str, steps: int) -> int:
    """Return how many units of `COUNTS` a trajectory has."""
    return {STRIBECK: steps, ROBOT: steps, REPLAY: SAMPLES}.get(work, 1)


def measure(rounds: int) -> Machine:
    """Take the rates of this machine."""
    size, times = 768, 3
    a = np.linspace(0.0, 1.0, size * size).reshape(size, size)
    b, c = a.T.copy(), np.empty((size, size))
    target = np.empty(25_000_000)
    products, fills = [], []
    with one_processor():
        np.matmul(a, b, out=c)
        target.fill(1.0)
        for _ in range(rounds):
            start = time.process_time()
            for _ in range(times):
                np.matmul(a, b, out=c)
            products.append(times * size**3 / (time.process_time() - start))
            start = time.process_time()
            target.fill(1.25)
            fills.append(target.nbytes / (time.process_time() - start))
    return Machine(statistics.median(products), statistics.median(fills))
