"""The choice: which set of effects, what else fits as well, how sure that is."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import VARIABLES
from locosweep.diagnosis.estimate.least_squares import Fit, point_of
from locosweep.diagnosis.estimate.validation import validation_residuals
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.descent import beyond_ridges, takes_place
from locosweep.diagnosis.select.equivalence import classes_of, is_limit, rivals_of
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.law_mismatch import (
    OtherLaw,
    best_with_other_law,
    is_law_of,
    law_through,
    most_alike,
    several_do_better,
    variables_of,
    without_bending_effect,
)
from locosweep.diagnosis.select.prediction import misses
from locosweep.diagnosis.select.score import gains, remaining, stalled_beside, total
from locosweep.diagnosis.select.spectral_line import spectral_line
from locosweep.diagnosis.select.stepwise import backward, exchanged, forward
from locosweep.diagnosis.select.unlisted_rival import unlisted_rival
from locosweep.diagnosis.select.whiteness import whiteness_test

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.diagnosis.select.graded import Graded
    from locosweep.diagnosis.select.search import Collection, Found, Search
    from locosweep.diagnosis.select.spectral_line import SpectralLine
    from locosweep.diagnosis.select.whiteness import WhitenessTest

_COMPARED = 3
"""Sets of several effects that are compared with another law of one: fitted to all runs, those that
nearly tie may change places. Not derived."""
_NEAR_NOISE = 2.0
"""Chi2, in degrees of freedom, up to which several effects that leave more than noise are looked
for in other valleys: as much as noise again. Not derived; a set that had ended in a wrong valley
(case 105 of `locosweep blind-check --cases 1000 --gap-free 1000 --seed 15151`) left 1.01."""
_LARGEST_EXPONENT = 50.0
"""Exponent beyond which a probability is 0 to all digits that matter; exp stays finite."""


@dataclass(frozen=True)
class Choice:
    """Verdict of the search: the chosen fit and what ties with it.

    `classes` holds for each of its effects all that tie with it; `sets` other complete
    explanations of the same size.
    """

    status: str
    fit: Fit
    known: Collection
    """The best fit of each set of effects that was tried."""
    whiteness: WhitenessTest
    classes: list[list[str]] = field(default_factory=list)
    sets: list[list[str]] = field(default_factory=list)
    law_mismatch: bool = False
    probability: float = 1.0
    ranked: list[tuple[Fit, float]] = field(default_factory=list)
    shape: list[tuple[str, float]] = field(default_factory=list)
    near: float = 0.0
    """Gain of the best further effect: not enough, or not where it is fitted."""
    unlisted: str = ""
    """Variable of a force that no effect stands for, and that refutes those that were found."""
    beside: Fit | None = None
    """The model beside which that force does so."""
    missed: bool = False
    """True if the fit leaves of the runs kept from it more than the others show."""
    line: SpectralLine | None = None
    """Line in the spectrum of what the fit leaves, where that looks like noise otherwise."""
    law_of_none: bool = False
    """True if a law of an effect's variable leaves but noise, and goes as no law of that effect."""

    @property
    def refuted(self) -> bool:
        """True if the runs kept from the fit ask for more than the others do."""
        return self.status != "unexplained" and (self.near >= limits.LEAST_GAIN or self.missed)

    @property
    def outdone(self) -> bool:
        """True if it is clear that the one cause is none of the list.

        A law of no effect leaves but noise, or does better than a single effect that does.
        """
        single = len(self.fit.model.names) == 1 and not self.whiteness.rejected
        return self.law_of_none or (bool(self.unlisted) and single)

    @property
    def says(self) -> tuple[str, bool, list[set[str]], list[list[str]]]:
        """What a reader is told of the causes, without its numbers."""
        return self.status, self.law_mismatch, [set(one) for one in self.classes], self.sets

    @property
    def tied(self) -> list[Fit]:
        """The chosen fit, and those that the data cannot tell from it where there are any."""
        if self.status != "ambiguous":
            return [self.fit]
        names = self.fit.model.names
        keys = [
            frozenset(other if n == name else n for n in names)
            for name, alike in zip(names, self.classes, strict=True)
            for other in alike
            if other != name
        ]
        keys += [frozenset(others) for others in self.sets]
        return [self.fit, *(self.known.fits[key] for key in keys if key in self.known.fits)]

    def weight(self, fit: Fit) -> float:
        """Return the weight of a fit's set of effects among those that are ranked."""
        names = frozenset(fit.model.names)
        return next((w for one, w in self.ranked if frozenset(one.model.names) == names), 0.0)


