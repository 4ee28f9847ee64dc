"""numba on replays: a position for every sample, exactly and with bristles."""

from __future__ import annotations

import math

from numba import prange

from peers.with_numba import compiled
from peers.work import Array


@compiled
def exact(
    force: Array,
    viscous: Array,
    coulomb: float,
    weight: float,
    mass: float,
    interval: float,
    out: Array,
) -> None:
    for i in prange(force.shape[0]):
        x, v = 0.0, 0.0
        c = viscous[i]
        decay = c / mass
        for n in range(force.shape[1]):
            out[i, n] = x
            push, left = force[i, n] - weight, interval
            while left > 0:
                if v == 0 and abs(push) <= coulomb:
                    break
                sign = math.copysign(1.0, v if v != 0 else push)
                final = (push - sign * coulomb) / c
                time = left
                if v != 0 and final * sign < 0:
                    time = min(left, math.log1p(-v / final) / decay)
                done = -math.expm1(-decay * time)
                x += final * time + (v - final) * done / decay
                v = v + (final - v) * done if time == left else 0.0
                left -= time


@compiled
def bristles(
    force: Array,
    stiffness: Array,
    damping: Array,
    viscous: float,
    coulomb: float,
    weight: float,
    mass: float,
    interval: float,
    steps: int,
    out: Array,
) -> None:
    h = interval / steps
    for i in prange(force.shape[0]):
        x, v, z = 0.0, 0.0, 0.0
        s0, s1 = stiffness[i], damping[i]
        for n in range(force.shape[1]):
            out[i, n] = x
            push = force[i, n] - weight
            for _ in range(steps):
                w, u = v, z
                x_sum, v_sum, z_sum = 0.0, 0.0, 0.0
                for stage in range(4):
                    dz = w - s0 * abs(w) * u / coulomb
                    a = (push - s0 * u - s1 * dz - viscous * w) / mass
                    weighs = 1.0 if stage == 0 or stage == 3 else 2.0
                    x_sum += weighs * w
                    v_sum += weighs * a
                    z_sum += weighs * dz
                    part = h if stage == 2 else h / 2
                    w, u = v + part * a, z + part * dz
                x += h / 6 * x_sum
                v += h / 6 * v_sum
                z += h / 6 * z_sum
