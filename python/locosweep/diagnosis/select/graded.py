"""The graded verdict: causes that unseen runs confirm, where no set of effects leaves but noise.

Every model leaves the same rest (`estimate/rest.py`). A cause has to predict runs that it was not
fitted to better than the model without it; the likeliest of those beside the rest is named. Errors
of free runs are mostly the rest's, so that alone they name what bends to it. Where they are not
small beside the motion, the rest is not known to first order, and only what predicts about as well
as the best model can be named.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc, stdtrit

from locosweep.diagnosis.estimate.least_squares import (
    chi2_of,
    evaluate,
    fit_all,
    jacobian_of,
    point_of,
    start_fits,
)
from locosweep.diagnosis.estimate.rest import Rest, RestForce
from locosweep.diagnosis.estimate.unseen import groups_of
from locosweep.diagnosis.estimate.window_plan import REACH
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.descent import apart
from locosweep.diagnosis.select.extension import extend
from locosweep.diagnosis.select.law_mismatch import UNLISTED
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.search import Collection, Found
from locosweep.diagnosis.select.unseen_errors import seen_error, unseen_squares
from locosweep.diagnosis.select.whiteness import inflation
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Search

    Floats = NDArray[np.float64]

_STEPS, _TOLERANCE = 15, 1.0
"""Steps of a fit, at most, and the fall of chi2 that ends it: a twelfth of what tells effects
apart."""
_ROUNDS = 3
"""Times that the rest is found beside the likeliest fit, at most: few need more than one."""
_KNOWN = 1e-9
"""Part of the largest precision from which a run knows a direction of parameters."""


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
class Cause:
    """A cause that unseen runs confirm, and the model with it and those before it."""

    names: tuple[str, ...]
    """Effects that the runs cannot tell from one another, the likeliest first."""
    chosen: Candidate
    before: Candidate
    """The model without it."""
    agrees: bool | None
    """True if its parameters agree between runs within what the rest allows; None with one run."""
    weight: float
    """Weight of its class among the causes that unseen runs confirm as well."""

    @property
    def fit(self) -> Fit:
        """The model with this cause and those before it."""
        return self.chosen.fit


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
    """Single effects, the likeliest first."""
    inflation: float = 1.0
    """Factor by which differences in deviance of `ranked` count for less."""
    unlisted: str = ""
    """Variable of a force that no effect stands for and that does better than any, if any."""

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
    now = _compared(search, force, base, _more(search, known, base))
    first, ranked = now, sorted(now.others, key=lambda c: c.deviance)
    while len(causes) < most:
        cause = _cause(now, base, first.base)
        unlisted = _unlisted(now, cause) if cause else ""
        if cause is None or unlisted:
            break
        causes.append(cause)
        base = cause.fit
        if len(causes) < most:
            beside = replace(search, problem=now.problem, judges=False)
            added = [*_extended(beside, base), *_more(search, known, base)]
            now = _compared(search, force, base, added, first.base.error)
    return Graded(
        now.rest,
        now.problem,
        tuple(causes),
        first.base,
        tuple(ranked),
        first.inflation,
        unlisted,
    )


def refitted(search: Search, found: Graded) -> Found:
    """Fit the models of causes, and the single effects, to other runs.

    Each plainly or beside the rest of these runs, as it was found.
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
        for fit in fit_all(problem, own, steps=_STEPS, tolerance=_TOLERANCE):
            fits.setdefault(frozenset(fit.model.names), fit)
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


@dataclass(frozen=True, eq=False)
class _Compared:
    """Models beside the rest that is likeliest beside the best of them."""

    rest: Rest
    problem: Problem
    base: Candidate
    others: list[Candidate]
    inflation: float
    """Factor by which differences in deviance count for less, as what even the rest leaves is
    correlated."""


