"""Effects that are not identifiable from these runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from collections.abc import Mapping

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Collection, Search

_SHARE = 0.3
"""Share of a large effect; one whose strength is less sure than that is not identifiable."""


def not_visible(
    search: Search, known: Collection, left_out: Mapping[str, str]
) -> list[dict[str, str]]:
    """Return the effects that these runs cannot identify, each with the reason."""
    rows = [{"effect": name, "why": why} for name, why in left_out.items()]
    directions = _directions(search.problem)
    for name in search.names:
        fit = known.single(name)
        why = _why(fit, *directions) if fit is not None else None
        if why:
            rows.append({"effect": name, "why": why})
    return rows


def _directions(problem: Problem) -> tuple[bool, bool]:
    """Return whether the head moves forward, and whether backward, in the fitted runs."""
    found = [problem.motions[r] for r in problem.fitted]
    forward = any((m.v > m.resting_speed).any() for m in found)
    return forward, any((m.v < -m.resting_speed).any() for m in found)


def _why(fit: Fit, forward: bool, backward: bool) -> str | None:
    shown = effect(fit.model.names[0]).shown
    if shown == "both_ways" and forward != backward:
        never = "backward" if forward else "forward"
        return f"the head never moves {never} in these runs"
    if shown == "forward" and not forward:
        return "the head never moves forward in these runs"
    if not forward and not backward:
        return None if shown == "at_rest" else "the head does not move in these runs"
    spread = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0)) if fit.covariance.size else None
    if spread is None or not len(fit.model.free):
        return None
    strength = fit.model.free[0]
    if not strength.log and spread[0] > _SHARE * strength.size:
        return "even a large one would stay within the noise of these runs"
    return None
