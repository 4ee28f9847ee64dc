"""diffrax: adaptive solvers, all trajectories of a call side by side."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

from dynamics_peers.with_jax import with_threads
from dynamics_peers.work import ATTAIN, LUGRE, STRIBECK, LuGre, Points, Stribeck, Way, share
from peers.work import Array

# The loosest that attain what the work asks for; choose.py shows the others.
STRIBECK_TOLERANCE, LUGRE_TOLERANCE = 1e-6, 1e-5
# Absolute tolerances are smaller by this: states are some 0.1, the bristles of LuGre 1e-5.
_BELOW = {STRIBECK: 1e-2, LUGRE: 1e-3}


def _ensemble(
    rate: Callable[..., Any], solver: Any, end: float, states: int, rtol: float, atol: float
) -> Callable[..., Any]:
    def one(parameters: Any) -> Any:
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(rate),
            solver,
            t0=0.0,
            t1=end,
            dt0=1e-5,
            y0=jnp.zeros(states),
            args=parameters,
            stepsize_controller=diffrax.PIDController(rtol=rtol, atol=atol),
            saveat=diffrax.SaveAt(t1=True),
            max_steps=1_000_000,
        )
        return solution.ys[-1]

    return jax.jit(jax.vmap(one))


def _stribeck_rate(t: Any, y: Any, parameters: Any) -> Any:
    amplitude, coulomb, static, stribeck, width, viscous, mass = parameters
    v = y[1]
    level = coulomb + (static - coulomb) * jnp.exp(-((v / stribeck) ** 2))
    drive = amplitude * jnp.sin(2 * jnp.pi * t)
    return jnp.stack((v, (drive - level * jnp.tanh(v / width) - viscous * v) / mass))


def _lugre_rate(t: Any, y: Any, parameters: Any) -> Any:
    stiffness, static = parameters
    x, v, z = y
    p = LuGre
    g = p.COULOMB + (static - p.COULOMB) * jnp.exp(-((v / p.VELOCITY) ** 2))
    dz = v - p.SIGMA0 * jnp.abs(v) * z / g
    force = p.SIGMA0 * z + p.SIGMA1 * dz + p.SIGMA2 * v
    return jnp.stack((v, (stiffness * (p.PULL * t - x) - force) / p.MASS, dz))


def stribeck(p: Stribeck, tolerance: float) -> Callable[[], Array]:
    """W3 by Tsit5."""
    atol = tolerance * _BELOW[STRIBECK]
    run = _ensemble(_stribeck_rate, diffrax.Tsit5(), p.END, 2, tolerance, atol)
    given = tuple(jnp.asarray(column) for column in p.columns)
    return lambda: np.asarray(run(given))


def lugre(p: LuGre, tolerance: float) -> Callable[[], Array]:
    """W4 by Kvaerno5."""
    atol = tolerance * _BELOW[LUGRE]
    run = _ensemble(_lugre_rate, diffrax.Kvaerno5(), p.END, 3, tolerance, atol)
    given = tuple(jnp.asarray(column) for column in p.columns)
    return lambda: np.asarray(run(given))[:, :1]


def ways(work: str, points: Points) -> list[Way]:
    """List diffrax's ways to do a work."""
    if work == STRIBECK and isinstance(points, Stribeck):
        some = points.some(share(points, 0.02, 100))
        label = f"diffrax, Tsit5 at {STRIBECK_TOLERANCE:g}"
        call = stribeck(some, STRIBECK_TOLERANCE)
        return with_threads("diffrax", label, call, some.size, allowed=ATTAIN[STRIBECK])
    if work == LUGRE and isinstance(points, LuGre):
        label = f"diffrax, Kvaerno5 at {LUGRE_TOLERANCE:g}"
        # Some seconds for all of them, and what lasts is the slowest of each call.
        few = points.some(share(points, 0.06, 4))
        call = lugre(few, LUGRE_TOLERANCE)
        return with_threads("diffrax", label, call, few.size, allowed=ATTAIN[LUGRE])
    return []
