"""What a force that nobody explains looks like: its variable, its symmetry, a formula."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.estimate.least_squares import evaluate
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.spectral_line import spectral_line
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem

_MOST = 5
"""Variables that a report shows."""


@dataclass(frozen=True)
class Axis:
    """Units of a law and of its variable."""

    unit: str
    """Of the variable."""
    per: str
    """Of the law over that of the variable."""
    symbol: str
    """Of the variable, in a formula."""
    of: str = "N"
    """Of the law."""


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
    axis: Axis | None = None
    """What a law of it is drawn on; None where there is no curve."""


_SPEED = Axis("m/s", "N s/m", "|v|")
_PLACE = Axis("m", "N/m", "x")
_WAY = Axis("m", "N/m", "s")
_TIME = Axis("s", "N/s", "t")

KINDS = {
    "speed": Kind("speed", "odd", "friction that depends on the speed", "a lubricant", _SPEED),
    "place": Kind(
        "place", "odd", "friction that depends on the place", "a rough or dirty stretch", _PLACE
    ),
    "terrain": Kind(
        "place", "even", "force by place, both ways alike", "a tether, wall or sag", _PLACE
    ),
    "push": Kind(
        "time", "none", "force by time, other in each run", "a push, gusts or swaying ground"
    ),
    "load": Kind(
        "load", "odd", "friction that depends on the load", "a gear or a guide",
        Axis("N", "1", "|F|"),
    ),
    "time": Kind(
        "time", "odd", "friction that depends on the time", "warming up, wear or a load", _TIME
    ),
    "swept": Kind("distance swept", "odd", "resistance that grows with the way", "a heap", _WAY),
    "turned": Kind("distance since a turn", "odd", "force after a turn", "a bristle or play", _WAY),
    "drive": Kind(
        "drive", "none", "drive force by another curve", "an amplifier's curve", Axis("N", "1", "F")
    ),
    "sag": Kind(
        "time", "none", "drive that changes over time", "a supply that sags or a load",
        Axis("s", "1/s", "t", of="1"),
    ),
    "acceleration": Kind(
        "acceleration", "even", "force by acceleration", "a mass that moves too",
        Axis("m/s^2", "kg", "a"),
    ),
    "mass": Kind(
        "time", "none", "mass that changes over time", "a load that is picked up or lost"
    ),
    "history": Kind("earlier drive", "none", "drive that acts late", "a filter or a spring"),
    "change": Kind("command", "none", "commands late by turns", "a drive read now and then"),
    "reading": Kind(
        "reading", "none", "reading that is scaled", "a sensor's scale", Axis("m", "1", "x", of="m")
    ),
    "clock": Kind(
        "time", "none", "reading that drifts", "a sensor's drift", Axis("s", "m/s", "t", of="m")
    ),
    "late": Kind(
        "speed", "none", "reading that is late", "a sensor's delay", Axis("m/s", "s", "v", of="m")
    ),
    "line": Kind(
        "frequency", "none", "oscillation of one frequency", "hum of the mains, or a vibration"
    ),
}  # fmt: skip
"""Kinds of corrections, by the variable of `NonparametricCorrection`; `line` is a spectral line."""


def shape_of(problem: Problem, fit: Fit) -> list[dict[str, Any]]:
    """Return the variables that would carry what a fit leaves, the most first."""
    (fit,) = evaluate(problem, [fit.unfitted()])
    terms = NonparametricCorrection(problem, fit)
    found = terms.significant(noise=noise_level(problem, fit.residual))
    line = None if found else spectral_line(problem, fit.residual)
    return shapes([("line", line.share)] if line else found)


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
