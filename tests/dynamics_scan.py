"""Many trajectories at once by dense scans for events, in extended precision.

Nothing is assumed about how often the speed may pass zero within a piece: it is
sampled, a change of sign is refined by bisection, and the scan goes on from
there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

Wide = Any  # an array of np.longdouble
SAMPLES = 16
ROUNDS = 6
BISECTIONS = 70


@dataclass
class Scan:
    """Segments under forces that are constant piece by piece."""

    mass: Wide
    weight: Wide
    viscous: Wide
    # Level in motion and at rest, from direction and drive force.
    level: Callable[[Wide, Wide], Wide]
    hold: Callable[[Wide, Wide], Wide]
    x: Wide
    v: Wide
    t: Wide = field(init=False)
    way: Wide = field(init=False)
    stuck: Wide = field(init=False)
    sticks: NDArray[np.int64] = field(init=False)
    reversals: int = field(init=False, default=0)
    fast: Wide = field(init=False)
    far: Wide = field(init=False)

    def __post_init__(self) -> None:
        self.t, self.stuck = np.zeros_like(self.x), np.zeros_like(self.x)
        self.way = np.sign(self.v)
        self.sticks = np.zeros(self.x.shape, np.int64)
        self.fast, self.far = np.abs(self.v), np.abs(self.x)

    def piece(self, until: Wide, drive: Wide) -> None:
        """To the end of a piece, through all that happens in it."""
        for _ in range(ROUNDS):
            open_ = self.t < until
            if not open_.any():
                return
            self.release(open_ & (self.way == 0), drive)
            rests = open_ & (self.way == 0)
            self.stuck += np.where(rests, until - self.t, 0)
            self.t = np.where(rests, until, self.t)
            self.slide(np.flatnonzero(open_ & (self.way != 0)), until, drive)
        raise AssertionError("more events in a piece than rounds")

    def release(self, where: NDArray[np.bool_], drive: Wide) -> None:
        push = drive - self.weight
        way = np.sign(push)
        goes = np.abs(push) > np.maximum(self.hold(way, drive), self.level(way, drive))
        self.way = np.where(where, np.where(goes, way, 0), self.way)

    def slide(self, i: NDArray[np.intp], until: Wide, drive: Wide) -> None:
        way, v, span = self.way[i], self.v[i], until[i] - self.t[i]
        level = self.level(self.way, drive)[i]
        pull = (drive[i] - self.weight[i] - way * level) / self.mass[i]
        rate = self.viscous[i] / self.mass[i]
        end, stopped = span.copy(), np.zeros(i.shape, bool)
        before = np.zeros_like(span)
        for k in range(1, SAMPLES + 1):
            here = span * k / SAMPLES
            down = ~stopped & (way * speed(v, pull, rate, here) < 0)
            stopped |= down
            end = np.where(down, here, end)
            before = np.where(stopped, before, here)
        j = np.flatnonzero(stopped)
        low, high = before[j], end[j]
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            above = way[j] * speed(v[j], pull[j], rate[j], middle) > 0
            low, high = np.where(above, middle, low), np.where(above, high, middle)
        end[j] = high
        after = np.where(stopped, 0, speed(v, pull, rate, end))
        self.x[i] += path(v, pull, rate, end)
        self.v[i], self.t[i] = after, np.where(stopped, self.t[i] + end, until[i])
        self.fast = np.maximum(self.fast, np.abs(self.v))
        self.far = np.maximum(self.far, np.abs(self.x))
        old = way[j]
        mask = np.zeros(self.x.shape, bool)
        mask[i[j]] = True
        self.way = np.where(mask, 0, self.way)
        self.release(mask, drive)
        self.sticks[i[j]] += self.way[i[j]] == 0
        self.reversals += int((self.way[i[j]] == -old).sum())


def fade(rate: Wide, t: Wide) -> Wide:
    """(1 - e^(-rate t))/rate."""
    safe = np.where(rate > 0, rate, 1)
    return np.where(rate > 0, -np.expm1(-safe * t) / safe, t)


def speed(v: Wide, pull: Wide, rate: Wide, t: Wide) -> Wide:
    return v * np.exp(-rate * t) + pull * fade(rate, t)


def path(v: Wide, pull: Wide, rate: Wide, t: Wide) -> Wide:
    y = rate * t
    series = np.zeros_like(y)
    for n in range(12, 1, -1):
        series = (1 - y * series) / n if n > 2 else (1 - y * series) / 2
    near = t * t * series
    safe = np.where(rate > 0, rate, 1)
    late = (t - fade(rate, t)) / safe
    return v * fade(rate, t) + pull * np.where(y < 0.01, near, late)


def pulse_ends(period: Wide, duty: Wide, duration: Wide, count: int) -> list[Wide]:
    """Ends of the pieces of `count` pulses, none beyond the run."""
    ends = []
    for k in range(count):
        ends.append(np.minimum((k + duty) * period, duration))
        ends.append(np.minimum((k + 1) * period, duration))
    return ends
