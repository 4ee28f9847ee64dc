"""Models beside a rest that nobody explains: how likely they are, how far off on unseen runs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import chi2_of, evaluate, fit_all
from locosweep.diagnosis.estimate.rest import Rest, RestForce
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.descent import apart
from locosweep.diagnosis.select.unseen_errors import seen_error, unseen_squares
from locosweep.diagnosis.select.whiteness import inflation

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Search

    Floats = NDArray[np.float64]

STEPS, TOLERANCE = 15, 1.0
"""Steps of a fit, at most, and the fall of chi2 that ends it: a twelfth of what tells effects
apart."""
_ROUNDS = 3
"""Times that the rest is found beside the likeliest fit, at most: few need more than one."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A set of effects beside the rest."""

    fit: Fit
    deviance: float
    """Of the set with its own likeliest rest, a price on every parameter included."""
    squares: Floats
    """Mean squared errors of x in blocks of runs that it was not fitted to."""
    plainly: bool = False
    """True if `fit` was made without the rest: it predicts unseen runs better then."""

    @property
    def error(self) -> float:
        """Root mean square of its errors on unseen runs, in the unit of x."""
        return float(np.sqrt(np.mean(self.squares)))


@dataclass(frozen=True, eq=False)
class Compared:
    """Models beside the rest that is likeliest beside the best of them."""

    rest: Rest
    problem: Problem
    base: Candidate
    others: list[Candidate]
    inflation: float
    """Factor by which differences in deviance count for less, as what even the rest leaves is
    correlated."""
    of_run: NDArray[np.intp]
    """Run that each block of `squares` is of."""


def compare_beside_rest(
    search: Search, force: RestForce, base: Fit, fits: Sequence[Fit], error: float | None = None
) -> Compared:
    """Fit models plainly and beside the rest that is likeliest beside the best of them.

    Of the two fits of a model the one that predicts unseen runs better says how well it does.
    `error` is that of the nominal model on unseen runs, None where `base` is that model.
    """
    plain = _plainly(search.problem, base, fits, error)
    now = [fit.unfitted() for fit in plain]
    price = np.array([limits.PENALTY * len(fit.model.free) for fit in now])
    rests = force.beside(now)
    for _ in range(_ROUNDS):
        rest = rests[int(np.argmin(price + [one.deviance for one in rests]))]
        problem = force.beside_one(rest)
        ends = fit_all(problem, [fit.unfitted() for fit in now], steps=STEPS, tolerance=TOLERANCE)
        now, rests = ends, force.beside(ends)
        new = rests[int(np.argmin(price + [one.deviance for one in rests]))]
        if (new.size, new.time) == (rest.size, rest.time):
            break
    found = []
    plain_rows, of_run = unseen_squares(search, search.problem, plain)
    rows, _ = unseen_squares(search, problem, now)
    for i, (one, cost) in enumerate(zip(rests, price.tolist(), strict=True)):
        plainly = float(plain_rows[i].mean()) < float(rows[i].mean())
        fit, squares = (plain[i], plain_rows[i]) if plainly else (now[i], rows[i])
        found.append(Candidate(fit, one.deviance + cost, squares, plainly))
    likeliest = min(range(len(found)), key=lambda i: found[i].deviance)
    (left,) = evaluate(problem, [now[likeliest].unfitted()])
    return Compared(rest, problem, found[0], found[1:], inflation(problem, left.residual), of_run)


def _plainly(problem: Problem, base: Fit, fits: Sequence[Fit], error: float | None) -> list[Fit]:
    """Fit a model, and those of others that lower its error of x by a share worth a name.

    The error is that on the fitted runs: what lowers it by less would not lower that on other
    runs by more. The share is one of `error`, or of what `base` leaves.
    """
    (own,) = fit_all(problem, [base.unfitted()], steps=STEPS, tolerance=TOLERANCE)
    (before,) = seen_error(problem, [own])
    most = max(before - limits.LEAST_SHARE * (before if error is None else error), 0.0)
    # Where more than noise is left, chi2 goes about with the square of the error.
    limit = own.chi2 * (most / before) ** 2 if before > 0.0 else np.inf
    starts = [replace(fit.unfitted(), limit=limit) for fit in fits]
    fitted = fit_all(problem, starts, steps=STEPS, tolerance=TOLERANCE)
    able = [replace(fit, limit=np.inf) for fit in fitted if np.isfinite(fit.chi2)]
    able = [fit for fit, left in zip(able, seen_error(problem, able), strict=True) if left <= most]
    return [own, *apart(sorted(able, key=chi2_of))]
