"""Forces that no effect stands for, against a cause that is named beside a rest."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import own_variables
from locosweep.diagnosis.estimate.least_squares import evaluate, point_of
from locosweep.diagnosis.estimate.unseen import groups_of
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.by_place import ALONG, BY_PLACE, by_place_ahead, passes_both_ways
from locosweep.diagnosis.select.force_law import force_law
from locosweep.diagnosis.select.next_cause import is_far
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.replayed_force import acts, settled, under_force
from locosweep.diagnosis.select.unlisted_rival import UNLISTED
from locosweep.diagnosis.select.unseen_errors import seen_error

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.beside_rest import Candidate, Compared
    from locosweep.diagnosis.select.next_cause import Cause

    Floats = NDArray[np.float64]


def unlisted_beside(now: Compared, cause: Cause) -> str:
    """Return the variable of an unlisted force that does better than a cause, if any.

    Such a force is known to first order: of errors that are not small beside the motion it takes
    away whatever they are. A cause that halves them when replayed is refuted there by a force that
    is replayed as well.
    """
    problem, along = now.problem, own_variables(cause.names) == [ALONG]
    if along and not passes_both_ways(problem):
        # Where the two are one, runs do not confirm the friction.
        return BY_PLACE
    if is_far(now, now.base) and cause.chosen.error < limits.CLEAR_FALL * now.base.error:
        return BY_PLACE if _place_does_better(replace(problem, rest=()), now.base, cause) else ""
    before, after = evaluate(problem, [now.base.fit.unfitted(), cause.fit.unfitted()])
    more = len(after.model.free) - len(before.model.free)
    gain = before.chi2 - after.chi2 - limits.PENALTY * more
    terms = NonparametricCorrection(problem, before)
    if along and by_place_ahead(terms, 1.0) >= 0.0:
        return BY_PLACE
    factors = {v: terms.log_bayes_factor([v], 1.0) for v in UNLISTED}
    best = max(factors, key=lambda v: factors[v])
    least = limits.UNLISTED_GAIN * max(gain, 0.0) + limits.LEAST_GAIN * now.inflation
    return best if factors[best] > least else ""


def _place_does_better(problem: Problem, base: Candidate, cause: Cause) -> bool:
    """Return whether a force by place, replayed beside a model, halves what a cause leaves.

    With several runs, of runs that neither was found in: the force of half of the runs is replayed
    on the other half, as a law takes replays.
    """
    if not acts(problem, base.fit, BY_PLACE):
        return False
    groups = groups_of(problem, problem.fitted)
    if len(groups) < 2:
        (left,) = seen_error(problem, [cause.fit])
        return _rms(_errors_by_place(problem, base.fit, problem.fitted)) < limits.CLEAR_FALL * left
    errors = []
    for first in (0, 1):
        unseen = [run for group in groups[first::2] for run in group]
        others = replace(
            problem,
            held=(*problem.held, *unseen),
            known=problem.noise,
            initial=problem.initial_or_none,
        )
        errors.append(_errors_by_place(others, base.fit, unseen))
    return _rms(np.concatenate(errors)) < limits.CLEAR_FALL * cause.chosen.error


def _rms(errors: Floats) -> float:
    return float(np.sqrt(np.nanmean(np.square(errors))))


def _errors_by_place(problem: Problem, base: Fit, runs: Sequence[int]) -> Floats:
    """Return the errors of some runs under the force by place of the fitted ones.

    Infinite where there is none.
    """
    (fit,) = evaluate(problem, [base.unfitted()])
    law = force_law(problem, fit, BY_PLACE)
    under = under_force(settled(law, problem, fit), problem, fit) if law else None
    if under is None:
        return np.array([np.inf])
    (errors,) = under.position_errors([point_of(under, fit)], list(runs))
    return np.asarray(errors)
