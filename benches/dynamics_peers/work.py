"""The works of the dynamics: parameters, in one place, and one way of doing each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from peers.work import Array, Variant

# W3: smooth Stribeck friction under a sine, RK4 with a given step.
STRIBECK = "W3"
# W4: LuGre friction on a pulled spring; stiff, any method.
LUGRE = "W4"
# W5: pulses on a body with Coulomb friction, stiction and viscous drag; true sticking.
PULSES = "W5"
# A chain of four segments with servos between them, one moving at a time.
ROBOT = "robot"
# Measured runs replayed through a model, a number for every sample: without and with bristles.
REPLAY, BRISTLES = "replay", "bristles"
WORKS = (STRIBECK, LUGRE, PULSES, ROBOT, REPLAY, BRISTLES)

TITLES = {
    STRIBECK: "W3: smooth Stribeck friction, RK4, 2000 steps",
    LUGRE: "W4: LuGre stick-slip, 10 s, x to 1e-4",
    PULSES: "W5: 12 phases with Coulomb friction, stiction and drag",
    ROBOT: "robot: 4 segments, 3 servos, 10 cycles of a gait",
    REPLAY: "replay: 6 runs x 2000 samples, Coulomb and viscous friction",
    BRISTLES: "bristles: the same runs, friction of LuGre bristles",
}
UNITS = {
    STRIBECK: ("us", 1e6),
    LUGRE: ("ms", 1e3),
    PULSES: ("ns", 1e9),
    ROBOT: ("us", 1e6),
    REPLAY: ("us", 1e6),
    BRISTLES: ("us", 1e6),
}
# Parameter points at scale 1, and how few are worth looking at.
POINTS = {STRIBECK: 100_000, LUGRE: 64, PULSES: 100_000, ROBOT: 128, REPLAY: 96, BRISTLES: 96}
LEAST = {STRIBECK: 200, LUGRE: 4, PULSES: 200, ROBOT: 8, REPLAY: 12, BRISTLES: 12}

GRAVITY = 9.81
SEGMENT_MASS = 0.271


@dataclass(frozen=True)
class Points:
    """One array per parameter; entry i of all of them is one trajectory."""

    @property
    def columns(self) -> tuple[Array, ...]:
        """The arrays, in the order of the fields."""
        return tuple(getattr(self, field.name) for field in fields(self))

    @property
    def size(self) -> int:
        """Number of trajectories."""
        return int(self.columns[0].size)

    def some(self, count: int) -> Self:
        """Return this many of the trajectories, from all over."""
        return self.take(spread(self.size, count))

    def take(self, rows: slice | np.ndarray[tuple[int], np.dtype[np.intp]]) -> Self:
        """Return some of the trajectories."""
        return type(self)(*(np.ascontiguousarray(column[rows]) for column in self.columns))


def spread(size: int, count: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Choose some of `size` rows, evenly, the first and the last among them."""
    return np.unique(np.linspace(0, size - 1, min(size, count)).astype(np.intp))


def length(full: int, part: float) -> int:
    """Return how long an axis is of which a grid has this part; two ends at least."""
    return max(2, round(full * part))


def product(*axes: Array) -> list[Array]:
    """Return every combination of the axes' values, the last axis fastest."""
    return [np.ascontiguousarray(grid.ravel()) for grid in np.meshgrid(*axes, indexing="ij")]