def partial_choice(first: Choice, found: Graded, fits: Found) -> Choice:
    """Return the choice of the causes that unseen runs confirm beside what nobody explains.

    `fits` are the models of these causes without the runs that are kept from fits.
    """
    known = first.known.adding(fits)
    last = fits[frozenset(found.causes[-1].fit.model.names)]
    ranked = [
        (known.fits[frozenset(one.fit.model.names)], weight)
        for one, weight in zip(found.ranked, found.weights, strict=True)
        if frozenset(one.fit.model.names) in known.fits
    ]
    return replace(
        first,
        status="partial",
        fit=last,
        known=known,
        classes=[list(cause.names) for cause in found.causes],
        ranked=[(last, 1.0), *ranked] if len(last.model.names) > 1 else ranked,
        probability=limits.CONFIRMED_PROBABILITY
        * float(np.prod([cause.weight for cause in found.causes])),
    )


def leaving_line(search: Search, choice: Choice, line: SpectralLine) -> Choice:
    """Return a choice whose causes leave a line: they do not explain what oscillates."""
    if not choice.fit.model.names or choice.status == "unexplained":
        return choice
    found = replace(
        choice, status="unexplained", line=line, classes=[], sets=[], law_mismatch=False
    )
    return replace(found, probability=_probability(search, found))


@dataclass(frozen=True)
class _Grown:
    """Smallest set that the forward steps came to, and the fits that they made."""

    known: Collection
    level: list[Fit]
    """Sets of as many effects as the last step tried; best first."""
    found: Fit
    near: float = 0.0
    """Gain of the best further effect: not enough."""
    mismatch_score: float | None = None
    """Score of `found` with other laws of its effects, where only these do."""
    law: OtherLaw | None = None
    """The best single effect with another law, where several effects do better."""


def choose(search: Search, most: int) -> Choice:
    """Search for the smallest set of at most `most` effects that leaves only noise."""
    problem, none = search.problem, search.none
    search.progress("single effects")
    known = singles(search)
    alone = [fit for names, fit in known.fits.items() if names]
    alone.sort(key=lambda fit: total(search, fit))
    best = alone[0] if alone else none
    if not gains(search, none, best):
        rest, line = remaining(problem, none), spectral_line(problem, none.residual)
        choice = Choice(
            "unexplained" if rest or line else "none",
            none,
            known,
            whiteness_test(problem, none.residual),
            line=line,
            shape=rest,
            near=total(search, none) - total(search, best),
        )
        return _with_ranks(search, choice, [none, *alone])
    grown = _grown(search, known, alone, most)
    known, found, score = grown.known, grown.found, grown.mismatch_score
    mismatch = score is not None
    tried = [none, *alone, *grown.level]
    whiteness = whiteness_test(problem, found.residual)
    rest = [] if mismatch else remaining(problem, found)
    if rest and len(found.model.names) > 1 and found.chi2 < _NEAR_NOISE * problem.degrees():
        # Little more than noise: it may have ended in another valley than the right one.
        found = beyond_ridges(search, found, lambda fit: takes_place(search, fit))
        known = known.adding({frozenset(found.model.names): found})
        rest = remaining(problem, found)
    law_of_none = grown.law is not None and grown.law.of_none
    if rest and grown.law is not None and not law_of_none:
        # Several effects come nearer, but not to noise as a law does.
        score, found, mismatch, rest = grown.law.score, grown.law.fit, True, []
    if rest:
        choice = Choice("unexplained", found, known, whiteness, shape=rest, law_of_none=law_of_none)
        return _with_ranks(search, choice, tried)
    if variable := _law_of_none(search, grown.law, found):
        choice = Choice(
            "unexplained",
            found,
            known,
            whiteness,
            law_of_none=True,
            unlisted=variable,
            beside=search.none,
        )
        return _with_ranks(search, choice, tried)
    search.progress("rivals")
    if len(found.model.names) > 1:
        found, known = exchanged(search, known, found)
    whiteness = whiteness_test(problem, found.residual)
    score = search.score(found) if score is None else score
    unlisted, beside = unlisted_rival(search, known, found, score, mismatch=mismatch)
    if listed := law_through(search, known, unlisted) if unlisted else None:
        # What refutes the others is another law of this one.
        found, mismatch, unlisted = listed, True, ""
        whiteness = whiteness_test(problem, found.residual)
    if unlisted:
        choice = Choice("unexplained", found, known, whiteness, unlisted=unlisted, beside=beside)
        return _with_ranks(search, choice, tried)
    if mismatch and not is_law_of(search, found):
        choice = Choice("unexplained", found, known, whiteness, shape=remaining(problem, found))
        return _with_ranks(search, choice, tried)
    rivals = rivals_of(search, known, found)
    classes, sets = classes_of(search, known, found, rivals, mismatch)
    near, simpler = grown.near, without_bending_effect(search, known, found, classes)
    if simpler:
        found, mismatch, near = simpler, True, 0.0
        whiteness = whiteness_test(problem, found.residual)
        if len(found.model.names) > 1:
            # Whatever scores better by its formulas: this set has other laws than these.
            _, known = exchanged(search, known, found)
        rivals = rivals_of(search, known, found)
        classes, sets = classes_of(search, known, found, rivals, mismatch)
    tried += rivals
    alike = max(len(variables_of(c)) for c in classes) if mismatch else 0
    if alike > 1 and alike > most_alike(search, found):
        choice = Choice("unexplained", found, known, whiteness, shape=remaining(problem, found))
        return _with_ranks(search, choice, tried)
    status = "explained" if all(len(c) == 1 for c in classes) and not sets else "ambiguous"
    missed = (not mismatch or simpler is not None) and misses(search, found)
    choice = Choice(
        status, found, known, whiteness, classes, sets, mismatch, near=near, missed=missed
    )
    return _with_ranks(search, choice, tried)


