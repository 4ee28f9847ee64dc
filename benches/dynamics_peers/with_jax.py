"""JAX: compiled loops over whole arrays, and diffrax's adaptive solvers."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from common.threads import one_processor, thread_counts
from dynamics_peers.work import STRIBECK, Points, Stribeck, Way, share
from peers.work import Array

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_platforms", "cpu")


def _advance(columns: Any, count: int, h: float) -> Any:
    amplitude, coulomb, static, stribeck, width, viscous, mass = columns

    def rate(v: Any, t: Any) -> Any:
        level = coulomb + (static - coulomb) * jnp.exp(-((v / stribeck) ** 2))
        drive = amplitude * jnp.sin(2 * jnp.pi * t)
        return (drive - level * jnp.tanh(v / width) - viscous * v) / mass

    def step(i: Any, state: tuple[Any, Any]) -> tuple[Any, Any]:
        x, v = state
        t = i * h
        a1 = rate(v, t)
        v2 = v + h / 2 * a1
        a2 = rate(v2, t + h / 2)
        v3 = v + h / 2 * a2
        a3 = rate(v3, t + h / 2)
        v4 = v + h * a3
        a4 = rate(v4, t + h)
        return x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)

    rest = jnp.zeros_like(amplitude)
    return jnp.stack(jax.lax.fori_loop(0, count, step, (rest, rest)), axis=-1)


def stribeck(p: Stribeck) -> Callable[[], Array]:
    """W3 with every stage over all points."""
    given = tuple(jnp.asarray(column) for column in p.columns)
    run = jax.jit(partial(_advance, count=p.STEPS, h=p.STEP))
    return lambda: np.asarray(run(given))


def stribeck_split(p: Stribeck) -> Callable[[], Array]:
    """W3 in as many parts as processors, as JAX keeps a loop like this on one thread."""
    threads = thread_counts()[-1]
    rows = np.array_split(np.arange(p.size), threads)
    parts = [stribeck(p.take(slice(int(part[0]), int(part[-1]) + 1))) for part in rows]
    pool = ThreadPoolExecutor(threads)
    return lambda: np.concatenate(list(pool.map(lambda part: part(), parts)))


def with_threads(
    key: str, label: str, call: Callable[[], Array], points: int, **more: Any
) -> list[Way]:
    """Return one way for each number of threads."""
    found = [Way(key, label, 1, call, around=one_processor, points=points, **more)]
    if len(thread_counts()) > 1:
        found.append(Way(key, label, 2, call, points=points, **more))
    return found


def ways(work: str, points: Points) -> list[Way]:
    """List JAX's ways to do a work."""
    if work != STRIBECK or not isinstance(points, Stribeck):
        return []
    some = points.some(share(points, 0.2, 200))
    steps = Stribeck.STEPS
    found = with_threads("jax", "jax, whole arrays", stribeck(some), some.size, steps=steps)
    if len(thread_counts()) > 1:
        call, size = stribeck_split(some), some.size
        found.append(Way("jax", "jax, an array per thread", 2, call, points=size, steps=steps))
    return found
