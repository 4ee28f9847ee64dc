"""The law of one variable that a model lacks: its curve, a formula, and what it takes away.

A force (or a shift of the reading) that is any smooth function of a variable is found beside a
fitted model, to first order along its motion: a Gaussian process on evenly spaced knots.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import lsq_linear

from locosweep.diagnosis.estimate.least_squares import evaluate, jacobian_of
from locosweep.diagnosis.estimate.motion import READINGS, Regressor, motion_of, regressors
from locosweep.diagnosis.estimate.slides import corrections
from locosweep.diagnosis.select.law_forms import Found, shortest
from locosweep.diagnosis.select.nonparametric import likeliest
from locosweep.diagnosis.select.shape import KINDS
from locosweep.diagnosis.select.thresholds import FIRST_ORDER, LEAST_GAIN, STEADY
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.motion import Motion
    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

_KNOTS = 41
"""Knots of a law that is drawn: bends between two of them are not seen in a picture."""
_SMOOTH = 1.0 / 8.0
"""Length scale of the process in the variable's range: as wide as between two of nine knots."""
_LEVEL = 3.0
"""Deviation of the law's level, and of its rise over half of the range, in that of its bends: a law
of friction is seldom 0 on average."""
_HOLDS = 0.9
"""Share of the fall of chi2 under the free curve from which a formula says what the law is: a
tenth of the squares is a third of the error."""


@dataclass(frozen=True, eq=False)
class ForceLaw:
    """A law that a model lacks."""

    variable: str
    """Of `KINDS`."""
    at: Floats
    """Values of the variable."""
    size: Floats
    """The law there: a force along x, a resistance where it is odd, an error of the reading."""
    deviation: Floats
    found: Found | None
    """The formula, where one holds."""
    log_factor: float = 0.0
    """Log Bayes factor of the law, on the scale of chi2."""
    fall: float = 0.0
    """Of chi2 under the law, in that of noise."""
    share: float | None = None
    """Of the error on unseen runs that it takes away, where that is known."""


def force_law(
    problem: Problem, fit: Fit, variable: str, acting: ForceLaw | None = None
) -> ForceLaw | None:
    """Return the law of a variable that a model lacks; None where the motion shows none.

    Where the drives of the problem hold a force by place already, `acting`, it is the law that
    they and what the model still lacks make together.
    """
    if (acted := _acting(problem, fit, variable)) is None:
        return None
    at, rows, gap = acted
    noise = noise_level(problem, gap)
    if acting is not None:
        gap = gap + np.interp(at, acting.at, acting.size) @ rows
    log_factor, size, _ = _likeliest_curve(at, rows, gap, noise)
    left = gap - size @ rows
    carried = float(gap @ gap - left @ left) / noise
    # What even this law leaves, as first order is not all of a large gap, counts as error of it.
    noise = max(noise_level(problem, left), float(left @ left) / max(problem.degrees(), 1))
    _, size, covariance = _likeliest_curve(at, rows, gap, noise)
    gram, moments = rows @ rows.T / noise, rows @ gap / noise
    fall = 2.0 * float(moments @ size) - float(size @ gram @ size)
    found = shortest(at, gram, moments)
    if found is not None and found.gain < _HOLDS * fall:
        found = None
    if KINDS[variable].parity == "odd":
        # What resists is a positive friction.
        size = -size
        found = None if found is None else replace(found, sizes=-found.sizes)
    deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return ForceLaw(variable, at, size, deviation, found, log_factor, carried)