@dataclass(frozen=True)
class Stribeck(Points):
    """W3: m v' = A sin(2 pi t) - (Fc + (Fs - Fc) exp(-(v / vs)^2)) tanh(v / eps) - c v.

    Friction and mass of a small robot; ``width`` is wide enough for RK4 to be stable at 1 ms.
    """

    amplitude: Array
    coulomb: Array
    static: Array
    stribeck: Array
    width: Array
    viscous: Array
    mass: Array

    END = 2.0
    STEPS = 2000
    STEP = END / STEPS

    @classmethod
    def draw(cls, count: int) -> Self:
        """Return parameter points: all combinations of `axes`."""
        return cls(*product(*cls.axes(count).values()))

    @classmethod
    def axes(cls, count: int) -> dict[str, Array]:
        """Return the values of each parameter; about `count` combinations."""
        part = (count / POINTS[STRIBECK]) ** (1 / 7)
        return {
            "amplitude": np.linspace(1.0, 3.0, length(10, part)),
            "coulomb": np.linspace(0.2, 0.6, length(5, part)),
            "static": np.linspace(0.7, 1.1, length(5, part)),
            "stribeck": np.linspace(0.02, 0.1, length(5, part)),
            "width": np.linspace(1e-2, 2e-2, length(4, part)),
            "viscous": np.linspace(0.0, 0.5, length(4, part)),
            "mass": np.linspace(0.2, 0.35, length(5, part)),
        }


@dataclass(frozen=True)
class LuGre(Points):
    """W4: m x'' = k (V t - x) - F, z' = v - s0 |v| z / g, F = s0 z + s1 z' + s2 v.

    g(v) = Fc + (Fs - Fc) exp(-(v / vs)^2). The result is x at the end.
    """

    stiffness: Array
    static: Array

    SIGMA0 = 1e5
    SIGMA1 = 1e5**0.5
    SIGMA2 = 0.4
    COULOMB = 1.0
    VELOCITY = 1e-3
    MASS = 1.0
    PULL = 0.1
    END = 10.0

    @classmethod
    def draw(cls, count: int) -> Self:
        """Return parameter points: all combinations of `axes`."""
        return cls(*product(*cls.axes(count).values()))

    @classmethod
    def axes(cls, count: int) -> dict[str, Array]:
        """Return the values of each parameter; about `count` combinations."""
        across = max(2, round(count**0.5))
        return {
            "stiffness": np.linspace(1.5, 2.5, across),
            "static": np.linspace(1.3, 1.7, across),
        }


@dataclass(frozen=True)
class Pulses(Points):
    """W5: m v' = u - Fc sign(v) - c v; at rest as long as |u| <= Fs.

    The drive u is ``forward`` for ``t_on``, then -``back`` for ``t_off``, six times. Some points
    never start, some slip back, some come to rest in every phase.
    """

    forward: Array
    back: Array
    t_on: Array
    t_off: Array
    coulomb: Array
    static: Array
    viscous: Array
    mass: Array

    PERIODS = 6
    PERIOD = 0.3

    @classmethod
    def draw(cls, count: int) -> Self:
        """Return parameter points: all combinations of `axes`."""
        axes = cls.axes(count)
        *others, duty = product(*axes.values(), cls.DUTY)
        forward, back, coulomb, static, viscous, mass = others
        on = duty * cls.PERIOD
        return cls(forward, back, on, cls.PERIOD - on, coulomb, static, viscous, mass)

    @classmethod
    def axes(cls, count: int) -> dict[str, Array]:
        """Return the values of each parameter but the share of the forward pulse."""
        part = (count / POINTS[PULSES]) ** (1 / 6)
        return {
            "forward": np.linspace(0.8, 3.0, length(10, part)),
            "back": np.linspace(0.4, 2.0, length(5, part)),
            "coulomb": np.linspace(0.4, 0.9, length(5, part)),
            "static": np.linspace(1.0, 1.5, length(4, part)),
            "viscous": np.linspace(0.05, 0.5, length(5, part)),
            "mass": np.linspace(0.2, 0.35, length(4, part)),
        }

    DUTY = np.linspace(0.4, 0.75, 5)