def _compared(
    search: Search, force: RestForce, base: Fit, fits: Sequence[Fit], error: float | None = None
) -> _Compared:
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
        ends = fit_all(problem, [fit.unfitted() for fit in now], steps=_STEPS, tolerance=_TOLERANCE)
        now, rests = ends, force.beside(ends)
        new = rests[int(np.argmin(price + [one.deviance for one in rests]))]
        if (new.size, new.time) == (rest.size, rest.time):
            break
    found = []
    plain_rows, rows = (
        unseen_squares(search, search.problem, plain),
        unseen_squares(search, problem, now),
    )
    for i, (one, cost) in enumerate(zip(rests, price.tolist(), strict=True)):
        plainly = float(plain_rows[i].mean()) < float(rows[i].mean())
        fit, squares = (plain[i], plain_rows[i]) if plainly else (now[i], rows[i])
        found.append(Candidate(fit, one.deviance + cost, squares, plainly))
    likeliest = min(range(len(found)), key=lambda i: found[i].deviance)
    (left,) = evaluate(problem, [now[likeliest].unfitted()])
    return _Compared(rest, problem, found[0], found[1:], inflation(problem, left.residual))


def _plainly(problem: Problem, base: Fit, fits: Sequence[Fit], error: float | None) -> list[Fit]:
    """Fit a model, and those of others that lower its error of x by a share worth a name.

    The error is that on the fitted runs: what lowers it by less would not lower that on other
    runs by more. The share is one of `error`, or of what `base` leaves.
    """
    (own,) = fit_all(problem, [base.unfitted()], steps=_STEPS, tolerance=_TOLERANCE)
    (before,) = seen_error(problem, [own])
    most = max(before - limits.LEAST_SHARE * (before if error is None else error), 0.0)
    # Where more than noise is left, chi2 goes about with the square of the error.
    limit = own.chi2 * (most / before) ** 2 if before > 0.0 else np.inf
    starts = [replace(fit.unfitted(), limit=limit) for fit in fits]
    fitted = fit_all(problem, starts, steps=_STEPS, tolerance=_TOLERANCE)
    able = [replace(fit, limit=np.inf) for fit in fitted if np.isfinite(fit.chi2)]
    able = [fit for fit, left in zip(able, seen_error(problem, able), strict=True) if left <= most]
    return [own, *apart(sorted(able, key=chi2_of))]


def _cause(now: _Compared, base: Fit, none: Candidate) -> Cause | None:
    """Return the next cause beside those of a model, if unseen runs confirm one."""
    able = [one for one in now.others if _confirmed(now, one, none)]
    if not able:
        return None
    near, likeliest = able, min(able, key=lambda one: one.deviance)
    if likeliest.error > REACH * _motion(now.problem):
        # Of what errs so far, the rest is not known to first order: prediction goes first.
        least = min(one.error for one in able)
        near = [one for one in able if one.error <= limits.AS_GOOD_UNSEEN * least]
        likeliest = min(near, key=lambda one: one.deviance)
    tie = limits.TIE * now.inflation
    alike = [one for one in near if one.deviance - likeliest.deviance < tie]
    own = {_added(one.fit, base): one for one in alike}
    own |= _narrower(own, {_added(one.fit, base): one for one in able})
    # A law that has another one as its limit is no rival of it.
    names = [
        name
        for name in sorted(own, key=lambda name: own[name].deviance)
        if not any(narrower in own for narrower in effect(name).contains)
    ]
    chosen = own[names[0]]
    behind = np.array([one.deviance - likeliest.deviance for one in near])
    weights = np.exp(-0.5 * behind / (limits.TEMPER * now.inflation))
    inside = float(weights[behind < tie].sum() / weights.sum())
    agrees = _agrees(now.problem, chosen.fit)
    return Cause(tuple(names), chosen, now.base, agrees=agrees, weight=inside)


def _narrower(own: dict[str, Candidate], able: dict[str, Candidate]) -> dict[str, Candidate]:
    """Return the limits of laws that predict unseen runs about as well as the laws themselves.

    What a wider law gains beside is some of the rest, which bends it.
    """
    return {
        limit: able[limit]
        for name, wider in own.items()
        for limit in effect(name).contains
        if limit in able and able[limit].error <= limits.AS_GOOD_UNSEEN * wider.error
    }


