"""Structural mismatch: another law of a listed cause than its formula."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import ndtr

from locosweep.diagnosis.effects.catalogue import FURTHER, VARIABLES, own_variables
from locosweep.diagnosis.estimate.least_squares import Fit, evaluate, fit_all, point_of
from locosweep.diagnosis.estimate.motion import READINGS
from locosweep.diagnosis.estimate.validation import validation_residuals
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.all_runs import fitted_to_all, with_all_starts
from locosweep.diagnosis.select.by_place import ALONG, BY_PLACE, by_place_ahead
from locosweep.diagnosis.select.effort import LEAST_ERROR
from locosweep.diagnosis.select.force_law import force_law, is_monotone, is_steady
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.stepwise import without
from locosweep.diagnosis.select.whiteness import noise_level, whiteness_test
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Collection, Search

    Floats = NDArray[np.float64]

_TRIED = 6
"""Fits whose own variables are tried on what they leave."""
_MOST_TRIED = 13
"""Such fits at most, with those by other variables: the best ones, `_TRIED_NEXT` through what
corrects most beside the nominal model, and four more. With ten, a polled delay was not tried (case
886 of `locosweep blind-check --cases 1000 --gap-free 500 --seed 17171`)."""
_TRIED_NEXT = 3
"""Variables beside a fit whose effects are tried next."""
OVER_TIME = ("time", "sag")
"""Variables of friction, and of a drive, that change over the time of a run."""
MASS = "mass"
"""Variable of a mass that changes over the time of a run, which no effect stands for."""


@dataclass(frozen=True)
class OtherLaw:
    """A fit that corrections in its own effects' variables bring down to noise."""

    score: float
    """A price on every term included."""
    fit: Fit
    of_none: bool
    """True if laws of these effects do not go as the correction does: it is a law of no effect."""


def best_with_other_law(search: Search, level: Sequence[Fit]) -> OtherLaw | None:
    """Find the fit that corrections in its own effects' variables bring down furthest, to noise.

    Tried are the best fits, and effects in the variables that correct most beside the nominal model
    and beside them. Of those that tie, it is the one whose formula alone takes away most: the
    others have to bend more. A law of no effect is returned only where there is no other.
    """
    tried = list(level[:_TRIED])
    # A formula far from the law leaves its effect behind many others.
    for variable in _acting(_score_with_other_law(search, search.none)[1]):
        if variable not in own_variables(name for fit in tried for name in fit.model.names):
            tried += islice(_through(variable, level), 1)
    found = []
    done = 0
    while done < len(tried):
        new = [i for i in range(done, len(tried)) if not _is_hopeless(search.problem, tried[i])]
        done = len(tried)
        # A search leaves what falls behind, but another law starts from where a formula ends.
        ends = fit_all(search.problem, [tried[i] for i in new], steps=search.steps, least=None)
        for i, fit in zip(new, ends, strict=True):
            tried[i] = fit
            scored, others = _score_with_other_law(search, fit)
            if scored is not None:
                found.append((*scored, i))
            for variable in _acting(others):
                through = _through(variable, level)
                more = (f for f in through if all(f.model.names != g.model.names for g in tried))
                tried += islice(more, int(len(tried) < _MOST_TRIED))
    if not found:
        return None
    best = min(found)
    tying = [one for one in found if one[:2] == best[:2] and one[2] < best[2] + limits.TIE]
    if len(tying) > 1:
        best = max(tying, key=lambda one: formula_share(search, tried[one[3]]))
    of_none, _, score, i = best
    return OtherLaw(score, tried[i], of_none)


def _is_hopeless(problem: Problem, fit: Fit) -> bool:
    """Return whether no law of a fit's variables comes near to what laws of all variables leave.

    That is noise, or less: so many terms bend to anything.
    """
    if fit.chi2 < LEAST_ERROR * problem.degrees():
        return False
    terms = NonparametricCorrection(problem, fit)
    least, own = (
        fit.chi2 - terms.solve(names)[0]
        for names in (terms.variables, own_variables(fit.model.names))
    )
    return own > LEAST_ERROR * least


def _acting(variables: Sequence[str]) -> list[str]:
    """Return the first variables that effects act through.

    None acts through the acceleration.
    """
    return [v for v in variables if v in VARIABLES.values()][:_TRIED_NEXT]


def _through(variable: str, level: Sequence[Fit]) -> Iterator[Fit]:
    return (fit for fit in level if variable in own_variables(fit.model.names))


def law_through(search: Search, known: Collection, variable: str) -> Fit | None:
    """Return the effect that acts through a variable, where a law of its stands beside its formula.

    None where no effect acts through the variable, or its law does not go as that effect's may.
    """
    level = [fit for fit in known.of_size(1) if VARIABLES.get(fit.model.names[0]) == variable]
    ends = fit_all(search.problem, level, steps=search.steps, least=None)
    return next((fit for fit in ends if score_with_other_law(search, fit) is not None), None)


def score_with_other_law(search: Search, fit: Fit) -> float | None:
    """Score of a fit with other laws of its effects; None if another variable does better."""
    own = own_variables(fit.model.names)
    scored = _score_with_other_law(search, fit)[0] if own else None
    return None if scored is None or scored[0] else scored[2]


