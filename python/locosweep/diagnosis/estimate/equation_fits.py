"""Fits of models to the equation error: many at once, each step two calls of the core."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import at_rest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.equation_error import EquationError
    from locosweep.diagnosis.estimate.least_squares import Fit

    Floats = NDArray[np.float64]

_STEPS = 8
"""Steps of a fit, at most: what it finds is a start for replays, whose steps have all digits."""
_WIDTH = 1e-4
"""Width of a finite difference in sizes of the parameter: no event makes it rough here."""
_BENT, _WIDEST = 0.02, 1.0
"""Deviation of a fit, in sizes of its parameters, from which its valley may bend, and the most
that is taken for one."""
_DAMPINGS = (1e-3, 0.3)
"""Dampings that every step tries side by side."""


def displaced(along: EquationError, fits: Sequence[Fit]) -> Floats:
    """Return the displacements of fits, a row a fit."""
    return along.displacements([at_rest(along.problem, fit) for fit in fits])


def evaluated(along: EquationError, fits: Sequence[Fit]) -> tuple[list[Fit], Floats]:
    """Return fits with the chi2 of their equation error, and that error, a row a fit."""
    e = along.measured - displaced(along, fits)
    squares = np.einsum("ij,ij->i", e, e)
    found = []
    for fit, square in zip(fits, squares.tolist(), strict=True):
        chi2 = square + float(np.square(_priors(fit, fit.theta)).sum())
        found.append(replace(fit, chi2=chi2 if np.isfinite(chi2) else np.inf))
    return found, e


def refined(along: EquationError, fits: Sequence[Fit], steps: int = _STEPS) -> list[Fit]:
    """Return fits whose parameters leave the least equation error near their starts."""
    found, e = evaluated(along, fits)
    todo = [i for i, fit in enumerate(found) if _global(fit)]
    for _ in range(steps):
        if not todo:
            break
        trials = _trials(along, [found[i] for i in todo], e[todo])
        tried, left = evaluated(along, trials)
        still = []
        for n, i in enumerate(todo):
            own = range(n * len(_DAMPINGS), (n + 1) * len(_DAMPINGS))
            best = min(own, key=lambda k: tried[k].chi2)
            gain = found[i].chi2 - tried[best].chi2
            if gain > 0.0:
                found[i], e[i] = tried[best], left[best]
            if gain > 1e-3 * found[i].chi2 + 0.1:
                still.append(i)
        todo = still
    return found


def _trials(along: EquationError, fits: Sequence[Fit], e: Floats) -> list[Fit]:
    """Return the steps of some fits under each damping, fit by fit."""
    moved = []
    widths = []
    for fit in fits:
        _, high, size = _bounds(fit)
        step = np.where(fit.theta + _WIDTH * size > high, -_WIDTH, _WIDTH) * size
        widths.append(step)
        for j in range(_global(fit)):
            theta = fit.theta.copy()
            theta[j] += step[j]
            moved.append(fit.unfitted(theta))
    there = evaluated(along, moved)[1]
    found, at = [], 0
    for fit, step, error in zip(fits, widths, e, strict=True):
        count = _global(fit)
        jacobian = (there[at : at + count] - error) / step[:count, None]
        at += count
        found += _damped(fit, jacobian, error)
    return found


def jacobian_along(along: EquationError, fit: Fit) -> Floats:
    """Return the derivatives of a fit's displacements, a row for each entry of all runs."""
    _, high, size = _bounds(fit)
    step = np.where(fit.theta + _WIDTH * size > high, -_WIDTH, _WIDTH) * size
    moved = []
    for j in range(_global(fit)):
        theta = fit.theta.copy()
        theta[j] += step[j]
        moved.append(fit.unfitted(theta))
    here, *there = displaced(along, [fit, *moved])
    return np.array([(row - here) / step[j] for j, row in enumerate(there)]).reshape(-1, here.size)


def uncertainties(along: EquationError, fit: Fit) -> Floats | None:
    """Return the deviation along which a fit is known least; None where that is a small change.

    It changes the entries of theta that are not about the start of a run.
    """
    jacobian = jacobian_along(along, fit)
    if not len(fit.model.free):
        return None
    size = _bounds(fit)[2][: len(jacobian)]
    scaled = np.nan_to_num(jacobian) * size[:, None]
    values, vectors = np.linalg.eigh(scaled @ scaled.T)
    deviation = min(1.0 / np.sqrt(max(float(values[0]), 1e-12)), _WIDEST)
    return None if deviation < _BENT else size * vectors[:, 0] * deviation


def _global(fit: Fit) -> int:
    """Return how many entries of theta are not about the start of a run."""
    return len(fit.model.free) + len(fit.nuisances.uncertain)


def _damped(fit: Fit, jacobian: Floats, e: Floats) -> list[Fit]:
    low, high, size = _bounds(fit)
    count = len(jacobian)
    jacobian = np.nan_to_num(jacobian, nan=0.0, posinf=0.0, neginf=0.0)
    normal, gradient = jacobian @ jacobian.T, jacobian @ np.nan_to_num(e)
    k = len(fit.model.free)
    spread = np.array([fit.nuisances.spread[i] for i in fit.nuisances.uncertain])
    normal[range(k, count), range(k, count)] += spread**-2.0
    gradient[k:] += fit.theta[k:count] / spread**2
    diagonal = np.maximum(np.diag(normal), 1e-12 / size[:count] ** 2)
    found = []
    for damping in _DAMPINGS:
        step = np.linalg.lstsq(normal + np.diag(damping * diagonal), -gradient, rcond=None)[0]
        step /= max(1.0, float(np.max(np.abs(step) / (3.0 * size[:count]), initial=0.0)))
        theta = fit.theta.copy()
        theta[:count] = np.clip(theta[:count] + step, low[:count], high[:count])
        found.append(fit.unfitted(theta))
    return found


def _bounds(fit: Fit) -> tuple[Floats, Floats, Floats]:
    """Low, high and size of every entry of theta."""
    nuisances = fit.nuisances
    rows = [
        (np.log(f.low), np.log(f.high), f.size) if f.log else (f.low, f.high, f.size)
        for f in fit.model.free
    ]
    rows += [(-8 * s, 8 * s, s) for s in (nuisances.spread[i] for i in nuisances.uncertain)]
    rows += [(-np.inf, np.inf, nuisances.speed)] * len(nuisances.moving)
    rows += [(-8 * s, 8 * s, s) for _, s in nuisances.start_offsets]
    low, high, size = np.array(rows, dtype=float).reshape(-1, 3).T
    return low, high, size


def _priors(fit: Fit, theta: Floats) -> Floats:
    """Residuals of the uncertain nominal values and start positions."""
    k = len(fit.model.free)
    spread = np.array([fit.nuisances.spread[i] for i in fit.nuisances.uncertain])
    around = np.array([s for _, s in fit.nuisances.start_offsets])
    last = theta.size - around.size
    return np.concatenate([theta[k : k + spread.size] / spread, theta[last:] / around])