def _motion(problem: Problem) -> float:
    """Return the root mean square of the motion in the fitted runs, around the middle of each."""
    runs = [problem.runs[r].channels["x"] for r in problem.fitted]
    return float(np.sqrt(np.mean([np.nanvar(x) for x in runs])))


def _added(fit: Fit, base: Fit) -> str:
    return next(name for name in fit.model.names if name not in base.model.names)


def _confirmed(now: _Compared, one: Candidate, none: Candidate) -> bool:
    """Return whether unseen runs confirm what a model has more than the one before it.

    It has to be likelier beside the rest, and its error in blocks of unseen runs smaller: surely,
    and by a share of the nominal model's error that is worth a name. Where that error halves, what
    is correlated in the rest does not count against it.
    """
    before = now.base
    clear = one.error < limits.CLEAR_FALL * before.error
    if before.deviance - one.deviance < limits.LEAST_GAIN * (1.0 if clear else now.inflation):
        return False
    least = limits.LEAST_SHARE if before.fit.model.names else limits.MAIN_SHARE
    if before.error - one.error < least * none.error:
        return False
    if clear:
        return True
    fall = np.sqrt(before.squares) - np.sqrt(one.squares)
    if fall.size < 2:
        return True
    spread = float(np.std(fall, ddof=1)) / np.sqrt(fall.size)
    sure = float(stdtrit(fall.size - 1, limits.SURE_UNSEEN))
    return bool(float(fall.mean()) > sure * spread)


def _unlisted(now: _Compared, cause: Cause) -> str:
    """Return the variable of an unlisted force that does better than a cause, if any."""
    problem = now.problem
    before, after = evaluate(problem, [now.base.fit.unfitted(), cause.fit.unfitted()])
    more = len(after.model.free) - len(before.model.free)
    gain = before.chi2 - after.chi2 - limits.PENALTY * more
    terms = NonparametricCorrection(problem, before)
    factors = {v: terms.log_bayes_factor([v], 1.0) for v in UNLISTED}
    best = max(factors, key=lambda v: factors[v])
    least = limits.UNLISTED_GAIN * max(gain, 0.0) + limits.LEAST_GAIN * now.inflation
    return best if factors[best] > least else ""


def _agrees(problem: Problem, fit: Fit) -> bool | None:
    """Return whether the parameters of a fit agree between runs: Cochran's Q beside the rest.

    The rest is known to first order only: a spread that is a small part of a parameter is none.
    """
    groups = groups_of(problem, problem.fitted)
    if len(groups) < 2:
        return None
    (fit,) = evaluate(problem, [fit.unfitted()])
    slopes = jacobian_of(problem, fit)[: len(fit.model.free)]
    weights, pulls = [], []
    for group in groups:
        own = np.concatenate([problem.of_run(r, problem.fitted) for r in group])
        weights.append(slopes[:, own] @ slopes[:, own].T)
        pulls.append(slopes[:, own] @ fit.residual[own])
    whole = sum(weights, np.zeros((len(slopes), len(slopes))))
    # What all runs ask for together is no disagreement.
    shift = np.linalg.lstsq(whole, sum(pulls, np.zeros(len(slopes))), rcond=None)[0]
    statistic, count, scatter = 0.0, -shift.size, np.zeros(shift.size)
    for weight, pull in zip(weights, pulls, strict=True):
        left = pull - weight @ shift
        values, vectors = np.linalg.eigh(weight)
        keep = values > _KNOWN * max(float(values[-1]), 1e-300)
        along = vectors[:, keep].T @ left
        statistic += float(np.sum(along**2 / values[keep]))
        count += int(keep.sum())
        scatter += np.diag(weight) * np.square(vectors[:, keep] @ (along / values[keep]))
    spread = np.sqrt(scatter / np.maximum(np.diag(whole), 1e-300))
    logs = np.array([free.log for free in fit.model.free])
    size = np.where(logs, 1.0, np.abs(fit.theta[: shift.size]))
    alike = bool((spread < limits.ALIKE_BETWEEN_RUNS * np.maximum(size, 1e-300)).all())
    return alike or count <= 0 or bool(chdtrc(count, statistic) > limits.AGREEMENT)
