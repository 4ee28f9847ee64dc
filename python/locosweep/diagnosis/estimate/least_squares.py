"""Least-squares fits of many models at once, each by Levenberg and Marquardt."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.problem import Point

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.effects.catalogue import Free
    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

_TRIALS = (0.05, 1.0, 30.0)
"""Factors on the damping that each step tries side by side."""
_DOUBT = 3.0
"""Factor on the fall of chi2 that derivatives promise, up to which a fit may still fall."""
_COARSE, _NEAR = 0.01, 200.0
"""Least gain of a step over a fit's distance in chi2 from the best one, beyond `_NEAR`."""


@dataclass(frozen=True)
class Nuisances:
    """Values that every model, the nominal one included, may shift.

    `moving` lists runs whose start speed is free; `spread` gives the standard
    deviations of mass, Coulomb level, gain (relative) and clock (s), 0 where exact.
    """

    moving: tuple[int, ...] = ()
    spread: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    speed: float = 1.0
    """A large start speed, m/s."""
    start_offsets: tuple[tuple[int, float], ...] = ()
    """Runs whose start position is shifted, with its deviation."""

    @property
    def uncertain(self) -> tuple[int, ...]:
        """Indices of the values that are uncertain."""
        return tuple(i for i, s in enumerate(self.spread) if s > 0.0)


@dataclass(frozen=True)
class Model:
    """A set of effects with its free parameters."""

    names: tuple[str, ...]
    free: tuple[Free, ...]


@dataclass(frozen=True, eq=False)
class Fit:
    """A model with values: parameters first, then uncertain nominal ones, then start speeds."""

    model: Model
    nuisances: Nuisances
    theta: Floats
    chi2: float = np.inf
    covariance: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    residual: Floats = field(default_factory=lambda: np.zeros(0))
    damping: float = 1e-2
    limit: float = np.inf
    """Chi2 above which the fit is of no interest, once derivatives promise no better."""

    @property
    def parameters(self) -> Floats:
        """Values of the effects' parameters, in their units."""
        pairs = zip(self.theta, self.model.free, strict=False)
        return np.array([np.exp(u) if f.log else u for u, f in pairs])

    @property
    def stds(self) -> Floats:
        """Standard deviations of the parameters, in their units."""
        k = len(self.model.free)
        spread = np.sqrt(np.maximum(np.diag(self.covariance)[:k], 0.0))
        logs = np.array([f.log for f in self.model.free], dtype=bool)
        return np.where(logs, spread * self.parameters, spread) if k else spread

    @property
    def nuisance(self) -> Floats:
        """Entries of theta behind the parameters: uncertain nominal values, speeds, positions."""
        return self.theta[len(self.model.free) :]

    def unfitted(self, theta: Floats | None = None) -> Fit:
        """Return a fit of the same model that is still to be evaluated."""
        return Fit(self.model, self.nuisances, self.theta if theta is None else theta)

    def without_residual(self) -> Fit:
        """Return the fit without its residual, which takes most of the memory."""
        return replace(self, residual=np.zeros(0))

    def named(self) -> dict[str, dict[str, float]]:
        """Return the parameters by effect and name."""
        found: dict[str, dict[str, float]] = {name: {} for name in self.model.names}
        for f, value in zip(self.model.free, self.parameters, strict=True):
            found[f.effect][f.name] = float(value)
        return found


def bounds_of(fit: Fit) -> tuple[Floats, Floats, Floats]:
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


def point_of(problem: Problem, fit: Fit, theta: Floats | None = None) -> Point:
    """Return the model that a fit describes, at its own values if no others are given."""
    theta = fit.theta if theta is None else theta
    base = at_rest(problem, fit, theta)
    k = len(fit.model.free) + len(fit.nuisances.uncertain)
    for r, u in zip(fit.nuisances.moving, theta[k:], strict=False):
        base.speeds[r] = problem.starts.speed[r] + u
    k += len(fit.nuisances.moving)
    for (r, _), u in zip(fit.nuisances.start_offsets, theta[k:], strict=True):
        base.start_offsets[r] = u
    return base


def at_rest(problem: Problem, fit: Fit, theta: Floats | None = None) -> Point:
    """Return the same with starts of the runs as they were measured."""
    theta = fit.theta if theta is None else theta
    base = problem.plain()
    k = len(fit.model.free)
    for f, u in zip(fit.model.free, theta[:k], strict=True):
        base.values[problem.parameter_index(f.effect, f.name)] = np.exp(u) if f.log else u
    for i, u in zip(fit.nuisances.uncertain, theta[k:], strict=False):
        base.factors[i] = u if i == 3 else 1.0 + u
    return replace(base, names=fit.model.names)