def _grown(search: Search, known: Collection, level: list[Fit], most: int) -> _Grown:
    """Add effects to the best single one, one by one, while they gain enough."""
    problem = search.problem
    before, found = search.none, level[0]
    law: OtherLaw | None = None
    near = 0.0
    for count in range(2, most + 2):
        rest = remaining(problem, found)
        # Other laws of several effects at once could fit anything.
        if rest and count == 2:
            law = best_with_other_law(search, level)
        mismatched = law if count == 2 and law and not law.of_none else None
        larger: list[Fit] = []
        if count <= most and not (count > 2 and found.chi2 > stalled_beside(problem, before)):
            search.progress(f"{count} effects at once")
            beside = replace(known, law=mismatched.score) if mismatched else known
            known = forward(search, beside, level, found, rest=bool(rest))
            known = replace(known, law=np.inf)
            ordered = sorted(known.of_size(count), key=lambda fit: total(search, fit))
            if mismatched and ordered and not remaining(problem, ordered[0]):
                # The best of them competes with a law that bends to anything.
                _, known = exchanged(search, known, ordered[0])
                ordered = sorted(known.of_size(count), key=lambda fit: total(search, fit))
            near = total(search, found) - total(search, ordered[0]) if ordered else 0.0
            larger = [fit for fit in ordered if gains(search, found, fit)]
        if mismatched and (not larger or not _are_causes(search, larger, mismatched.fit)):
            # The gain of further effects is the misfit of the law.
            return _Grown(known, level, mismatched.fit, mismatch_score=mismatched.score)
        if not larger:
            break
        before, level, near = found, larger, 0.0
        found, known = backward(search, known, larger[0])
        if len(found.model.names) < count and not remaining(problem, found):
            break
    return _Grown(known, level, found, near, law=law)


def _law_of_none(search: Search, law: OtherLaw | None, found: Fit) -> str:
    """Return the variable of a law that no effect has and that does as well as several effects.

    It refutes them then, as a force that no effect stands for does.
    """
    if law is None or not law.of_none or len(found.model.names) < 2:
        return ""
    as_well = law.score <= search.score(found) + limits.LEAST_GAIN
    return VARIABLES[law.fit.model.names[0]] if as_well else ""


