"""numba on smooth friction: the loops of W3 and W4, and W3 on lanes by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from llvmlite import ir
from numba import float64, int64, njit, prange
from numba.extending import intrinsic

from peers.with_numba import compiled
from peers.work import Array

# Lanes of one pass: a few vectors, so that their latencies overlap, all in registers or L1.
LANES = 64
_LOG2E, _LN2_HIGH, _LN2_LOW = 1.4426950408889634, 0.693147180369123816490, 1.90821492927058770e-10
# Adding this rounds to an integer and leaves it in the low bits.
_ROUND = 6755399441055744.0


@njit(error_model="numpy")
def stribeck_rate(
    v: float,
    t: float,
    amplitude: float,
    coulomb: float,
    static: float,
    stribeck: float,
    width: float,
    viscous: float,
    mass: float,
) -> float:
    level = coulomb + (static - coulomb) * math.exp(-((v / stribeck) ** 2))
    drive = amplitude * math.sin(2 * math.pi * t)
    return (drive - level * math.tanh(v / width) - viscous * v) / mass


@compiled
def stribeck(
    amplitude: Array,
    coulomb: Array,
    static: Array,
    stribeck: Array,
    width: Array,
    viscous: Array,
    mass: Array,
    steps: int,
    h: float,
    out: Array,
) -> None:
    for i in prange(amplitude.size):
        p = amplitude[i], coulomb[i], static[i], stribeck[i], width[i], viscous[i], mass[i]
        x, v = 0.0, 0.0
        for n in range(steps):
            t = n * h
            a1 = stribeck_rate(v, t, *p)
            v2 = v + h / 2 * a1
            a2 = stribeck_rate(v2, t + h / 2, *p)
            v3 = v + h / 2 * a2
            a3 = stribeck_rate(v3, t + h / 2, *p)
            v4 = v + h * a3
            a4 = stribeck_rate(v4, t + h, *p)
            x += h / 6 * (v + 2 * v2 + 2 * v3 + v4)
            v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        out[i, 0] = x
        out[i, 1] = v


def _cast(given: Any, result: Any, to: Any) -> Any:
    """Return a function that takes a number's bits for those of another type."""

    def typed(_typing: Any, value: Any) -> Any:
        def emit(_context: Any, builder: Any, _signature: Any, args: Any) -> Any:
            return builder.bitcast(args[0], to)

        return (result(given), emit) if value == given else None

    return intrinsic(typed)


_bits = _cast(float64, int64, ir.IntType(64))
_from_bits = _cast(int64, float64, ir.DoubleType())


# Not inlined by numba but by LLVM, so that it keeps its own flags: reordered, its rounding is void.
@njit(error_model="numpy", fastmath={"contract"})
def _exp(x: float) -> Any:
    # No call and no branch: LLVM makes vectors of it. Good to 1e-14, for -708 < x < 708.
    shifted = x * _LOG2E + _ROUND
    k = shifted - _ROUND
    r = (x - k * _LN2_HIGH) - k * _LN2_LOW
    s = 1 / 39916800
    s = s * r + 1 / 3628800
    s = s * r + 1 / 362880
    s = s * r + 1 / 40320
    s = s * r + 1 / 5040
    s = s * r + 1 / 720
    s = s * r + 1 / 120
    s = s * r + 1 / 24
    s = s * r + 1 / 6
    s = s * r + 0.5
    s = s * r + 1.0
    s = s * r + 1.0
    return _from_bits(_bits(s) + (_bits(shifted) << 52))


@njit(parallel=True, error_model="numpy", fastmath=True)
def stribeck_lanes(
    amplitude: Array,
    coulomb: Array,
    static: Array,
    stribeck: Array,
    width: Array,
    viscous: Array,
    mass: Array,
    drive: Array,
    h: float,
    out: Array,
) -> None:
    count = amplitude.size
    for block in prange((count + LANES - 1) // LANES):
        first = block * LANES
        # The last block starts earlier rather than being shorter; it writes the same again.
        first = max(0, min(first, count - LANES))
        lanes = min(LANES, count)
        p = np.empty((7, LANES))
        s = np.zeros((6, LANES))
        for j in range(lanes):
            i = first + j
            p[0, j] = amplitude[i] / mass[i]
            p[1, j] = coulomb[i] / mass[i]
            p[2, j] = (static[i] - coulomb[i]) / mass[i]
            p[3, j] = -1 / stribeck[i] ** 2
            p[4, j] = 2 / width[i]
            p[5, j] = viscous[i] / mass[i]
        for n in range(drive.size // 2):
            for stage in range(4):
                u = drive[2 * n + (stage + 1) // 2]
                to_next = h if stage == 2 else h / 2
                weight = 1.0 if stage == 0 or stage == 3 else 2.0
                keep = 0.0 if stage == 0 else 1.0
                for j in range(LANES):
                    w = s[1, j] if stage == 0 else s[2, j]
                    level = p[1, j] + p[2, j] * _exp(max(p[3, j] * w * w, -700.0))
                    bent = 1 - 2 / (_exp(min(max(p[4, j] * w, -40.0), 40.0)) + 1)
                    a = p[0, j] * u - level * bent - p[5, j] * w
                    s[3, j] = keep * s[3, j] + weight * w
                    s[4, j] = keep * s[4, j] + weight * a
                    s[2, j] = s[1, j] + to_next * a
            for j in range(LANES):
                s[0, j] += h / 6 * s[3, j]
                s[1, j] += h / 6 * s[4, j]
        for j in range(lanes):
            out[first + j, 0] = s[0, j]
            out[first + j, 1] = s[1, j]


@njit(error_model="numpy")
def lugre_rate(
    t: float,
    x: float,
    v: float,
    z: float,
    stiffness: float,
    static: float,
    s0: float,
    s1: float,
    s2: float,
    coulomb: float,
    stribeck: float,
    mass: float,
    pull: float,
) -> tuple[float, float, float]:
    g = coulomb + (static - coulomb) * math.exp(-((v / stribeck) ** 2))
    dz = v - s0 * abs(v) * z / g
    force = s0 * z + s1 * dz + s2 * v
    return v, (stiffness * (pull * t - x) - force) / mass, dz


@compiled
def lugre(
    stiffness: Array, static: Array, constants: tuple[float, ...], steps: int, h: float, out: Array
) -> None:
    for i in prange(stiffness.size):
        x, v, z = 0.0, 0.0, 0.0
        p = stiffness[i], static[i]
        q = h / 2
        for n in range(steps):
            t = n * h
            x1, v1, z1 = lugre_rate(t, x, v, z, *p, *constants)
            x2, v2, z2 = lugre_rate(t + q, x + q * x1, v + q * v1, z + q * z1, *p, *constants)
            x3, v3, z3 = lugre_rate(t + q, x + q * x2, v + q * v2, z + q * z2, *p, *constants)
            x4, v4, z4 = lugre_rate(t + h, x + h * x3, v + h * v3, z + h * z3, *p, *constants)
            x += h / 6 * (x1 + 2 * x2 + 2 * x3 + x4)
            v += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
            z += h / 6 * (z1 + 2 * z2 + 2 * z3 + z4)
        out[i, 0] = x
