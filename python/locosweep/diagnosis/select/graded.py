"""The graded verdict: causes that unseen runs confirm, where no set of effects leaves but noise.

Every model leaves the same rest (`estimate/rest.py`). A cause has to predict runs that it was not
fitted to better than the model without it; the likeliest of those beside the rest is named. Errors
of free runs are mostly the rest's, so that alone they name what bends to it. Where they are not
small beside the motion, the rest is not known to first order and cannot say what is likely: then
prediction of unseen runs decides, and what predicts as well as the best is one class.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import evaluate, fit_all, point_of, start_fits
from locosweep.diagnosis.estimate.rest import Rest, RestForce
from locosweep.diagnosis.estimate.spread_between_runs import covariance_between_runs
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.beside_rest import STEPS, TOLERANCE, Candidate, compare_beside_rest
from locosweep.diagnosis.select.extension import extend
from locosweep.diagnosis.select.next_cause import Cause, next_cause, one_for_two, weights_of
from locosweep.diagnosis.select.search import Collection, Found
from locosweep.diagnosis.select.unlisted_beside import unlisted_beside

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Search


@dataclass(frozen=True, eq=False)
class Graded:
    """Causes in the order of what they take away, and what is left."""

    rest: Rest
    """The likeliest rest beside the last model."""
    problem: Problem
    """The runs, with this rest."""
    causes: tuple[Cause, ...]
    none: Candidate
    ranked: tuple[Candidate, ...]
    """Single effects, the one with the largest weight first."""
    weights: tuple[float, ...] = ()
    """Weights of these, together 1."""
    unlisted: str = ""
    """Variable of a force that no effect stands for and that does better than any, if any."""
    of_run: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    """Run that each block of errors is of."""

    @property
    def last(self) -> Candidate:
        """The model with all causes."""
        return self.causes[-1].chosen if self.causes else self.none


def graded(search: Search, known: Collection, most: int) -> Graded:
    """Return the causes, at most `most`, that unseen runs confirm beside a rest.

    The fits of `known` may be those of other runs: they are starts.
    """
    search.progress("causes beside what nobody explains")
    force = RestForce(search.problem)
    base, unlisted = search.none, ""
    causes: list[Cause] = []
    now = compare_beside_rest(search, force, base, _more(search, known, base))
    none = now.base
    weights = weights_of(now, none)
    first = np.argsort(-weights, kind="stable")
    ranked = tuple(now.others[i] for i in first)
    # Noise is no more than what some model leaves.
    floor = min(search.problem.noise["x"].sd, *(one.error for one in (none, *now.others)))
    if none.error < limits.LEAST_GRADED * floor:
        # The true cause of a gap so small leaves but noise: it would be `explained`.
        most = 0
    while len(causes) < most:
        cause = next_cause(now, base, none)
        unlisted = unlisted_beside(now, cause) if cause else ""
        if cause is None or unlisted:
            break
        causes.append(cause)
        one = one_for_two(causes, ranked, now.problem)
        causes = [one] if one else causes
        base = causes[-1].fit
        if len(causes) < most:
            beside = replace(search, problem=now.problem, judges=False, tolerance=TOLERANCE)
            added = [*_extended(beside, base), *_more(search, known, base)]
            now = compare_beside_rest(search, force, base, added, none.error)
    return Graded(
        now.rest,
        now.problem,
        tuple(causes),
        none,
        ranked,
        tuple(weights[first].tolist()),
        unlisted,
        now.of_run,
    )


def refitted(search: Search, found: Graded) -> Found:
    """Fit the models of causes, and the single effects, to other runs.

    Each plainly or beside the rest of these runs, as it was found. How well a plain fit knows its
    parameters, runs say by how they disagree.
    """
    models = [*(cause.chosen for cause in found.causes), *found.ranked]
    starts = [
        start
        for one in models
        for start in start_fits(search.nuisances, one.fit.model, one.fit.parameters[None])
    ]
    force = RestForce(search.problem)
    last = len(found.causes) - 1
    (rest,) = force.beside(starts[last : last + 1])
    fits: Found = {}
    for problem, plainly in ((search.problem, True), (force.beside_one(rest), False)):
        own = [s for s, one in zip(starts, models, strict=True) if one.plainly == plainly]
        for fit in fit_all(problem, own, steps=STEPS, tolerance=TOLERANCE):
            known = covariance_between_runs(problem, fit) if plainly else fit.covariance
            fits.setdefault(frozenset(fit.model.names), replace(fit, covariance=known))
    return fits


def confirmed_on_kept(search: Search, found: Graded, fits: Found) -> Graded:
    """Leave out the last causes that take no share worth a name of the error on the kept runs.

    `fits` are the models of the causes without these runs.
    """
    problem = search.problem
    if not problem.held:
        return found
    chain = [search.none, *(fits[frozenset(cause.fit.model.names)] for cause in found.causes)]
    points = [point_of(problem, fit) for fit in chain]
    errors = np.sqrt(np.nanmean(problem.position_errors(points, list(problem.held)) ** 2, axis=1))
    least = limits.LEAST_SHARE * errors[0]
    count = len(found.causes)
    while count and errors[count - 1] - errors[count] < least:
        count -= 1
    return replace(found, causes=found.causes[:count])


def predicts_kept(search: Search, fit: Fit) -> bool:
    """Return whether a model has a smaller error on the runs kept from fits than the nominal one.

    Smaller by a share that is worth a name; where none was kept, nothing speaks against it.
    """
    problem = search.problem
    kept = list(problem.held)
    if not kept:
        return True
    points = [point_of(problem, one) for one in (search.none, fit)]
    before, after = np.nanmean(problem.position_errors(points, kept) ** 2, axis=1)
    return bool(np.sqrt(after) < (1.0 - limits.LEAST_SHARE) * np.sqrt(before))


def _more(search: Search, known: Collection, base: Fit) -> list[Fit]:
    """Return the known sets with one effect more than a fit, to be fitted to these runs."""
    names = frozenset(base.model.names)
    return [
        start
        for key, fit in known.fits.items()
        if len(key) == len(names) + 1 and names < key and np.isfinite(fit.chi2)
        for start in start_fits(
            search.nuisances, search.model(fit.model.names), fit.parameters[None]
        )
    ]


def _extended(search: Search, base: Fit) -> list[Fit]:
    """Fit a set with one more effect beside it, each of those that may gain beside the rest."""
    (beside,) = evaluate(search.problem, [base.unfitted()])
    known = Collection({frozenset(base.model.names): beside})
    return list(extend(search, known, beside, search.names).values())
