"""The next cause that unseen runs confirm, and the effects that they cannot tell from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc, stdtrit

from locosweep.diagnosis.estimate.least_squares import evaluate, jacobian_of
from locosweep.diagnosis.estimate.unseen import groups_of
from locosweep.diagnosis.estimate.window_plan import REACH
from locosweep.diagnosis.select import thresholds as limits
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.beside_rest import Candidate, Compared

    Floats = NDArray[np.float64]

_KNOWN = 1e-9
"""Part of the largest precision from which a run knows a direction of parameters."""


@dataclass(frozen=True, eq=False)
class Cause:
    """A cause that unseen runs confirm, and the model with it and those before it."""

    names: tuple[str, ...]
    """Effects that the runs cannot tell from one another, the one that is named first."""
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


def next_cause(now: Compared, base: Fit, none: Candidate) -> Cause | None:
    """Return the next cause beside those of a model, if unseen runs confirm one."""
    able, far = _able(now, none)
    if not able:
        return None
    ranked = (_by_prediction if far else _by_likelihood)(now, able)
    # Of two ends of one effect, the better one.
    best_last = sorted(ranked.alike, key=ranked.order, reverse=True)
    own = {_added(one.fit, base): one for one in best_last}
    own |= _narrower(own, {_added(one.fit, base): one for one in able})
    # A law that has another one as its limit is no rival of it.
    names = [
        name
        for name in sorted(own, key=lambda name: ranked.order(own[name]))
        if not any(narrower in own for narrower in effect(name).contains)
    ]
    chosen = own[names[0]]
    agrees = _agrees(now.problem, chosen.fit)
    return Cause(tuple(names), chosen, now.base, agrees=agrees, weight=ranked.weight)


def one_for_two(
    causes: Sequence[Cause], singles: Sequence[Candidate], problem: Problem
) -> Cause | None:
    """Return the one effect whose limits two causes are, if it predicts unseen runs as well.

    `singles` are the models of single effects. One cause is likelier than two.
    """
    if len(causes) != 2:
        return None
    first, second = causes
    both = [{a, b} for a in first.names for b in second.names if a != b]
    able = [
        one
        for one in singles
        if any(pair <= {*effect(one.fit.model.names[0]).contains} for pair in both)
        and one.error <= limits.AS_GOOD_UNSEEN * second.chosen.error
    ]
    if not able:
        return None
    best = min(able, key=lambda one: one.error)
    agrees = _agrees(problem, best.fit)
    weight = first.weight * second.weight
    return Cause(best.fit.model.names, best, first.before, agrees=agrees, weight=weight)


def _able(now: Compared, none: Candidate) -> tuple[list[Candidate], bool]:
    """Return the models whose further cause unseen runs confirm, and whether prediction ranks them.

    Where errors are not small beside the motion, the rest is not known to first order, and says
    little of what is likely. If the model before errs so much, and none of those that halve its
    error is likelier than it, these are confirmed without; prediction ranks them. It also ranks
    where even the likeliest model errs so much.
    """
    able = [one for one in now.others if is_confirmed(now, one, none)]
    if is_far(now, now.base) and not any(_is_clear(now, one) for one in able):
        clear = [one for one in now.others if _is_clear(now, one)]
        if clear:
            return clear, True
    likeliest = min(able, key=lambda one: one.deviance, default=now.base)
    return able, bool(able) and is_far(now, likeliest)


@dataclass(frozen=True)
class _Ranked:
    """Causes that unseen runs confirm, and which of them the runs cannot tell from the first."""

    alike: Sequence[Candidate]
    order: Callable[[Candidate], tuple[float, float]]
    """By which the first is the one that is named."""
    weight: float
    """Of those alike among all."""


def weights_of(now: Compared, none: Candidate) -> Floats:
    """Return the weights of the models with one cause more, in the way in which they are ranked."""
    return _weights(now, now.others, far=_able(now, none)[1])


def is_far(now: Compared, one: Candidate) -> bool:
    """Return whether the errors of a model on unseen runs are not small beside the motion."""
    return one.error > REACH * motion_size(now.problem)


def _weights(now: Compared, models: Sequence[Candidate], *, far: bool) -> Floats:
    """Return the weights of models, together 1: by their errors on unseen runs, or by deviance."""
    if far:
        # Errors of blocks as normal values of one unknown size.
        errors = np.array([max(one.error, 1e-300) for one in models])
        behind = 2.0 * np.array([one.squares.size for one in models]) * np.log(errors)
    else:
        behind = np.array([one.deviance for one in models]) / now.inflation
    weights = np.exp(-0.5 * (behind - behind.min(initial=np.inf)) / limits.TEMPER)
    found: Floats = weights / max(float(weights.sum()), 1e-300)
    return found


def _by_likelihood(now: Compared, able: Sequence[Candidate]) -> _Ranked:
    """Rank causes by how likely they are beside the rest."""
    least = min(one.deviance for one in able)
    near = np.array([one.deviance - least < limits.TIE * now.inflation for one in able])
    inside = float(_weights(now, able, far=False)[near].sum())
    return _Ranked(_picked(able, near), lambda one: (one.deviance, 0.0), inside)


def _by_prediction(now: Compared, able: Sequence[Candidate]) -> _Ranked:
    """Rank causes by their errors on unseen runs alone.

    Of what errs so far, the rest is not known to first order, and says nothing of which is likely.
    As good as the best one is what errs little more, and what errs somewhat more with fewer
    parameters; of these, the one with the fewest parameters goes first.
    """
    best = min(able, key=lambda one: one.error)
    near = np.array([one.error <= _as_good(one, best) * best.error for one in able])
    inside = float(_weights(now, able, far=True)[near].sum())
    return _Ranked(_picked(able, near), lambda one: (len(one.fit.model.free), one.error), inside)


def _picked(able: Sequence[Candidate], near: NDArray[np.bool_]) -> list[Candidate]:
    return [one for one, as_good in zip(able, near.tolist(), strict=True) if as_good]


def _as_good(one: Candidate, best: Candidate) -> float:
    """Return the ratio of errors on unseen runs up to which a model predicts as well as another."""
    fewer = len(one.fit.model.free) < len(best.fit.model.free)
    return limits.FEWER_AS_GOOD if fewer else limits.AS_GOOD_UNSEEN


def _narrower(own: dict[str, Candidate], able: dict[str, Candidate]) -> dict[str, Candidate]:
    """Return the limits of laws that predict unseen runs about as well as the laws themselves.

    What a wider law gains beside is some of the rest, which bends it.
    """
    return {
        limit: able[limit]
        for name, wider in own.items()
        for limit in effect(name).contains
        if limit in able and able[limit].error <= limits.FEWER_AS_GOOD * wider.error
    }


def motion_size(problem: Problem) -> float:
    """Return the root mean square of the motion in the fitted runs, around the middle of each."""
    runs = [problem.runs[r].channels["x"] for r in problem.fitted]
    return float(np.sqrt(np.mean([np.nanvar(x) for x in runs])))


def _added(fit: Fit, base: Fit) -> str:
    return next(name for name in fit.model.names if name not in base.model.names)


def is_confirmed(now: Compared, one: Candidate, none: Candidate) -> bool:
    """Return whether unseen runs confirm what a model has more than the one before it.

    It has to be likelier beside the rest, and its error in blocks of unseen runs smaller: surely,
    and by a share of the nominal model's error that is worth a name. Where that error halves, what
    is correlated in the rest does not count against it.
    """
    before, clear = now.base, _is_clear(now, one)
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


def _is_clear(now: Compared, one: Candidate) -> bool:
    return one.error < limits.CLEAR_FALL * now.base.error


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