def _are_causes(search: Search, sets: Sequence[Fit], law: Fit) -> bool:
    """Return whether sets of several effects explain a gap rather than another law of one does.

    They have to do better; to leave but noise is enough where what the law bends to is none of its
    effect.
    """
    if several_do_better(search, law, sets[:_COMPARED]):
        return True
    return not (remaining(search.problem, sets[0]) or is_law_of(search, law))


def kept_may_show_a_gap(search: Search, choice: Choice) -> bool:
    """Return whether all runs together may show a cause where those that are fitted show none.

    They may if the nominal model leaves more than noise of the runs kept from fits, or if some
    effect predicts these better.
    """
    if choice.fit.model.names:
        return False
    problem = search.problem
    e = validation_residuals(problem, [point_of(problem, search.none)])[0]
    beyond = whiteness_test(problem, e, problem.held).deviations
    return choice.near > 0.0 or beyond > limits.PREDICTION_LIMIT


def _with_ranks(search: Search, choice: Choice, fits: Sequence[Fit]) -> Choice:
    """Order the fits, and weigh them against each other."""
    unique = {frozenset(f.model.names): f for f in fits}
    unique[frozenset(choice.fit.model.names)] = choice.fit
    ranked = sorted(unique.values(), key=lambda fit: total(search, fit))
    scores = np.array([total(search, fit) for fit in ranked])
    # Sets that leave more than noise are no explanations, however they rank.
    weights = np.exp(-0.5 * (scores - scores.min()) / limits.TEMPER)
    weights /= weights.sum()
    choice = replace(choice, ranked=list(zip(ranked, weights.tolist(), strict=True)))
    return replace(choice, probability=_probability(search, choice))


def _probability(search: Search, choice: Choice) -> float:
    """Return the probability that a verdict is right, from how far it is from its thresholds."""
    none = total(search, search.none)
    if choice.status == "none":
        best = min((total(search, f) for f, _ in choice.ranked if f.model.names), default=none)
        sure = 1.0 - _doubt(limits.LEAST_GAIN - (none - best)) - limits.NEVER_SURE
        return float(np.clip(sure, limits.TOSS_UP, limits.MOST_SURE))
    if choice.status == "unexplained":
        least = choice.line.deviations if choice.line else -np.inf
        beyond = max(choice.whiteness.deviations, least) - limits.WHITENESS_LIMIT
        doubt = limits.UNEXPLAINED_DOUBT * np.exp(-beyond / limits.UNEXPLAINED_SCALE)
        sure = 1.0 - doubt - limits.UNEXPLAINED_REST
        return float(np.clip(sure, limits.TOSS_UP, limits.UNEXPLAINED_SURE))
    if choice.law_mismatch:
        # Scores weigh formulas that do not fit: they say nothing about the cause.
        return limits.OTHER_LAW_PROBABILITY
    inside = 0.0
    for fit, weight in choice.ranked:
        inside += weight if _agrees(choice, fit) else 0.0
    found = 1.0 - _doubt(none - total(search, choice.fit) - limits.LEAST_GAIN)
    # A further effect that nearly gains what is asked for may well be there.
    odds = (choice.near - limits.LEAST_GAIN) / limits.GAIN_SCALE
    found /= 1.0 + np.exp(min(odds, _LARGEST_EXPONENT))
    return float(np.clip(limits.MOST_SURE * inside * found, limits.LEAST_SURE, limits.MOST_SURE))


def _doubt(margin: float) -> float:
    """Return the doubt about a gain that is a margin in penalised chi2 from its threshold."""
    return float(limits.TOSS_UP * np.exp(-0.5 * max(margin, 0.0) / limits.GAIN_SCALE))


def _agrees(choice: Choice, fit: Fit) -> bool:
    """Return whether a set of effects speaks for the chosen one."""
    names, chosen = set(fit.model.names), set(choice.fit.model.names)
    if names != chosen and any(is_limit(fit, name) for name in names):
        # Another effect's limit speaks for that effect.
        return True
    in_class = len(names) == len(choice.classes) and all(names & {*c} for c in choice.classes)
    # Wider laws and supersets of the chosen one are not against it.
    return in_class or sorted(names) in map(sorted, choice.sets) or names >= chosen