def _score_with_other_law(
    search: Search, fit: Fit
) -> tuple[tuple[bool, bool, float] | None, list[str]]:
    """Score of a fit with other laws, and what carries something beside it, the most first.

    Before the score stand whether no effect has such a law, and whether some other variable is
    clearly likelier, though by no more than the distance of knots can make.
    """
    own = own_variables(fit.model.names)
    problem = search.problem
    terms = NonparametricCorrection(problem, fit)
    left = terms.corrected_residual(own)
    noise = noise_level(problem, left)
    log_factor = terms.log_bayes_factor(own, noise)
    others = {v: terms.log_bayes_factor([v], noise) for v in terms.variables if v not in own}
    most = sorted((v for v in others if others[v] > 0.0), key=lambda v: -others[v])
    best = max(others.values(), default=0.0)
    if not own or log_factor < best - max(limits.LEAST_GAIN, limits.AS_WELL_SHARE * best):
        return None, most
    if whiteness_test(problem, left).rejected or terms.significant(own, noise):
        return None, most
    if terms.predictive_gain(own, noise) <= 0.0 or not _holds(problem, fit, own, noise):
        return None, most
    of_none = not _goes_as_it_may(search, fit)
    behind = best - log_factor > limits.LEAST_GAIN
    return (of_none, behind, search.score(fit) - log_factor * noise), most


def _goes_as_it_may(search: Search, fit: Fit) -> bool:
    """Return whether the laws found in place of formulas go as laws of their effects may.

    The registry says of which effects laws only rise, or fall (`monotone`), of which they never
    jump (`continuous`), and of which they stay near their mean (`steady`). A ground that rocks
    makes a force that rises and falls: it is no drift of friction. A tether is no uneven slope.
    """
    for name in fit.model.names:
        law = effect(name)
        if not (law.monotone or law.continuous or law.steady):
            continue
        several, variable = len(fit.model.names) > 1, VARIABLES[name]
        base = without(search, fit, name) if several else search.none
        problem = search.problem
        if law.monotone and not is_monotone(problem, base, variable):
            return False
        if law.steady and not is_steady(problem, base, variable):
            return False
        if law.continuous and _jumps(problem, base, variable):
            return False
    return True


def _jumps(problem: Problem, base: Fit, variable: str) -> bool:
    """Return whether a law may change at once, and what would do so is as likely.

    From when a mass is picked up, the drive acts less and friction more: no supply sags so, nor
    does friction drift.
    """
    law = force_law(problem, base, variable)
    if law is None or law.found is None or not law.found.may_jump:
        return False
    if variable not in OVER_TIME:
        return True
    mass = force_law(problem, base, MASS)
    return mass is not None and mass.log_factor > law.log_factor - limits.LEAST_GAIN


def several_do_better(search: Search, law: Fit, sets: Sequence[Fit]) -> bool:
    """Return whether some set of effects explains all runs better than another law of one cause.

    It has to gain what a further cause has to gain over the best explanation with one less.
    Both are fitted to all runs, those kept from fits among them where these judge: a law that
    bends to a second cause in few runs does not do so in all.
    """
    problem, kept = search.problem, search.judges and bool(search.problem.held)
    own = own_variables(law.model.names)
    noise = noise_level(problem, NonparametricCorrection(problem, law).corrected_residual(own))
    if kept:
        law, *sets = fitted_to_all(search, (law, *sets))
        problem = problem.of_all_runs
    factor = NonparametricCorrection(problem, law).log_bayes_factor(own, noise)
    least = min(search.score(fit) for fit in sets)
    return least < search.score(law) - factor * noise - limits.LEAST_GAIN


def _holds(problem: Problem, fit: Fit, own: Sequence[str], noise: float) -> bool:
    """Return whether another law, predicted from the other runs, leaves but noise in each.

    It has to in the validation runs (all runs, where none was kept) taken together, and in most
    single runs. And one law for all runs needs about as large a log Bayes factor as one of its
    own in each.
    """
    whole, same = problem.of_all_runs, with_all_starts(problem, fit)
    late = same.theta.size > fit.theta.size
    (same,) = fit_all(whole, [same], steps=8) if late else evaluate(whole, [same])
    terms = NonparametricCorrection(whole, same)
    if (
        terms.log_bayes_factor(own, noise)
        < terms.log_bayes_factor_by_run(own, noise) - limits.ONE_LAW
    ):
        return False
    left = terms.prediction_errors(own, noise)
    strange = sum(whiteness_test(whole, e, [r]).rejected for r, e in enumerate(left))
    kept = list(problem.held) or whole.fitted
    together = _together(whole, [left[r] for r in kept], kept)
    beyond = whiteness_test(whole, together, kept).deviations
    return limits.STRANGE_RUNS * strange < len(left) and beyond < limits.PREDICTION_LIMIT


