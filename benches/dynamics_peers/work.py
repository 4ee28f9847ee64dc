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
WORKS = (STRIBECK, LUGRE, PULSES, ROBOT)

TITLES = {
    STRIBECK: "W3: smooth Stribeck friction, RK4, 2000 steps",
    LUGRE: "W4: LuGre stick-slip, 10 s, x to 1e-4",
    PULSES: "W5: 12 phases with Coulomb friction, stiction and drag",
    ROBOT: "robot: 4 segments, 3 servos, 10 cycles of a gait",
}
UNITS = {STRIBECK: ("ns", 1e9), LUGRE: ("ms", 1e3), PULSES: ("ns", 1e9), ROBOT: ("us", 1e6)}
# Parameter points at scale 1.
POINTS = {STRIBECK: 100_000, LUGRE: 64, PULSES: 100_000, ROBOT: 128}
# Where fewer would say nothing, whatever the scale.
LEAST = {STRIBECK: 200, LUGRE: 4, PULSES: 200, ROBOT: 4}

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

    def take(self, rows: slice | np.ndarray[tuple[int], np.dtype[np.intp]]) -> Self:
        """Return some of the trajectories."""
        return type(self)(*(np.ascontiguousarray(column[rows]) for column in self.columns))


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
        return {
            "amplitude": np.linspace(1.0, 3.0, max(2, round(count / 10_000))),
            "coulomb": np.linspace(0.2, 0.6, 5),
            "static": np.linspace(0.7, 1.1, 5),
            "stribeck": np.linspace(0.02, 0.1, 5),
            "width": np.linspace(1e-2, 2e-2, 4),
            "viscous": np.linspace(0.0, 0.5, 4),
            "mass": np.linspace(0.2, 0.35, 5),
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
        return {
            "forward": np.linspace(0.8, 3.0, max(2, round(count / 10_000))),
            "back": np.linspace(0.4, 2.0, 5),
            "coulomb": np.linspace(0.4, 0.9, 5),
            "static": np.linspace(1.0, 1.5, 4),
            "viscous": np.linspace(0.05, 0.5, 5),
            "mass": np.linspace(0.2, 0.35, 4),
        }

    DUTY = np.linspace(0.4, 0.75, 5)


@dataclass(frozen=True)
class Robot(Points):
    """A chain on a line; head first, each segment moves 20 mm while the others hold.

    Servo j between segments j and j + 1 pushes them apart with
    kp (commanded - length) - kd length', clipped at +-``limit``, length = x_j - x_(j+1).
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
        """Return the commanded lengths at some times, one column per servo."""
        # Rounding must not put the first instant of a phase into the one before.
        phase = np.floor(times / cls.PHASE + 1e-9)
        moved = np.clip((times - phase * cls.PHASE) * cls.RAMP, 0.0, cls.STROKE)
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


KINDS: dict[str, type[Stribeck | LuGre | Pulses | Robot]] = {
    STRIBECK: Stribeck,
    LUGRE: LuGre,
    PULSES: Pulses,
    ROBOT: Robot,
}
# The largest difference is taken relative to the value, or to these where it is smaller:
# positions cross zero, and velocities are zero at rest.
FLOORS: dict[str, tuple[float, ...]] = {
    STRIBECK: (0.1, 0.1),
    LUGRE: (1e-6,),
    PULSES: (0.01, 0.01),
    ROBOT: (1e-6,),
}


@dataclass(frozen=True)
class Way(Variant):
    """One way to do a work; ``call`` returns one row per trajectory, one column per result."""

    points: int = 0
    """Trajectories of one call: the first ones of the work."""
    allowed: float | None = 1e-9
    """Largest difference to the reference; None for another model, where it is only shown."""
    steps: int = 0
    """Steps of each trajectory, where their number is given."""
    own: Callable[[], float] | None = None
    """Difference to the small-step limit of the same model, which ``OWN_ALLOWED`` bounds."""


OWN_ALLOWED = 0.01
# What adaptive methods have to attain.
ATTAIN = {STRIBECK: 1e-4, LUGRE: 1e-4, PULSES: 1e-6, ROBOT: 1e-2}


def share(points: Points, part: float, least: int = 1) -> int:
    """Return how many points a slow way takes."""
    return min(points.size, max(least, round(part * points.size)))
