"""Screening of starts: which of many are followed, and how strong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import Fit, evaluate, jacobian_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

_SCALED = 4.0
"""Factor on a start up to which an effect is taken to act in proportion."""
_INFORMATIVE = 2
"""Runs that starts are compared on: those that hold most of what a fit leaves."""
_AT_ONCE = 200
"""Starts that are evaluated side by side; their residuals are kept meanwhile."""


@dataclass(frozen=True, eq=False)
class Screened:
    """A start, evaluated on some runs; without its residual."""

    fit: Fit
    promised: float
    """Chi2 that it may come to if its change of the residuals is scaled, all else refitted."""
    factor: float = 1.0
    """By how much it would be scaled."""


def informative_runs(problem: Problem, fit: Fit) -> list[int]:
    """Return the fitted runs that hold most of what an evaluated fit leaves, a sample."""
    chosen = problem.fitted
    left = [
        float(np.square(fit.residual[problem.of_run(r, chosen)]).sum() / problem.lengths[r])
        for r in chosen
    ]
    order = np.argsort(-np.array(left), kind="stable")
    return sorted(chosen[i] for i in order[:_INFORMATIVE])


def scan(problem: Problem, fits: Iterable[Fit], runs: Sequence[int]) -> list[Screened]:
    """Evaluate many starts on some runs, without keeping their residuals."""
    return [Screened(fit.without_residual(), fit.chi2) for fit in _evaluated(problem, fits, runs)]


def scan_beside(
    problem: Problem, fits: Iterable[Fit], runs: Sequence[int], beside: Fit
) -> tuple[list[Screened], float]:
    """Evaluate many starts on some runs, and what each promises beside a fit.

    A start extends the model of `beside`: the change that it makes is added to that fit's
    residual. Returns them in the order of `fits`, and chi2 of `beside` on these runs.
    """
    (known,) = evaluate(problem, [beside.unfitted()], runs)
    free = np.nan_to_num(jacobian_of(problem, known, runs))
    basis = np.linalg.qr(free.T)[0]
    found = []
    for fit in _evaluated(problem, fits, runs):
        change = fit.residual - known.residual
        change -= basis @ (basis.T @ change)
        size, along = float(change @ change), -float(change @ known.residual)
        factor = np.clip(along / size, -_SCALED, _SCALED) if size > 0.0 else 0.0
        best = known.chi2 - factor * (2.0 * along - factor * size)
        sure = bool(np.isfinite(best))
        promised = min(fit.chi2, best) if sure else fit.chi2
        found.append(Screened(fit.without_residual(), promised, float(factor) if sure else 1.0))
    return found, known.chi2


def _evaluated(problem: Problem, fits: Iterable[Fit], runs: Sequence[int]) -> Iterable[Fit]:
    fits = list(fits)
    for i in range(0, len(fits), _AT_ONCE):
        yield from evaluate(problem, fits[i : i + _AT_ONCE], runs)


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
    return fit.unfitted(theta)


def below_limit(starts: Sequence[Screened], limit: float, *, every: bool) -> list[Screened]:
    """Pick the starts that may come below a limit; and the best one of `every` model."""
    best: dict[tuple[str, ...], Screened] = {}
    for start in starts:
        names = start.fit.model.names
        if names not in best or start.fit.chi2 < best[names].fit.chi2:
            best[names] = start
    some = set(best.values()) if every else set()
    return [start for start in starts if start.promised <= limit or start in some]


def near_best(fits: Sequence[Fit]) -> list[Fit]:
    """Leave out what lies far behind the best fit of the same model."""
    best: dict[tuple[str, ...], float] = {}
    for fit in fits:
        names = fit.model.names
        best[names] = min(best.get(names, np.inf), fit.chi2)
    return [f for f in fits if f.chi2 < 1.3 * best[f.model.names] + 20.0]


def distinct(starts: Sequence[Screened], count: int) -> list[Screened]:
    """Pick the first starts whose shapes differ, or whose strengths do where there is none."""
    chosen: list[Screened] = []
    for start in starts:
        fit = start.fit
        logs = np.array([f.log for f in fit.model.free], dtype=bool)
        sizes = np.array([0.3 if f.log else 0.003 * f.size for f in fit.model.free])
        k = sizes.size
        if logs.any():
            sizes = np.where(logs, sizes, np.inf)
        if all(np.any(np.abs(fit.theta[:k] - c.fit.theta[:k]) > sizes) for c in chosen):
            chosen.append(start)
        if len(chosen) == count:
            break
    return chosen


def cancelling_pairs(
    alone: Sequence[Fit], changes: Floats, residual: Floats, free: Floats, count: int
) -> list[tuple[int, int, tuple[float, float]]]:
    """Pick starts of two effects whose changes of the residual, scaled, cancel most of it.

    `changes` has a row for each start `alone`; `free` has the derivatives of the residual that
    may be refitted beside. Returns the indices of the two starts and their factors; best first,
    one for each of at most `count` pairs of effects.
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
    first = np.clip(first, -_SCALED, _SCALED)
    # The second one answers to what the first one is held to.
    second = np.clip((along - first * gram) / safe, -_SCALED, _SCALED)
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
    for flat in np.argsort(left, axis=None, kind="stable"):
        i, j = divmod(int(flat), len(alone))
        if len(found) == count or not np.isfinite(left[i, j]):
            break
        pair = frozenset({names[i], names[j]})
        found.setdefault(pair, (i, j, (float(first[i, j]), float(second[i, j]))))
    return list(found.values())
