"""What a force that nobody explains looks like: its variable, its symmetry, a formula."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.estimate.least_squares import evaluate
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem

_MOST = 5
"""Variables that a report shows."""


@dataclass(frozen=True)
class Kind:
    """How a correction in a variable is spoken of."""

    words: str
    """The variable, for people."""
    parity: str
    """What happens when the motion turns round: ``odd``, ``even``, or ``none`` of these."""
    family: str
    like: str
    """What such a force may be."""
    of: str = "N"
    """Unit of the law."""
    unit: str = "s"
    """Unit of the variable."""
    per: str = ""
    """Unit of the law over that of the variable."""
    symbol: str = "t"
    """Of the variable, in a formula."""


KINDS = {
    "speed": Kind(
        "speed",
        "odd",
        "friction that depends on the speed",
        "a lubricant",
        "N",
        "m/s",
        "N s/m",
        "|v|",
    ),
    "place": Kind(
        "place",
        "odd",
        "friction that depends on the place",
        "a rough or dirty stretch",
        "N",
        "m",
        "N/m",
        "x",
    ),
    "terrain": Kind(
        "place",
        "even",
        "force by place, both ways alike",
        "a tether, wall or sag",
        "N",
        "m",
        "N/m",
        "x",
    ),
    "push": Kind(
        "time",
        "none",
        "force by time, other in each run",
        "a push, gusts or swaying ground",
        "N",
        "s",
        "N/s",
        "t",
    ),
    "load": Kind(
        "load",
        "odd",
        "friction that depends on the load",
        "a gear or a guide",
        "N",
        "N",
        "1",
        "|F|",
    ),
    "time": Kind(
        "time",
        "odd",
        "friction that depends on the time",
        "warming up or wear",
        "N",
        "s",
        "N/s",
        "t",
    ),
    "swept": Kind(
        "distance swept",
        "odd",
        "resistance that grows with the way",
        "a heap",
        "N",
        "m",
        "N/m",
        "s",
    ),
    "turned": Kind(
        "distance since a turn",
        "odd",
        "force after a turn",
        "a bristle or play",
        "N",
        "m",
        "N/m",
        "s",
    ),
    "drive": Kind(
        "drive", "none", "drive force by another curve", "an amplifier's curve", "N", "N", "1", "F"
    ),
    "sag": Kind(
        "time", "none", "drive that changes over time", "a supply that sags", "1", "s", "1/s", "t"
    ),
    "acceleration": Kind(
        "acceleration",
        "even",
        "force by acceleration",
        "a mass that moves too",
        "N",
        "m/s^2",
        "kg",
        "a",
    ),
    "history": Kind("earlier drive", "none", "drive that acts late", "a filter or a spring"),
    "change": Kind("command", "none", "commands late by turns", "a drive read now and then"),
    "reading": Kind(
        "reading", "none", "reading that is scaled", "a sensor's scale", "m", "m", "1", "x"
    ),
    "clock": Kind("time", "none", "reading that drifts", "a sensor's drift", "m", "s", "m/s", "t"),
    "late": Kind("speed", "none", "reading that is late", "a sensor's delay", "m", "m/s", "s", "v"),
}
"""Kinds of corrections, by the variable of `NonparametricCorrection`."""


def shape_of(problem: Problem, fit: Fit) -> list[dict[str, Any]]:
    """Return the variables that would carry what a fit leaves, the most first."""
    (fit,) = evaluate(problem, [fit.unfitted()])
    terms = NonparametricCorrection(problem, fit)
    found = terms.significant(noise=noise_level(problem, fit.residual))
    return shapes(found)


def shapes(found: Sequence[tuple[str, float]]) -> list[dict[str, Any]]:
    """Return rows of a report for variables and the shares of squares that they would carry."""
    rows = []
    for variable, share in found[:_MOST]:
        kind = KINDS.get(variable)
        rows.append(
            {
                "variable": kind.words if kind else variable,
                "parity": kind.parity if kind else None,
                "share": float(np.clip(share, 0.0, 1.0)),
                "formula": kind.family if kind else None,
            }
        )
    return rows


def unlisted_of(variable: str, law: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return a report's entry about a force that no effect stands for.

    `law` is what is known of it (`ForceLaw.row`); of a force of each run's own nothing is.
    """
    kind = KINDS[variable]
    return {
        "family": kind.family,
        "variable": kind.words,
        "parity": kind.parity,
        "like": kind.like,
        **(law or {"formula": None, "share": None, "curve": None}),
    }
