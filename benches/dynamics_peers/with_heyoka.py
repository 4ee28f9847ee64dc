"""heyoka: Taylor series of high order, and one RK4 step compiled as a function."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import heyoka as hy
import numpy as np

from common.threads import thread_counts
from dynamics_peers.work import ATTAIN, LUGRE, STRIBECK, LuGre, Points, Stribeck, Way, share
from peers.work import Array

# The loosest that attain what the work asks for; choose.py shows the others. Looser ones
# step over the poles of tanh beside the real axis and miss reversals altogether.
STRIBECK_TOLERANCE, LUGRE_TOLERANCE = 1e-15, 1e-16
_LANES = 8


@contextmanager
def _threads(count: int) -> Iterator[None]:
    before = hy.get_nthreads()
    hy.set_nthreads(count)
    try:
        yield
    finally:
        hy.set_nthreads(before)


def _stribeck_rate(v: Any, t: Any) -> Any:
    amplitude, coulomb, static, stribeck, width, viscous, mass = (hy.par[i] for i in range(7))
    level = coulomb + (static - coulomb) * hy.exp(-((v / stribeck) ** 2))
    drive = amplitude * hy.sin(2 * np.pi * t)
    return (drive - level * hy.tanh(v / width) - viscous * v) / mass


def stribeck_compiled(p: Stribeck) -> Callable[[], Array]:
    """W3 by RK4; one step is one compiled function."""
    x, v = hy.make_vars("x", "v")
    t, h = hy.time, p.STEP
    a1 = _stribeck_rate(v, t)
    v2 = v + h / 2 * a1
    a2 = _stribeck_rate(v2, t + h / 2)
    v3 = v + h / 2 * a2
    a3 = _stribeck_rate(v3, t + h / 2)
    v4 = v + h * a3
    a4 = _stribeck_rate(v4, t + h)
    step = hy.cfunc(
        [x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)],
        vars=[x, v],
        fast_math=True,
    )
    parameters = np.array(p.columns)

    def call() -> Array:
        state, after, time = np.zeros((2, p.size)), np.empty((2, p.size)), np.empty(p.size)
        for i in range(p.STEPS):
            time.fill(i * h)
            step(state, outputs=after, pars=parameters, time=time)
            state, after = after, state
        return state.T

    return call


def _propagate(integrator: Any, p: Points, end: float, states: int) -> Array:
    """Carry all points to the end, as many at a time as the integrator has lanes."""
    columns = np.array(p.columns)
    out = np.empty((states, p.size))
    for first in range(0, p.size, _LANES):
        lanes = slice(first, first + _LANES)
        part = columns[:, lanes]
        integrator.set_time(0.0)
        integrator.state[:] = 0.0
        # The last batch is filled up with its first point.
        integrator.pars[:] = part[:, :1]
        integrator.pars[:, : part.shape[1]] = part
        integrator.propagate_until(end)
        out[:, lanes] = integrator.state[:states, : part.shape[1]]
    return out.T


def stribeck(p: Stribeck, tolerance: float) -> Callable[[], Array]:
    """W3 by Taylor series."""
    x, v = hy.make_vars("x", "v")
    integrator = hy.taylor_adaptive_batch(
        [(x, v), (v, _stribeck_rate(v, hy.time))],
        np.zeros((2, _LANES)),
        pars=np.zeros((7, _LANES)),
        tol=tolerance,
        fast_math=True,
    )
    return partial(_propagate, integrator, p, p.END, 2)


def lugre(p: LuGre, tolerance: float) -> Callable[[], Array]:
    """W4 by Taylor series; |v| from its two sides, which events at v = 0 do not improve."""
    x, v, z = hy.make_vars("x", "v", "z")
    stiffness, static = hy.par[0], hy.par[1]
    g = p.COULOMB + (static - p.COULOMB) * hy.exp(-((v / p.VELOCITY) ** 2))
    dz = v - p.SIGMA0 * (hy.relu(v) + hy.relu(-v)) * z / g
    force = p.SIGMA0 * z + p.SIGMA1 * dz + p.SIGMA2 * v
    a = (stiffness * (p.PULL * hy.time - x) - force) / p.MASS
    integrator = hy.taylor_adaptive_batch(
        [(x, v), (v, a), (z, dz)],
        np.zeros((3, _LANES)),
        pars=np.ones((2, _LANES)),
        tol=tolerance,
        fast_math=True,
    )
    return partial(_propagate, integrator, p, p.END, 1)


def ways(work: str, points: Points) -> list[Way]:
    """List heyoka's ways to do a work; its integrators keep Python's lock, so on one thread."""
    if work == STRIBECK and isinstance(points, Stribeck):
        some = points.some(share(points, 0.05, 200))
        step = stribeck_compiled(some)
        found = [
            Way(
                "heyoka.compiled",
                "heyoka, RK4 step compiled",
                n,
                step,
                around=partial(_threads, n),
                points=some.size,
                steps=points.STEPS,
            )
            for n in thread_counts()
        ]
        call = stribeck(some, STRIBECK_TOLERANCE)
        label = f"heyoka, Taylor at {STRIBECK_TOLERANCE:g}"
        allowed = ATTAIN[STRIBECK]
        return [*found, Way("heyoka", label, 1, call, points=some.size, allowed=allowed)]
    if work == LUGRE and isinstance(points, LuGre):
        call = lugre(points, LUGRE_TOLERANCE)
        label = f"heyoka, Taylor at {LUGRE_TOLERANCE:g}"
        return [Way("heyoka", label, 1, call, points=points.size, allowed=ATTAIN[LUGRE])]
    return []