@dataclass(frozen=True)
class Robot(Points):
    """A chain on a line; head first, each segment moves 20 mm while the others hold.

    Servo j between segments j and j + 1 pushes them apart with
    kp (commanded - length) + kd (commanded' - length'), clipped at +-``limit``, where
    length = x_j - x_(j+1): spring and damper between drive and joint.
    Each segment has Coulomb friction ``friction`` times its weight, no stiction beyond that.
    The result is the advance of the mean position.
    """

    friction: Array
    limit: Array

    SEGMENTS = 4
    STIFFNESS = 2e3
    DAMPING = 20.0
    STROKE = 0.02
    RAMP = 0.1
    PHASE = STROKE / RAMP + 0.1
    CYCLES = 10
    END = CYCLES * SEGMENTS * PHASE

    @classmethod
    def draw(cls, count: int) -> Self:
        """Return parameter points: all combinations of `axes`."""
        return cls(*product(*cls.axes(count).values()))

    @classmethod
    def axes(cls, count: int) -> dict[str, Array]:
        """Return the values of each parameter; the weakest servos can just move a segment."""
        across = max(2, round((count / 2) ** 0.5))
        return {
            "friction": np.linspace(0.3, 0.5, across),
            "limit": np.linspace(1.4, 4.5, 2 * across),
        }

    @property
    def drag(self) -> Array:
        """Largest friction force of one segment."""
        return self.friction * (SEGMENT_MASS * GRAVITY)

    @classmethod
    def commanded(cls, times: Array) -> Array:
        """Return what servos that know no commanded speed are told: one column per servo.

        With these lengths kp (commanded - length) - kd length' is the same force.
        """
        # Rounding must not put the first instant of a phase into the one before.
        phase = np.floor(times / cls.PHASE + 1e-9)
        ramp = (times - phase * cls.PHASE) * cls.RAMP
        moved = np.clip(ramp, 0.0, cls.STROKE)
        pace = np.where(ramp < cls.STROKE * (1 - 1e-9), cls.RAMP, 0.0)
        moved += cls.DAMPING / cls.STIFFNESS * pace
        mover = phase % cls.SEGMENTS
        joints = [
            np.where(mover == j, moved, 0.0) + np.where(mover == j + 1, cls.STROKE - moved, 0.0)
            for j in range(cls.SEGMENTS - 1)
        ]
        return np.ascontiguousarray(np.stack(joints, axis=-1))

    @classmethod
    def starts(cls, step: float) -> Array:
        """Return the first instants of all steps."""
        return np.arange(round(cls.END / step), dtype=np.float64) * step

    @classmethod
    def midpoints(cls, step: float) -> Array:
        """Return the middles of all steps, where one command per step fits best."""
        return cls.starts(step) + 0.5 * step


# The largest difference is taken relative to the value, or to these where it is smaller:
# positions cross zero, and velocities are zero at rest.
FLOORS: dict[str, tuple[float, ...]] = {
    STRIBECK: (0.1, 0.1),
    LUGRE: (1e-6,),
    PULSES: (0.01, 0.01),
    ROBOT: (1e-6,),
    # A position at every sample; the noise of a good sensor is some um.
    REPLAY: (1e-2,),
    BRISTLES: (1e-2,),
}


@dataclass(frozen=True)
class Way(Variant):
    """One way to do a work; ``call`` returns one row per trajectory, one column per result."""

    points: int = 0
    """Trajectories of one call: `Points.some` of the work."""
    allowed: float | None = 1e-9
    """Largest difference to the reference; None for another model, where it is only shown."""
    steps: int = 0
    """Steps of each trajectory, where their number is given."""
    own: Callable[[], float] | None = None
    """Difference to the small-step limit of the same model, which ``OWN_ALLOWED`` bounds."""


OWN_ALLOWED = 0.01
# What adaptive methods have to attain.
ATTAIN = {
    STRIBECK: 1e-4,
    LUGRE: 1e-4,
    PULSES: 1e-6,
    ROBOT: 1e-2,
    REPLAY: 1e-9,
    BRISTLES: 1e-4,
}


def share(points: Points, part: float, least: int = 1) -> int:
    """Return how many points a slow way takes."""
    return min(points.size, max(least, round(part * points.size)))
