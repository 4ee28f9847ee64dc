"""numba on friction that sticks: the loops of W5 and of the robot."""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange

from peers.with_numba import compiled
from peers.work import Array


@njit(error_model="numpy")
def pulse_step(
    x: float, v: float, force: float, viscous: float, mass: float, h: float
) -> tuple[float, float]:
    a1 = (force - viscous * v) / mass
    v2 = v + h / 2 * a1
    a2 = (force - viscous * v2) / mass
    v3 = v + h / 2 * a2
    a3 = (force - viscous * v3) / mass
    v4 = v + h * a3
    a4 = (force - viscous * v4) / mass
    return x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


@compiled
def pulses_located(
    forward: Array,
    back: Array,
    t_on: Array,
    t_off: Array,
    coulomb: Array,
    static: Array,
    viscous: Array,
    mass: Array,
    periods: int,
    step: float,
    within: float,
    out: Array,
) -> None:
    for i in prange(forward.size):
        x, v = 0.0, 0.0
        for phase in range(2 * periods):
            drive, left = (forward[i], t_on[i]) if phase % 2 == 0 else (-back[i], t_off[i])
            while left > 0:
                if v == 0 and abs(drive) <= static[i]:
                    break
                sign = math.copysign(1.0, v if v != 0 else drive)
                force = drive - sign * coulomb[i]
                h = min(step, left)
                x_next, v_next = pulse_step(x, v, force, viscous[i], mass[i], h)
                if v_next * sign < 0:
                    # It stops within this step: halve until the instant is known.
                    low = 0.0
                    while h - low > within:
                        middle = (low + h) / 2
                        x_next, v_next = pulse_step(x, v, force, viscous[i], mass[i], middle)
                        if v_next * sign < 0:
                            h = middle
                        else:
                            low = middle
                    v_next = 0.0
                x, v = x_next, v_next
                left -= h
        out[i, 0] = x
        out[i, 1] = v


@compiled
def pulses_smoothed(
    forward: Array,
    back: Array,
    t_on: Array,
    t_off: Array,
    coulomb: Array,
    static: Array,
    viscous: Array,
    mass: Array,
    periods: int,
    step: float,
    width: float,
    stribeck: float,
    out: Array,
) -> None:
    for i in prange(forward.size):
        x, v = 0.0, 0.0
        c, excess = coulomb[i], static[i] - coulomb[i]
        for phase in range(2 * periods):
            drive, span = (forward[i], t_on[i]) if phase % 2 == 0 else (-back[i], t_off[i])
            steps = math.ceil(span / step)
            h = span / steps
            for _ in range(steps):
                x_sum, v_sum, w = 0.0, 0.0, v
                for stage in range(4):
                    level = c + excess * math.exp(-((w / stribeck) ** 2))
                    a = (drive - level * math.tanh(w / width) - viscous[i] * w) / mass[i]
                    weight = 1.0 if stage == 0 or stage == 3 else 2.0
                    x_sum += weight * w
                    v_sum += weight * a
                    w = v + (h if stage == 2 else h / 2) * a
                x += h / 6 * x_sum
                v += h / 6 * v_sum
        out[i, 0] = x
        out[i, 1] = v


@compiled
def pulses_exact(
    forward: Array,
    back: Array,
    t_on: Array,
    t_off: Array,
    coulomb: Array,
    static: Array,
    viscous: Array,
    mass: Array,
    periods: int,
    out: Array,
) -> None:
    for i in prange(forward.size):
        x, v = 0.0, 0.0
        decay = viscous[i] / mass[i]
        for phase in range(2 * periods):
            drive, left = (forward[i], t_on[i]) if phase % 2 == 0 else (-back[i], t_off[i])
            while left > 0:
                if v == 0 and abs(drive) <= static[i]:
                    break
                sign = math.copysign(1.0, v if v != 0 else drive)
                final = (drive - sign * coulomb[i]) / viscous[i]
                time = left
                if v != 0 and final * sign < 0:
                    time = min(left, math.log1p(-v / final) / decay)
                done = -math.expm1(-decay * time)
                x += final * time + (v - final) * done / decay
                v = v + (final - v) * done if time == left else 0.0
                left -= time
        out[i, 0] = x
        out[i, 1] = v


@compiled
def robot_stepped(
    drag: Array,
    limit: Array,
    lengths: Array,
    step: float,
    mass: float,
    stiffness: float,
    damping: float,
    out: Array,
) -> None:
    segments = lengths.shape[1] + 1
    for i in prange(drag.size):
        x, v, force = np.zeros(segments), np.zeros(segments), np.zeros(segments + 1)
        most, per = drag[i] * step / mass, step / mass
        for n in range(lengths.shape[0]):
            for j in range(segments - 1):
                f = stiffness * (lengths[n, j] - x[j] + x[j + 1]) - damping * (v[j] - v[j + 1])
                force[j + 1] = min(max(f, -limit[i]), limit[i])
            for j in range(segments):
                w = v[j] + per * (force[j + 1] - force[j])
                v[j] = w - min(max(w, -most), most)
                x[j] += step * v[j]
        out[i, 0] = x.mean()


@njit(error_model="numpy")
def robot_rate(
    x: Array,
    v: Array,
    commanded: Array,
    drag: float,
    limit: float,
    mass: float,
    stiffness: float,
    damping: float,
    width: float,
    a: Array,
) -> None:
    behind = 0.0
    for j in range(x.size):
        ahead = 0.0
        if j < x.size - 1:
            f = stiffness * (commanded[j] - x[j] + x[j + 1]) - damping * (v[j] - v[j + 1])
            ahead = min(max(f, -limit), limit)
        a[j] = (ahead - behind - drag * math.tanh(v[j] / width)) / mass
        behind = ahead


@compiled
def robot_smoothed(
    drag: Array,
    limit: Array,
    lengths: Array,
    step: float,
    mass: float,
    stiffness: float,
    damping: float,
    width: float,
    out: Array,
) -> None:
    # Commands at every half step: the first of a step, its middle, and the first of the next.
    segments = lengths.shape[1] + 1
    for i in prange(drag.size):
        x, v = np.zeros(segments), np.zeros(segments)
        y, w, a = np.zeros(segments), np.zeros(segments), np.zeros(segments)
        x_sum, v_sum = np.zeros(segments), np.zeros(segments)
        for n in range(lengths.shape[0] // 2):
            y[:] = x
            w[:] = v
            x_sum[:] = 0.0
            v_sum[:] = 0.0
            for stage in range(4):
                commanded = lengths[2 * n + (stage + 1) // 2]
                robot_rate(y, w, commanded, drag[i], limit[i], mass, stiffness, damping, width, a)
                weight = 1.0 if stage == 0 or stage == 3 else 2.0
                part = step if stage == 2 else step / 2
                for j in range(segments):
                    x_sum[j] += weight * w[j]
                    v_sum[j] += weight * a[j]
                    y[j] = x[j] + part * w[j]
                    w[j] = v[j] + part * a[j]
            for j in range(segments):
                x[j] += step / 6 * x_sum[j]
                v[j] += step / 6 * v_sum[j]
        out[i, 0] = x.mean()
