"""Equivalence: rivals of a set of effects, and those of them that the data cannot tell from it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import VARIABLES, own_variables
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.all_runs import fitted_to_all
from locosweep.diagnosis.select.law_mismatch import score_with_other_law
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.score import total
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.select.search import Collection, Search


def rivals_of(search: Search, known: Collection, found: Fit) -> list[Fit]:
    """Return the sets that are known and differ from another one by one effect, best first."""
    names = frozenset(found.model.names)
    rivals = [fit for fit in known.of_size(len(names)) if len(names - {*fit.model.names}) == 1]
    return sorted(rivals, key=lambda fit: total(search, fit))


def is_limit(fit: Fit, name: str) -> bool:
    """Return whether an effect's shape is at an end of its range: then it is another one's limit.

    An effect of one parameter has no shape.
    """
    if sum(f.effect == name for f in fit.model.free) < 2:
        return False
    for i, f in enumerate(fit.model.free):
        if f.effect != name or not f.log:
            continue
        low, high = np.log(f.low), np.log(f.high)
        edge = limits.AT_AN_END * (high - low)
        if fit.theta[i] < low + edge or fit.theta[i] > high - edge:
            return True
    return False


def classes_of(
    search: Search, known: Collection, found: Fit, rivals: Sequence[Fit], mismatch: bool
) -> tuple[list[list[str]], list[list[str]]]:
    """Return what ties with each effect of a set, itself first, and other sets of as many.

    With `mismatch` its effects have other laws than their formulas; so have those of `rivals` then.
    """
    names = found.model.names
    reference = total(search, found)
    tie = limits.TIE
    if mismatch:
        own = own_variables(names)
        left = NonparametricCorrection(search.problem, found).corrected_residual(own)
        tie += limits.MISFIT_TIE * (found.chi2 - float(left @ left))
    classes = [[name] for name in names]
    sets: list[list[str]] = []
    for rival in rivals:
        if total(search, rival) - reference > tie and not _ties_over_all_runs(search, found, rival):
            continue
        new = [n for n in rival.model.names if n not in names]
        gone = [n for n in names if n not in rival.model.names]
        if len(new) != 1 or len(gone) != 1 or is_limit(rival, new[0]):
            continue
        rank = names.index(gone[0])
        more = len(rival.model.free) - len(found.model.free)
        wider = gone[0] in effect(new[0]).contains
        if wider and found.chi2 - rival.chi2 < limits.WIDER_LAW_GAIN * more:
            continue
        other = VARIABLES.get(new[0]) not in {VARIABLES.get(n) for n in names}
        if mismatch and other and score_with_other_law(search, rival) is None:
            continue
        if new[0] not in classes[rank]:
            classes[rank].append(new[0])
    for key, fit in known.fits.items():
        if len(key) != len(names) or key == frozenset(names):
            continue
        if len(key & set(names)) >= len(names) - 1 and len(names) > 1:
            continue
        if len(names) > 1 and total(search, fit) - reference <= tie:
            sets.append(sorted(key))
    return classes, sets


def _ties_over_all_runs(search: Search, found: Fit, rival: Fit) -> bool:
    """Return whether two sets tie on what is fitted and, fitted to all runs, on all of them.

    A prediction alone may be off by what few runs leave uncertain of the parameters.
    """
    if not search.judges or not search.problem.held:
        return False
    if search.score(rival) - search.score(found) > limits.TIE:
        return False
    ours, theirs = map(search.score, fitted_to_all(search, (found, rival)))
    return theirs - ours <= limits.TIE
