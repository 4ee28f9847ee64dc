"""Which starts of a search are followed, and how strong."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import Fit

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

__all__ = ["SCALED", "apart", "best_pairs", "hopeful", "promising", "scaled"]

SCALED = 4.0
"""How many times larger than its start an effect is taken to act in proportion."""


def scaled(fit: Fit, scale: float) -> Fit:
    """Return a start whose last effect is stronger by a factor, where it has a strength."""
    theta = fit.theta.copy()
    for i, free in enumerate(fit.model.free):
        if free.effect != fit.model.names[-1] or np.isnan(free.off) or scale == 0.0:
            continue
        if not free.log:
            moved = free.off + scale * (theta[i] - free.off)
            theta[i] = np.clip(moved, free.low, free.high)
        elif scale > 0.0:
            theta[i] = np.clip(theta[i] + np.log(scale), np.log(free.low), np.log(free.high))
    return Fit(fit.model, fit.nuisances, theta)


def hopeful(
    fits: Sequence[Fit], reach: dict[int, float], limit: float, *, every: bool
) -> list[Fit]:
    """Pick the starts that may come below a limit; and the best one of `every` model."""
    best: dict[tuple[str, ...], Fit] = {}
    for fit in fits:
        names = fit.model.names
        if names not in best or fit.chi2 < best[names].chi2:
            best[names] = fit
    some = {id(fit) for fit in best.values()} if every else set()
    return [f for f in fits if reach[id(f)] <= limit or id(f) in some]


def promising(fits: Sequence[Fit]) -> list[Fit]:
    """Leave out what lies far behind the best fit of the same model."""
    best: dict[tuple[str, ...], float] = {}
    for fit in fits:
        names = fit.model.names
        best[names] = min(best.get(names, np.inf), fit.chi2)
    return [f for f in fits if f.chi2 < 1.3 * best[f.model.names] + 20.0]


def apart(fits: Sequence[Fit], count: int) -> list[Fit]:
    """Pick the best fits whose shapes differ, or whose strengths do where there is none."""
    chosen: list[Fit] = []
    for fit in fits:
        logs = np.array([f.log for f in fit.model.free], dtype=bool)
        sizes = np.array([0.3 if f.log else 0.003 * f.size for f in fit.model.free])
        k = sizes.size
        if logs.any():
            sizes = np.where(logs, sizes, np.inf)
        if all(np.any(np.abs(fit.theta[:k] - c.theta[:k]) > sizes) for c in chosen):
            chosen.append(fit)
        if len(chosen) == count:
            break
    return chosen


def best_pairs(
    alone: Sequence[Fit],
    changes: NDArray[np.float64],
    residual: NDArray[np.float64],
    free: NDArray[np.float64],
    count: int,
) -> list[tuple[int, int, tuple[float, float]]]:
    """Pick starts of two effects whose changes of the residual, scaled, cancel most of it.

    Parameters
    ----------
    alone : sequence of Fit
        Starts of single effects.
    changes : ndarray
        What each changes of the residual, a row each.
    residual : ndarray
        What is to be cancelled.
    free : ndarray
        Derivatives of the residual that may be refitted beside, a row each.
    count : int
        Pairs of effects, at most.

    Returns
    -------
    list of tuple
        Places of the two starts and their factors; best first, one for each pair of effects.
    """
    if len(free):
        basis = np.linalg.qr(free.T)[0]
        changes = changes - (changes @ basis) @ basis.T
    gram, along = changes @ changes.T, -(changes @ residual)
    own = np.diag(gram)
    seen = own > 1e-12 * max(float(own.max(initial=0.0)), 1e-300)
    safe = np.where(seen, own, 1.0)
    determinant = safe[:, None] * safe - gram**2
    apart_enough = determinant > 1e-4 * safe[:, None] * safe
    first = (along[:, None] * safe - along * gram) / np.where(apart_enough, determinant, 1.0)
    first = np.clip(first, -SCALED, SCALED)
    # The second one answers to what the first one is held to.
    second = np.clip((along - first * gram) / safe, -SCALED, SCALED)
    left = (
        -2.0 * (first * along[:, None] + second * along)
        + first**2 * safe[:, None]
        + second**2 * safe
        + 2.0 * first * second * gram
    )
    names = np.array([fit.model.names[0] for fit in alone], dtype=object)
    left = np.where(apart_enough & seen[:, None] & seen, left, np.inf)
    left[names[:, None] == names] = np.inf
    found: dict[frozenset[str], tuple[int, int, tuple[float, float]]] = {}
    for place in np.argsort(left, axis=None, kind="stable"):
        i, j = divmod(int(place), len(alone))
        if len(found) == count or not np.isfinite(left[i, j]):
            break
        pair = frozenset({names[i], names[j]})
        found.setdefault(pair, (i, j, (float(first[i, j]), float(second[i, j]))))
    return list(found.values())
