"""NumPy: whole arrays as in a notebook, blocks in place; also the references."""

from __future__ import annotations

from functools import partial

import numpy as np

from dynamics_peers.replays import COULOMB, INTERVAL, SAMPLES, VISCOUS, WEIGHT, Replays
from dynamics_peers.work import (
    ATTAIN,
    BRISTLES,
    LUGRE,
    PULSES,
    REPLAY,
    ROBOT,
    SEGMENT_MASS,
    STRIBECK,
    Points,
    Pulses,
    Robot,
    Stribeck,
    Way,
    share,
)
from peers.work import Array

_BLOCK = 2048
# Largest step within 1 % of the limit, and one small enough to stand for the limit.
ROBOT_STEP, ROBOT_FINE = 5e-3, 2e-4


def stribeck(p: Stribeck) -> Array:
    """W3 in whole arrays."""
    h = p.STEP

    def rate(v: Array, t: float) -> Array:
        level = p.coulomb + (p.static - p.coulomb) * np.exp(-((v / p.stribeck) ** 2))
        drive = p.amplitude * np.sin(2 * np.pi * t)
        a: Array = (drive - level * np.tanh(v / p.width) - p.viscous * v) / p.mass
        return a

    x, v = np.zeros(p.size), np.zeros(p.size)
    for i in range(p.STEPS):
        t = i * h
        a1 = rate(v, t)
        v2 = v + h / 2 * a1
        a2 = rate(v2, t + h / 2)
        v3 = v + h / 2 * a2
        a3 = rate(v3, t + h / 2)
        v4 = v + h * a3
        a4 = rate(v4, t + h)
        x = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return np.stack((x, v), axis=-1)


def stribeck_blocked(p: Stribeck) -> Array:
    """W3 in blocks that stay in the caches, in place."""
    out = np.empty((p.size, 2))
    for start in range(0, p.size, _BLOCK):
        rows = slice(start, start + _BLOCK)
        out[rows] = _stribeck_block(p.take(rows))
    return out


def _stribeck_block(p: Stribeck) -> Array:
    h = p.STEP
    times = h / 2 * np.arange(2 * p.STEPS + 1)
    drive = np.sin(2 * np.pi * times)
    # All constants of a point folded, so that the loop has as few passes as possible.
    minus, amplitude = -1.0 / p.stribeck**2, p.amplitude / p.mass
    coulomb, excess = p.coulomb / p.mass, (p.static - p.coulomb) / p.mass
    viscous, steep = p.viscous / p.mass, 1.0 / p.width
    x, v = np.zeros(p.size), np.zeros(p.size)
    w, a, level, bent, sum_v, sum_a = (np.empty(p.size) for _ in range(6))

    def rate(w: Array, at: int) -> None:
        np.multiply(w, w, out=level)
        np.multiply(level, minus, out=level)
        np.exp(level, out=level)
        np.multiply(level, excess, out=level)
        np.add(level, coulomb, out=level)
        np.multiply(w, steep, out=bent)
        np.tanh(bent, out=bent)
        np.multiply(level, bent, out=level)
        np.multiply(amplitude, drive[at], out=a)
        np.subtract(a, level, out=a)
        np.multiply(w, viscous, out=bent)
        np.subtract(a, bent, out=a)

    for i in range(p.STEPS):
        rate(v, 2 * i)
        np.copyto(sum_v, v)
        np.copyto(sum_a, a)
        for stage, part in ((2 * i + 1, h / 2), (2 * i + 1, h / 2), (2 * i + 2, h)):
            np.multiply(a, part, out=w)
            np.add(w, v, out=w)
            rate(w, stage)
            weight = 1.0 if stage == 2 * i + 2 else 2.0
            np.multiply(w, weight, out=w)
            np.add(sum_v, w, out=sum_v)
            # The last stage's rate is not needed any more.
            np.multiply(a, weight, out=bent)
            np.add(sum_a, bent, out=sum_a)
        sum_v *= h / 6
        sum_a *= h / 6
        x += sum_v
        v += sum_a
    return np.stack((x, v), axis=-1)


