"""Least-squares fits of many models at once; the core makes the steps."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.problem import Point

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.effects.catalogue import Free
    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

_AT_A_BOUND = 1e-9
"""Share of a range within which a value stands at its end: steps are cut off there to rounding."""

FINE = 0.02
"""Fall of chi2 by a step that ends a fit, unless a coarser one is given: a fiftieth of what noise
alone makes. Not derived."""


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
    damping: float = 1e-2
    limit: float = np.inf
    """Chi2 above which the fit is of no interest, once derivatives promise no better."""
    seen: tuple[Problem, tuple[int, ...]] | None = field(default=None, repr=False)
    """Problem and runs whose chi2 it is; None where it is still to be evaluated."""

    @cached_property
    def residual(self) -> Floats:
        """Whitened residuals of these runs, and last those of what is known before.

        Worked out where they are asked for, if the evaluation did not keep them.
        """
        if self.seen is None:
            return np.zeros(0)
        problem, runs = self.seen
        ((_, e),) = problem.misfit.evaluate([self], runs, problem.threads, keep=True)
        return np.zeros(0) if e is None else e

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
    def bounds(self) -> tuple[Floats, Floats]:
        """Least and largest values of theta; none for what stands behind the parameters."""
        low, high = np.full((2, self.theta.size), np.inf)
        for i, f in enumerate(self.model.free):
            low[i], high[i] = np.log([f.low, f.high]) if f.log else (f.low, f.high)
        low[len(self.model.free) :] = -np.inf
        return low, high

    @property
    def inside(self) -> NDArray[np.bool_]:
        """True for the values of theta that no bound holds: those that a small step may change."""
        low, high = self.bounds
        slack = _AT_A_BOUND * np.where(np.isfinite(high), high - low, 0.0)
        return (self.theta > low + slack) & (self.theta < high - slack)

    @property
    def nuisance(self) -> Floats:
        """Entries of theta behind the parameters: uncertain nominal values, speeds, positions."""
        return self.theta[len(self.model.free) :]

    def unfitted(self, theta: Floats | None = None) -> Fit:
        """Return a fit of the same model that is still to be evaluated."""
        return Fit(self.model, self.nuisances, self.theta if theta is None else theta)

    def without_residual(self) -> Fit:
        """Return the fit as one that is still to be evaluated, on whatever runs; chi2 stays."""
        return replace(self, seen=None)

    def named(self) -> dict[str, dict[str, float]]:
        """Return the parameters by effect and name."""
        found: dict[str, dict[str, float]] = {name: {} for name in self.model.names}
        for f, value in zip(self.model.free, self.parameters, strict=True):
            found[f.effect][f.name] = float(value)
        return found


def point_of(problem: Problem, fit: Fit, theta: Floats | None = None) -> Point:
    """Return the model that a fit describes, at its own values if no others are given."""
    theta = fit.theta if theta is None else theta
    base = problem.plain()
    k = len(fit.model.free)
    for f, u in zip(fit.model.free, theta[:k], strict=True):
        base.values[problem.parameter_index(f.effect, f.name)] = np.exp(u) if f.log else u
    for i, u in zip(fit.nuisances.uncertain, theta[k:], strict=False):
        base.factors[i] = u if i == 3 else 1.0 + u
    k += len(fit.nuisances.uncertain)
    for r, u in zip(fit.nuisances.moving, theta[k:], strict=False):
        base.speeds[r] = problem.starts.speed[r] + u
    k += len(fit.nuisances.moving)
    for (r, _), u in zip(fit.nuisances.start_offsets, theta[k:], strict=True):
        base.start_offsets[r] = u
    return replace(base, names=fit.model.names)


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


def evaluate(
    problem: Problem,
    fits: Sequence[Fit],
    runs: Sequence[int] | None = None,
    *,
    residuals: bool = True,
) -> list[Fit]:
    """Return fits with chi2 at their values, of `runs` or of those that are fitted.

    Without `residuals`, they are worked out one by one if they are asked for.
    """
    chosen = problem.chosen(runs)
    problem.meter.count([fit.model.names for fit in fits], problem.samples_of(chosen))
    found = problem.misfit.evaluate(list(fits), chosen, problem.threads, keep=residuals)
    evaluated = []
    for fit, (chi2, e) in zip(fits, found, strict=True):
        one = replace(fit, chi2=chi2, seen=(problem, chosen))
        if e is not None:
            one.__dict__["residual"] = e
        evaluated.append(one)
    return evaluated


def fit_all(
    problem: Problem,
    fits: Sequence[Fit],
    *,
    runs: Sequence[int] | None = None,
    steps: int = 12,
    tolerance: float = FINE,
    least: float | None = np.inf,
) -> list[Fit]:
    """Return fits improved until their chi2 falls by less than `tolerance`, or `steps` are made.

    One that would not catch up with the best one, nor with the chi2 of `least` that others came
    to, is left, unless `least` is None: then each stands alone. So is one whose `limit` is out of
    reach. `runs` count, or those that are fitted.
    """
    chosen = problem.chosen(runs)
    known = [fit.seen == (problem, chosen) for fit in fits]
    found, samples = problem.misfit.fit(
        list(fits), known, chosen, steps, tolerance, least, problem.threads
    )
    names = [fit.model.names for fit in fits]
    problem.meter.count(names, samples // max(len(names), 1))
    return [
        replace(
            fit,
            theta=theta,
            chi2=chi2,
            covariance=covariance,
            damping=damping,
            seen=(problem, chosen),
        )
        for fit, (theta, chi2, covariance, damping) in zip(fits, found, strict=True)
    ]


def jacobian_of(problem: Problem, fit: Fit, runs: Sequence[int] | None = None) -> Floats:
    """Return the derivatives of a fit's residuals, a row a parameter."""
    chosen = problem.chosen(runs)
    problem.meter.count([fit.model.names] * fit.theta.size, problem.samples_of(chosen))
    rows: Floats = problem.misfit.jacobian(fit, chosen, problem.threads)
    return rows


def chi2_of(fit: Fit) -> float:
    """Order fits by what they leave."""
    return fit.chi2