def priors_of(fit: Fit, theta: Floats) -> Floats:
    """Residuals of the uncertain nominal values and start positions."""
    k = len(fit.model.free)
    spread = np.array([fit.nuisances.spread[i] for i in fit.nuisances.uncertain])
    around = np.array([s for _, s in fit.nuisances.start_offsets])
    last = theta.size - around.size
    return np.concatenate([theta[k : k + spread.size] / spread, theta[last:] / around])


def start_fits(
    nuisances: Nuisances, model: Model, rows: Floats, nuisance: Floats | None = None
) -> list[Fit]:
    """Return unfitted fits, one a row of parameter values; nuisance values are 0 if not given."""
    if nuisance is None:
        count = len(nuisances.uncertain) + len(nuisances.moving) + len(nuisances.start_offsets)
        nuisance = np.zeros(count)
    fits = []
    for row in np.atleast_2d(rows):
        logs = np.array([f.log for f in model.free], dtype=bool)
        theta = np.where(logs, np.log(np.where(logs, np.maximum(row, 1e-300), 1.0)), row)
        fits.append(Fit(model, nuisances, np.concatenate([theta, nuisance])))
    return fits


def evaluate(problem: Problem, fits: Sequence[Fit], runs: Sequence[int] | None = None) -> list[Fit]:
    """Return fits with chi2 and residual at their values, of `runs` or of those that are fitted."""
    if not fits:
        return []
    found = problem.residuals([point_of(problem, fit) for fit in fits], runs)
    return [_at(fit, fit.theta, e) for fit, e in zip(fits, found, strict=True)]


def _at(fit: Fit, theta: Floats, e: Floats) -> Fit:
    """Return a fit at some values, of which the residuals are known."""
    full = np.concatenate([e, priors_of(fit, theta)])
    chi2 = float(full @ full)
    return replace(fit, theta=theta, residual=full, chi2=chi2 if np.isfinite(chi2) else np.inf)


def fit_all(
    problem: Problem,
    fits: Sequence[Fit],
    *,
    runs: Sequence[int] | None = None,
    steps: int = 12,
    tolerance: float = 0.02,
) -> list[Fit]:
    """Return fits improved until their chi2 falls by less than `tolerance`, or `steps` are made.

    Of those far behind the best one, fewer digits are asked for; and none where `limit`
    is out of reach. `runs` count, or those that are fitted.
    """
    found = list(fits)
    bare = [i for i, fit in enumerate(found) if not fit.residual.size]
    for i, fit in zip(bare, evaluate(problem, [found[i] for i in bare], runs), strict=True):
        found[i] = fit
    todo = [i for i, fit in enumerate(found) if fit.theta.size and np.isfinite(fit.chi2)]
    for _ in range(steps):
        if not todo:
            break
        least = min(fit.chi2 for fit in found)
        jacobians = _jacobians(problem, [found[i] for i in todo], runs)
        trials: list[tuple[int, float, Floats]] = []
        for i, jacobian in zip(todo, jacobians, strict=True):
            found[i], proposals, promise = _proposals(found[i], jacobian)
            if not found[i].chi2 - _DOUBT * promise > found[i].limit:
                trials += [(i, damping, theta) for damping, theta in proposals]
        todo = list(dict.fromkeys(i for i, _, _ in trials))
        if not todo:
            break
        points = [point_of(problem, found[i], theta) for i, _, theta in trials]
        best: dict[int, Fit] = {}
        for (i, damping, theta), e in zip(trials, problem.residuals(points, runs), strict=True):
            tried = replace(_at(found[i], theta, e), damping=max(damping, 1e-9))
            if np.isfinite(tried.chi2) and (i not in best or tried.chi2 < best[i].chi2):
                best[i] = tried
        todo = [i for i in todo if i in best]
        for i in list(todo):
            old, new = found[i], best[i]
            if new.chi2 < old.chi2:
                behind = _COARSE * max(new.chi2 - least - _NEAR, 0.0)
                done = old.chi2 - new.chi2 < tolerance + 1e-7 * new.chi2 + behind
                found[i] = new
            else:
                found[i] = replace(old, damping=old.damping * 300.0)
                done = found[i].damping > 1e7
            if done:
                todo.remove(i)
    return found


