"""SciPy: one trajectory after the other; also the reference of the stiff work."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from dynamics_peers.replays import COULOMB, INTERVAL, SAMPLES, VISCOUS, WEIGHT, Bristles
from dynamics_peers.work import (
    ATTAIN,
    BRISTLES,
    LUGRE,
    ROBOT,
    SEGMENT_MASS,
    STRIBECK,
    LuGre,
    Points,
    Robot,
    Stribeck,
    Way,
    share,
)
from peers.work import Array

Rate = Callable[..., Any]

# The loosest relative tolerances that attain what the work asks for, and the absolute ones
# as a part of them; choose.py shows the others.
STRIBECK_METHODS = {"RK45": (1e-7, 1e-2), "LSODA": (1e-6, 1e-2)}
LUGRE_METHODS = {"LSODA": (1e-6, 1e-4), "Radau": (1e-5, 1e-3)}
ROBOT_TOLERANCE, ROBOT_WIDTH = 1e-5, 1e-3
# What it is off a Radau at 1e-9 is some 1e-10, and it takes a tenth of the time.
_REFERENCE = ("LSODA", 1e-11, 1e-5)
BRISTLE_TOLERANCE, _BRISTLE_REFERENCE = 1e-5, 1e-10


def _stribeck_rate(
    t: float,
    y: Array,
    amplitude: float,
    coulomb: float,
    static: float,
    stribeck: float,
    width: float,
    viscous: float,
    mass: float,
) -> Any:
    v = y[1]
    level = coulomb + (static - coulomb) * np.exp(-((v / stribeck) ** 2))
    drive = amplitude * np.sin(2 * np.pi * t)
    return np.array((v, (drive - level * np.tanh(v / width) - viscous * v) / mass))


# Bound here, as a compiler takes globals for constants.
_S0, _S1, _S2 = LuGre.SIGMA0, LuGre.SIGMA1, LuGre.SIGMA2
_FC, _VS, _M, _V = LuGre.COULOMB, LuGre.VELOCITY, LuGre.MASS, LuGre.PULL


def _lugre_rate(t: float, y: Array, stiffness: float, static: float) -> Any:
    x, v, z = y[0], y[1], y[2]
    g = _FC + (static - _FC) * np.exp(-((v / _VS) ** 2))
    dz = v - _S0 * abs(v) * z / g
    force = _S0 * z + _S1 * dz + _S2 * v
    return np.array((v, (stiffness * (_V * t - x) - force) / _M, dz))


def _solve(
    rate: Rate, states: int, end: float, points: Points, method: str, rtol: float, below: float
) -> Array:
    out = np.empty((points.size, states))
    for i, row in enumerate(zip(*points.columns, strict=True)):
        start = np.zeros(states)
        found = solve_ivp(
            rate, (0.0, end), start, method=method, args=row, rtol=rtol, atol=rtol * below
        )
        if not found.success:
            raise SystemExit(f"scipy, {method}: {found.message}")
        out[i] = found.y[:, -1]
    return out


def stribeck(p: Stribeck, method: str, rtol: float, below: float) -> Array:
    """W3 by an adaptive method."""
    return _solve(_stribeck_rate, 2, p.END, p, method, rtol, below)


def lugre(p: LuGre, method: str, rtol: float, below: float, rate: Rate = _lugre_rate) -> Array:
    """W4 by an adaptive method."""
    return _solve(rate, 3, p.END, p, method, rtol, below)[:, :1]


def robot(p: Robot, rtol: float) -> Array:
    """Advance of robots with smoothed friction, ramp by ramp: no step crosses a kink."""
    return np.array([[_robot(p, i, rtol)] for i in range(p.size)])


def _robot(p: Robot, i: int, rtol: float) -> float:
    n, drag, limit = p.SEGMENTS, p.drag[i], p.limit[i]
    force = np.zeros(n + 1)

    def rate(t: float, y: Array, start: float, first: Array, slope: Array) -> Array:
        x, v = y[:n], y[n:]
        servo = p.STIFFNESS * (first + (t - start) * slope - x[:-1] + x[1:])
        servo -= p.DAMPING * (v[:-1] - v[1:])
        force[1:-1] = np.clip(servo, -limit, limit)
        a = (force[1:] - force[:-1] - drag * np.tanh(v / ROBOT_WIDTH)) / SEGMENT_MASS
        return np.concatenate((v, a))

    y = np.zeros(2 * n)
    ramp = p.STROKE / p.RAMP
    for phase in range(p.CYCLES * n):
        for since, span in ((0.0, ramp), (ramp, p.PHASE - ramp)):
            start = phase * p.PHASE + since
            first, last = p.commanded(start + span * np.array([0.0, 1 - 1e-6]))
            slope = (last - first) / (span * (1 - 1e-6))
            given = (start, first, slope)
            times = (start, start + span)
            found = solve_ivp(
                rate, times, y, method="LSODA", args=given, rtol=rtol, atol=rtol * 1e-3
            )
            y = found.y[:, -1]
    return float(y[:n].mean())


def bristles(p: Bristles, rtol: float) -> Array:
    """Positions at all samples by LSODA, which starts anew where the command jumps."""
    return np.array([_bristles(p, i, rtol) for i in range(p.size)])


def _bristles(p: Bristles, i: int, rtol: float) -> Array:
    s0, s1 = p.stiffness[i], p.damping[i]

    def rate(_t: float, y: Array, push: float) -> Array:
        dz = y[1] - s0 * abs(y[1]) * y[2] / COULOMB
        force = s0 * y[2] + s1 * dz + VISCOUS * y[1]
        return np.array((y[1], (push - force) / SEGMENT_MASS, dz))

    pushes = p.force()[i] - WEIGHT
    out, y = np.empty(SAMPLES), np.zeros(3)
    last = 0
    # Samples with the same command are one stretch.
    for end in [*(np.flatnonzero(np.diff(pushes)) + 1), SAMPLES - 1]:
        at = np.arange(1, end - last + 1) * INTERVAL
        out[last] = y[0]
        if at.size:
            span, push = (0.0, float(at[-1])), (pushes[last],)
            atol = rtol * np.array((1e-2, 1e-1, 1e-5))
            found = solve_ivp(
                rate, span, y, method="LSODA", t_eval=at, args=push, rtol=rtol, atol=atol
            )
            out[last + 1 : end + 1] = found.y[0]
            y = found.y[:, -1]
        last = end
    return out


def compiled_rate() -> Rate:
    """Return the rate of W4 compiled by numba, or as it is where that is not installed."""
    if not importlib.util.find_spec("numba"):
        return _lugre_rate
    from numba import njit

    compiled: Rate = njit(_lugre_rate)
    return compiled


def reference(points: LuGre | Bristles) -> Array:
    """W4 and bristles far more precisely than they are asked for."""
    if isinstance(points, Bristles):
        return bristles(points, _BRISTLE_REFERENCE)
    return lugre(points, *_REFERENCE, compiled_rate())


def ways(work: str, points: Points) -> list[Way]:
    """List SciPy's ways to do a work, on one thread."""
    found: list[Way] = []
    if work == STRIBECK and isinstance(points, Stribeck):
        some = points.some(share(points, 5e-5, 5))
        for method, (rtol, below) in STRIBECK_METHODS.items():
            call: Any = partial(stribeck, some, method, rtol, below)
            label = f"scipy, {method} at {rtol:g}"
            found.append(
                Way(f"scipy.{method}", label, 1, call, points=some.size, allowed=ATTAIN[STRIBECK])
            )
    elif work == LUGRE and isinstance(points, LuGre):
        few = points.some(share(points, 0.1, 4))
        rates, compiled = {"": _lugre_rate}, compiled_rate()
        if compiled is not _lugre_rate:
            rates[", compiled rate"] = compiled
        for method, (rtol, below) in LUGRE_METHODS.items():
            for suffix, rate in rates.items():
                call = partial(lugre, few, method, rtol, below, rate)
                label = f"scipy, {method} at {rtol:g}{suffix}"
                key = f"scipy.{method}{'.compiled' if suffix else ''}"
                found.append(Way(key, label, 1, call, points=few.size, allowed=ATTAIN[LUGRE]))
    elif work == ROBOT and isinstance(points, Robot):
        one = points.some(1)
        label = f"scipy, smoothed, LSODA at {ROBOT_TOLERANCE:g}"
        call = partial(robot, one, ROBOT_TOLERANCE)
        found.append(Way("scipy", label, 1, call, points=1, allowed=None))
    elif work == BRISTLES and isinstance(points, Bristles):
        one = points.some(1)
        label = f"scipy, LSODA at {BRISTLE_TOLERANCE:g}"
        call = partial(bristles, one, BRISTLE_TOLERANCE)
        found.append(
            Way("scipy", label, 1, call, points=1, allowed=ATTAIN[BRISTLES], steps=SAMPLES)
        )
    return found