def pulses(p: Pulses) -> Array:
    """W5 exactly: exponentials between the events, all points at once."""
    x, v = np.zeros(p.size), np.zeros(p.size)
    decay = p.viscous / p.mass
    for phase in range(2 * p.PERIODS):
        drive, left = (-p.back, p.t_off) if phase % 2 else (p.forward, p.t_on)
        starts = np.where(np.abs(drive) > p.static, np.sign(drive), 0.0)
        # A phase has two pieces at most: until the body stops, and after that.
        for _ in range(2):
            sign = np.where(v != 0, np.sign(v), starts)
            final = (drive - sign * p.coulomb) / p.viscous
            slows = (v != 0) & (final * sign < 0)
            stop = np.log1p(
                -v / np.where(slows, final, 1.0), where=slows, out=np.full(p.size, np.inf)
            )
            stop /= decay
            time = np.minimum(stop, left)
            done = -np.expm1(-decay * time)
            x = x + np.where(sign != 0, final * time + (v - final) * done / decay, 0.0)
            v = np.where((sign != 0) & (stop > left), v + (final - v) * done, 0.0)
            left = left - time
    return np.stack((x, v), axis=-1)


def robot(p: Robot, step: float) -> Array:
    """Advance of robots by time stepping: friction takes from each momentum what it can."""
    lengths = p.commanded(p.midpoints(step))
    # Segments along the first axis: neighbours are whole rows.
    x, v = np.zeros((p.SEGMENTS, p.size)), np.zeros((p.SEGMENTS, p.size))
    force = np.zeros((p.SEGMENTS + 1, p.size))
    inner, most = force[1:-1], p.drag * step / SEGMENT_MASS
    for length in lengths:
        np.subtract(length[:, None], x[:-1] - x[1:], out=inner)
        inner *= p.STIFFNESS
        inner -= p.DAMPING * (v[:-1] - v[1:])
        np.clip(inner, -p.limit, p.limit, out=inner)
        v += (step / SEGMENT_MASS) * (force[1:] - force[:-1])
        v -= np.clip(v, -most, most)
        x += step * v
    advance: Array = x.mean(axis=0, keepdims=True).T
    return advance


def replay(p: Replays) -> Array:
    """Positions at all samples, exactly: all candidates at once, sample by sample."""
    force = np.ascontiguousarray(p.force().T) - WEIGHT
    viscous = VISCOUS + p.viscous
    decay = viscous / SEGMENT_MASS
    x, v = np.zeros(p.size), np.zeros(p.size)
    out = np.empty((SAMPLES, p.size))
    for n, push in enumerate(force):
        out[n] = x
        left = np.full(p.size, INTERVAL)
        starts = np.where(np.abs(push) > COULOMB, np.sign(push), 0.0)
        # An interval has two pieces at most: until the head stops, and after that.
        for _ in range(2):
            sign = np.where(v != 0, np.sign(v), starts)
            final = (push - sign * COULOMB) / viscous
            slows = (v != 0) & (final * sign < 0)
            stop = np.log1p(
                -v / np.where(slows, final, 1.0), where=slows, out=np.full(p.size, np.inf)
            )
            stop /= decay
            time = np.minimum(stop, left)
            done = -np.expm1(-decay * time)
            x = x + np.where(sign != 0, final * time + (v - final) * done / decay, 0.0)
            v = np.where((sign != 0) & (stop > left), v + (final - v) * done, 0.0)
            left = left - time
    return np.ascontiguousarray(out.T)


def reference(work: str, points: Points) -> Array | None:
    """Return what all ways are checked against, or None where NumPy does not attain it."""
    if isinstance(points, Stribeck):
        return stribeck(points)
    if isinstance(points, Pulses):
        return pulses(points)
    if isinstance(points, Robot):
        return robot(points, ROBOT_FINE)
    if isinstance(points, Replays):
        return replay(points)
    assert work in (LUGRE, BRISTLES)
    return None


def ways(work: str, points: Points) -> list[Way]:
    """List NumPy's ways to do a work, on one thread."""
    if work == STRIBECK and isinstance(points, Stribeck):
        some = points.some(share(points, 0.1, 200))
        return [
            Way("numpy", "numpy, whole arrays", 1, partial(stribeck, some), points=some.size),
            Way(
                "numpy.blocked",
                "numpy, blocks in place",
                1,
                partial(stribeck_blocked, some),
                points=some.size,
            ),
        ]
    if work == PULSES and isinstance(points, Pulses):
        return [Way("numpy", "numpy, exact pieces", 1, partial(pulses, points), points=points.size)]
    if work == ROBOT and isinstance(points, Robot):
        call = partial(robot, points, ROBOT_STEP)
        label = f"numpy, time stepping at {ROBOT_STEP:g} s"
        steps = round(points.END / ROBOT_STEP)
        return [
            Way("numpy", label, 1, call, points=points.size, allowed=ATTAIN[ROBOT], steps=steps)
        ]
    if work == REPLAY and isinstance(points, Replays):
        call = partial(replay, points)
        label = "numpy, exact pieces"
        return [Way("numpy", label, 1, call, points=points.size, steps=SAMPLES)]
    return []