def _steps(fit: Fit, size: Floats) -> Floats:
    """Finite differences: a fraction of a standard deviation where that is known."""
    known = np.diag(fit.covariance) if fit.covariance.size else np.full(size.size, np.nan)
    spread = np.sqrt(np.where(known > 0.0, known, np.nan))
    step = np.where(np.isfinite(spread), 0.3 * spread, 1e-3 * size)
    return np.clip(step, 1e-7 * size, 3e-3 * size)


def _local(fit: Fit) -> list[int | None]:
    """Say which run each entry of theta is about, None for all."""
    everywhere: list[int | None] = [None] * (len(fit.model.free) + len(fit.nuisances.uncertain))
    return [*everywhere, *fit.nuisances.moving, *(r for r, _ in fit.nuisances.start_offsets)]


def _jacobians(problem: Problem, fits: Sequence[Fit], runs: Sequence[int] | None) -> list[Floats]:
    """Differentiate the residuals, a row a parameter, by one-sided differences."""
    groups: dict[int | None, list[tuple[int, int, float, Floats]]] = {}
    for i, fit in enumerate(fits):
        _, high, size = bounds_of(fit)
        step = _steps(fit, size)
        step = np.where(fit.theta + step > high, -step, step)
        for j, run in enumerate(_local(fit)):
            theta = fit.theta.copy()
            theta[j] += step[j]
            groups.setdefault(run, []).append((i, j, step[j], theta))
    rows = [np.zeros((fit.theta.size, fit.residual.size)) for fit in fits]
    chosen = problem.fitted if runs is None else list(runs)
    for run, entries in groups.items():
        points = [point_of(problem, fits[i], theta) for i, _, _, theta in entries]
        if run is not None and run not in chosen:
            continue
        found = problem.residuals(points, runs if run is None else [run])
        where = slice(None) if run is None else problem.of_run(run, chosen)
        for (i, j, width, theta), e in zip(entries, found, strict=True):
            fit = fits[i]
            prior = priors_of(fit, theta)
            body = fit.residual.size - prior.size
            rows[i][j, :body][where] = (e - fit.residual[:body][where]) / width
            rows[i][j, body:] = (prior - fit.residual[body:]) / width
    return rows


def jacobian_of(problem: Problem, fit: Fit, runs: Sequence[int] | None = None) -> Floats:
    """Return the derivatives of a fit's residuals, a row a parameter."""
    return _jacobians(problem, [fit], runs)[0]


def _proposals(fit: Fit, jacobian: Floats) -> tuple[Fit, list[tuple[float, Floats]], float]:
    """Return the fit with its covariance, steps with dampings, and the expected fall of chi2."""
    low, high, size = bounds_of(fit)
    jacobian = np.nan_to_num(jacobian, nan=0.0, posinf=0.0, neginf=0.0)
    normal = jacobian @ jacobian.T
    gradient = jacobian @ fit.residual
    scale = np.diag(normal).copy()
    # A parameter that moves nothing by as much as it may is left where it is.
    floor = 1e-6 / size**2
    scale = np.maximum(scale, floor)
    held = ((fit.theta <= low) & (gradient > 0.0)) | ((fit.theta >= high) & (gradient < 0.0))
    fit = replace(fit, covariance=_inverse(normal, floor))
    found = []
    for factor in _TRIALS:
        damping = fit.damping * factor
        matrix = normal + np.diag(damping * scale + floor)
        free = ~held
        move = np.zeros(fit.theta.size)
        if free.any():
            move[free] = -np.linalg.lstsq(matrix[np.ix_(free, free)], gradient[free], rcond=None)[0]
        # No step beyond what counts as large, a few times over.
        reach = np.max(np.abs(move) / (3.0 * size), initial=1.0)
        found.append((damping, np.clip(fit.theta + move / reach, low, high)))
    promise = float(gradient @ fit.covariance @ gradient)
    return fit, found, promise if np.isfinite(promise) else np.inf


def _inverse(normal: Floats, floor: Floats) -> Floats:
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), floor))
    unit = normal * scale[:, None] * scale[None, :] + np.eye(scale.size) * 1e-12
    try:
        return np.linalg.inv(unit) * scale[:, None] * scale[None, :]
    except np.linalg.LinAlgError:
        return np.diag(scale**2)


def chi2_of(fit: Fit) -> float:
    """Order fits by what they leave."""
    return fit.chi2
