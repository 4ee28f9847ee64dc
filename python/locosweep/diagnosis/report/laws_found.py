"""Laws that a diagnosis found beside the listed formulas: of no effect, or of a named one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.effects.catalogue import VARIABLES
from locosweep.diagnosis.estimate.least_squares import evaluate
from locosweep.diagnosis.estimate.rest import RestForce
from locosweep.diagnosis.report.law_text import row_of
from locosweep.diagnosis.select.by_place import ALONG, BY_PLACE, passes_both_ways
from locosweep.diagnosis.select.force_law import force_law
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.replayed_force import acts, settled, with_share
from locosweep.diagnosis.select.shape import KINDS, unlisted_of
from locosweep.diagnosis.select.stepwise import without
from locosweep.diagnosis.select.unlisted_rival import BY_TIME
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.report.assemble import Findings

_CARRIES = 0.5
"""Share of a gap, in chi2 beyond noise, that a variable has to carry to be what the gap looks like.
Not derived."""

_LEFT, _NOISE = 0.02, 2.0
"""Share of a gap that a law may leave which belongs to the rig, the same in each run; or what noise
alone would leave, in deviations. What is a force of its own in each run other variables carry in
part. The share was set on the forces by place or time of `locosweep blind-check --only outside
--cases 300 --seed 12121`: all tethers and rails beside which nothing is named leave less, of
35 pushes, gusts, hums and rocking grounds 10."""
_DRAWN = 4
"""Variables whose laws are compared where several carry most: a law takes up to a second."""


def unlisted_entry(found: Findings) -> dict[str, Any] | None:
    """Return what a gap that no effect accounts for looks like, if like anything.

    A force that no effect stands for and that does better than any of them, or the same as a cause
    that is named; else, where nothing is named, the variable that carries most of the gap beside
    the nominal model.
    """
    outdoes, graded = bool(found.unlisted), found.graded
    problem, base = found.search.problem, found.choice.beside or found.search.none
    own = outdoes and graded is not None and bool(graded.unlisted)
    if graded is not None and own:
        problem, base = graded.problem, graded.last.fit
    variable = found.unlisted or found.alike
    if not variable:
        if found.choice.status != "unexplained" or not found.search.names:
            return None
        variable = _looks_like(problem, base)
    if not variable:
        return None
    law = force_law(problem, base, variable)
    if law is not None and not own:
        # Beside a rest, replays say nothing of what the force alone does.
        law = settled(law, problem, base) if acts(problem, base, variable) else law
        law = with_share(law, problem, base)
    rotary = "gravity_torque" in problem.nominal
    row = None if law is None else row_of(law, rotary=rotary)
    return {"outdoes": outdoes, **unlisted_of(variable, row)}


def _looks_like(problem: Problem, base: Fit) -> str:
    """Return the variable that carries a gap, if one carries most of it."""
    (base,) = evaluate(problem, [base.unfitted()])
    terms = NonparametricCorrection(problem, base)
    noise = noise_level(problem, base.residual)
    found = {v: terms.log_bayes_factor([v], noise) for v in terms.variables}
    gap = base.chi2 / noise - problem.degrees()
    likely = sorted((v for v in found if found[v] > _CARRIES * gap > 0.0), key=lambda v: -found[v])
    # Knots of variables differ in number: in their laws the likeliest of them have as many.
    laws = [law for variable in likely[:_DRAWN] if (law := force_law(problem, base, variable))]
    best = max(laws, key=lambda law: law.log_factor, default=None)
    variable = best.variable if best else ""
    if variable == ALONG and not passes_both_ways(problem):
        # Passed in one direction only, friction along the way would be a force by place, too.
        variable = BY_PLACE
    noise_left = _NOISE * np.sqrt(2.0 * problem.degrees())
    if best and gap - best.fall <= max(_LEFT * gap, noise_left):
        return variable
    if RestForce(problem).log_bayes_factor(base) > _CARRIES * gap > 0.0:
        return BY_TIME
    return variable


def laws_of_causes(found: Findings) -> list[dict[str, Any]]:
    """Return the law of each cause that acts by another one than its formula, as it was found.

    Beside the model without this cause: all of the law, not what it has more than the formula.
    """
    choice, search = found.choice, found.search
    if not (found.named and choice.law_mismatch):
        return []
    rotary, rows = "gravity_torque" in search.problem.nominal, []
    for name in choice.fit.model.names:
        variable = VARIABLES.get(name)
        if variable is None or KINDS[variable].axis is None:
            continue
        several = len(choice.fit.model.names) > 1
        base = without(search, choice.fit, name) if several else search.none
        law = force_law(search.problem, base, variable)
        if law is None:
            continue
        kind = KINDS[variable]
        row = row_of(law, rotary=rotary)
        rows.append({"effect": name, "variable": kind.words, "parity": kind.parity, **row})
    return rows
