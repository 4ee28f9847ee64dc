"""All laws that a case may follow.

Every cause has the law of its name and at least one other law of the same cause;
`OUTSIDE` are disturbances that no name stands for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.validation import laws_drive, laws_friction, laws_outside, laws_rest
from locosweep.validation.law_table import LAWS, Cause, Scale

if TYPE_CHECKING:
    from numpy.random import Generator

__all__ = ["CAUSES", "LAWS", "OUTSIDE", "Cause", "Scale", "draw_cause"]

# Their import puts the laws into the book.
_WRITTEN = (laws_friction, laws_drive, laws_rest, laws_outside)

OUTSIDE = tuple(name for name, form in LAWS if form == "outside")
"""Disturbances that are no effect of the list."""

CAUSES = tuple(dict.fromkeys(name for name, form in LAWS if form != "outside"))
"""Effects of the list."""


def draw_cause(rng: Generator, scale: Scale, name: str, form: str) -> Cause:
    """Draw what of a law does not depend on its strength."""
    return Cause(name, form, LAWS[name, form](scale, rng))