def _together(problem: Problem, parts: Sequence[Floats], runs: Sequence[int]) -> Floats:
    """Join residuals of single runs: channel by channel, run by run."""
    lengths = problem.lengths[list(runs)]
    return np.concatenate([
        part[c * n : (c + 1) * n]
        for c in range(len(problem.channels))
        for part, n in zip(parts, lengths, strict=True)
    ])  # fmt: skip


def is_law_of(search: Search, fit: Fit) -> bool:
    """Return whether what a correction of a fit makes of the formula is still a law of its effect.

    It is where the formula alone takes away much of the gap; where a law of the effect's variable
    is likelier than one of any other variable, so that the formula says no more than its bends;
    and where the correction is a delay at each change of the drive, and none of these comes before
    its command: in their mean, late changes may take away next to nothing.
    """
    if formula_share(search, fit) >= limits.OTHER_LAW_SHARE or _is_likeliest(search, fit):
        return True
    late = [name for name in fit.model.names if name in FURTHER]
    return bool(late) and all(_never_early(search, fit, name) for name in late)


def variables_of(alike: Iterable[str]) -> set[str]:
    """Return the variables that effects act through; the two of `OVER_TIME` count as one."""
    found = {VARIABLES.get(name, name) for name in alike}
    return found - set(OVER_TIME) | ({OVER_TIME[0]} if found & set(OVER_TIME) else set())


def most_alike(search: Search, fit: Fit) -> int:
    """Return how many variables may carry another law of a fit's effects as well.

    One, where the law counts only because no law of another variable comes near it.
    """
    by_formula = formula_share(search, fit) >= limits.OTHER_LAW_SHARE
    return limits.MOST_ALIKE if by_formula or not _is_likeliest(search, fit) else 1


def _is_likeliest(search: Search, fit: Fit) -> bool:
    """Return whether no law of another variable comes near a law of the fit's own variable.

    Both stand beside the nominal model, in place of the formula. A force by place is no other one
    than friction along a way that is passed in one direction, and friction that changes over the
    time of a run does much the same as a drive that does. Errors of the readings never stand so: an
    encoder with play errs by place, too, and is no scale.
    """
    own = own_variables(fit.model.names)
    if set(own) & set(READINGS):
        return False
    terms = NonparametricCorrection(search.problem, search.none)
    noise = noise_level(search.problem, search.none.residual)
    others = {v for v in terms.variables if v not in own}
    if own == [ALONG] and by_place_ahead(terms, noise) <= 0.0:
        others -= {BY_PLACE}
    if set(own) <= set(OVER_TIME):
        others -= set(OVER_TIME)
    rivals = [terms.log_bayes_factor([v], noise) for v in others]
    ahead = terms.log_bayes_factor(own, noise) - max(rivals, default=0.0)
    return ahead * noise >= limits.LEAST_GAIN


def _never_early(search: Search, fit: Fit, effect: str) -> bool:
    """Return whether no change of the drive acts before its command: beyond what is uncertain."""
    problem = search.problem
    terms = NonparametricCorrection(problem, fit)
    noise = noise_level(problem, terms.corrected_residual(own_variables(fit.model.names)))
    shifts, deviations = terms.sizes_beside(FURTHER[effect], noise, effect)
    (common,) = fit.named()[effect].values()
    early = ndtr((common + shifts) / np.where(deviations > 0.0, deviations, np.inf))
    return bool(common > 0.0 and early.size and early.min() * early.size > limits.SIGNIFICANCE)


def formula_share(search: Search, fit: Fit) -> float:
    """Return the share of the gap beyond noise that a fit takes away by its formulas alone.

    Of root mean squares over the fitted and the validation data together: either alone may hold
    next to no gap. What other laws of its effects leave of the fitted data counts as noise: an
    estimate of it, times the number of readings, may be off by more than a small gap.
    """
    problem, none = search.problem, search.none
    terms = NonparametricCorrection(problem, fit)
    own = own_variables(fit.model.names)
    noise = noise_level(problem, terms.corrected_residual(own))
    fall, count, _ = terms.solve(own)
    least = fit.chi2 - fall + noise * count
    validated = validation_residuals(problem, [point_of(problem, one) for one in (none, fit)])
    least += noise * np.count_nonzero(validated[:1])
    gap, left = (
        max(one.chi2 + float(e @ e) - least, 0.0)
        for one, e in zip((none, fit), validated, strict=True)
    )
    return 1.0 - float(np.sqrt(left / gap)) if gap > 0.0 else 0.0


def without_bending_effect(
    search: Search, known: Collection, found: Fit, classes: Sequence[Sequence[str]]
) -> Fit | None:
    """Find the set without an effect that adds next to nothing through the variable of another one.

    The two are one cause, by another law than its formula.
    """
    names = found.model.names
    for name, alike in zip(names, classes, strict=True):
        rest = frozenset(names) - {name}
        fewer = known.fits.get(rest)
        if not rest or fewer is None:
            continue
        through = {VARIABLES.get(n) for n in rest} - {None}
        gain, whole = fewer.chi2 - found.chi2, search.none.chi2 - found.chi2
        if through & {VARIABLES.get(n) for n in alike} and gain < min(
            limits.BENDING_SHARE * whole, limits.BENDING_GAIN
        ):
            return fewer
    return None