def is_monotone(problem: Problem, fit: Fit, variable: str) -> bool:
    """Return whether a law that only rises, or falls, takes as much of a gap as one that bends.

    To `LEAST_GAIN` in chi2, in units of what the law that bends leaves, and to first order. The
    one that only rises may do so in steps: where the cause is such a law, it takes about as much.
    True where the motion shows no law.
    """
    if (acted := _acting(problem, fit, variable)) is None:
        return True
    at, rows, gap = acted
    left = gap - _likeliest_curve(at, rows, gap, noise_level(problem, gap))[1] @ rows
    noise = max(noise_level(problem, left), float(left @ left) / max(problem.degrees(), 1))
    left = gap - _likeliest_curve(at, rows, gap, noise)[1] @ rows
    basis, root = np.linalg.qr(rows.T)
    along = basis.T @ gap
    # A level has either sign, steps have one.
    low = np.array([-np.inf, *np.zeros(at.size - 1)])
    level, rises = np.ones((at.size, 1)), np.tri(at.size)[:, 1:]
    laws = [root @ np.hstack([level, way * rises]) for way in (1.0, -1.0)]
    rests = [2.0 * lsq_linear(law, along, (low, np.inf), method="bvls").cost for law in laws]
    monotone = float(gap @ gap - along @ along) + min(rests)
    loss, fall = (monotone - left @ left) / noise, (gap @ gap - left @ left) / noise
    return bool(loss <= max(LEAST_GAIN, FIRST_ORDER * fall))


def is_steady(problem: Problem, fit: Fit, variable: str) -> bool:
    """Return whether a law stays near its mean, within `STEADY` of it; True where there is none.

    Where it is known well counts for more.
    """
    law = force_law(problem, fit, variable)
    if law is None:
        return True
    weights = 1.0 / np.maximum(law.deviation, 1e-9 * np.abs(law.size).max(initial=1e-300)) ** 2
    mean = float(weights @ law.size / weights.sum())
    spread = float(np.sqrt(weights @ np.square(law.size - mean) / weights.sum()))
    return spread <= STEADY * abs(mean)


def _acting(problem: Problem, fit: Fit, variable: str) -> tuple[Floats, Floats, Floats] | None:
    """Return values of a variable, what a unit law at each changes, and the gap that a fit leaves.

    The changes are those that the fit's own parameters cannot make.
    """
    (fit,) = evaluate(problem, [fit.unfitted()])
    one = _whole_law(variable, motion := motion_of(problem, fit))
    if one is None:
        return None
    low, high = one.values[one.where].min(), one.values[one.where].max()
    at = np.linspace(low, high, _KNOTS)
    terms = one.hats(at)
    rows = np.zeros((len(terms), fit.residual.size))
    corrections(problem, [terms], None if variable in READINGS else motion.slides, rows)
    beside = jacobian_of(problem, fit)[fit.inside]
    if len(beside):
        rows = rows - (rows @ (fitted := np.linalg.qr(beside.T)[0])) @ fitted.T
    return at, rows, fit.residual


def _likeliest_curve(
    at: Floats, rows: Floats, residual: Floats, noise: float
) -> tuple[float, Floats, Floats]:
    """Return the log Bayes factor of a smooth law, as a chi2, its heights and their covariance."""
    gram, moments = rows @ rows.T / noise, rows @ residual / noise
    near = np.exp(-0.5 * np.square((at[:, None] - at) / (_SMOOTH * float(np.ptp(at)))))
    # A level and a slope are as likely as bends of their size.
    line = np.linspace(-1.0, 1.0, at.size)
    near += _LEVEL**2 * (1.0 + np.outer(line, line))
    root = np.linalg.cholesky(near + 1e-9 * np.eye(at.size))
    factor, log_factor = likeliest(root.T @ gram @ root, root.T @ moments)
    root = factor * root
    covariance = root @ np.linalg.inv(np.eye(at.size) + root.T @ gram @ root) @ root.T
    return log_factor, covariance @ moments, covariance


def _whole_law(variable: str, motion: Motion) -> Regressor | None:
    """Return a variable as one law: what has one for either way is that of its size."""
    parts = [one for one in regressors(variable, motion) if one.where.any()]
    if not parts:
        return None
    first = parts[0]
    if KINDS[variable].parity == "odd" and len(parts) > 1:
        factor = sum(one.factor * np.sign(one.values) for one in parts)
        where = np.any([one.where for one in parts], axis=0)
        first = Regressor(np.abs(first.values), where, factor)
    return first if np.ptp(first.values[first.where]) > 0.0 else None
