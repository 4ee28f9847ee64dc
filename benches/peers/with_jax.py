"""JAX: compiled whole-array expressions in double precision."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp

from common.threads import one_processor, thread_counts
from peers.work import (
    CLOSED,
    COUNTS,
    FRESH,
    GRAVITY,
    REUSED,
    SEARCH,
    STROKE,
    Array,
    Axes,
    Variant,
)

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_platforms", "cpu")


def _dense(mu_static: Any, mu_coulomb: Any, cos: Any, sin: Any, n: Any) -> Any:
    hold = mu_static[:, None, None, None] * cos[:, None] - sin[:, None]
    drag = mu_coulomb[:, None, None] * cos[:, None] + sin[:, None]
    acceleration = GRAVITY * ((n - 1) * hold - drag)
    velocity = jnp.sqrt(STROKE * acceleration / 2) / n
    return jnp.where((hold > 0) & (acceleration > 0), velocity, jnp.nan)


def _dense_into(_used: Any, *axes: Any) -> Any:
    return _dense(*axes)


def _search(mu_static: Any, mu_coulomb: Any, cos: Any, sin: Any) -> Any:
    hold = mu_static[:, None, None] * cos - sin
    drag = mu_coulomb[:, None] * cos + sin

    def try_one(i: Any, kept: tuple[Any, Any]) -> tuple[Any, Any]:
        best, at = kept
        n = i + COUNTS[0]
        acceleration = GRAVITY * ((n - 1) * hold - drag)
        velocity = jnp.sqrt(STROKE * acceleration / 2) / n
        wins = (hold > 0) & (acceleration > 0) & (velocity > best)
        return jnp.where(wins, velocity, best), jnp.where(wins, n, at)

    nothing = jnp.broadcast_to(hold * 0, (hold.shape[0], *drag.shape[:2]))
    return jax.lax.fori_loop(0, COUNTS.size, try_one, (nothing, nothing + jnp.nan))[1]


def _closed(mu_static: Any, mu_coulomb: Any, cos: Any, sin: Any) -> Any:
    hold = mu_static[:, None, None] * cos - sin
    drag = mu_coulomb[:, None] * cos + sin
    low = jnp.clip(jnp.floor(2 * (hold + drag) / hold), COUNTS[0], COUNTS[-1])
    high = jnp.minimum(low + 1, COUNTS[-1])
    push_low, push_high = (low - 1) * hold - drag, (high - 1) * hold - drag
    best = jnp.where(push_high * low**2 > push_low * high**2, high, low)
    return jnp.where((hold > 0) & (push_high > 0), best, jnp.nan)


def _reusing(shape: tuple[int, ...], given: tuple[Any, ...]) -> Callable[[], Any]:
    """Return a call whose result takes the memory of the one before."""
    into = jax.jit(_dense_into, donate_argnums=0, keep_unused=True)
    held = [jnp.zeros(shape)]

    def call() -> Any:
        held[0] = into(held[0], *given).block_until_ready()
        return held[0]

    return call


def variants(group: str, axes: Axes, out: Array) -> list[Variant]:
    """List JAX's ways to do the work of a group."""
    del out
    given = tuple(jnp.asarray(a) for a in (axes.mu_static, axes.mu_coulomb, axes.cos, axes.sin))
    if axes.segments.size:
        given = (*given, jnp.asarray(axes.segments))
    if group == REUSED:
        call = _reusing(axes.shape, given)
    else:
        function = jax.jit({FRESH: _dense, SEARCH: _search, CLOSED: _closed}[group])

        def call() -> Any:
            return function(*given).block_until_ready()

    found = [Variant("jax", "jax", 1, call, around=one_processor)]
    if len(thread_counts()) > 1:
        found.append(Variant("jax", "jax", 2, call))
    return found
