"""Numbers and texts as the page and its short form write them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.report.figures_motion import gap_channel
from locosweep.diagnosis.report.figures_style import channel

if TYPE_CHECKING:
    from collections.abc import Callable

    from locosweep.diagnosis.report.result import Diagnosis

HEADLINES = {
    "explained": "Cause found",
    "ambiguous": "Cause narrowed down, not settled",
    "partial": "Main cause found, a rest is left",
    "none": "No gap beyond the noise",
    "unexplained": "A gap that no known effect explains",
}


def plain(text: object) -> str:
    """Return a text without characters that are not seen but turn text round."""
    shown = str(text)
    if shown.isprintable():
        return shown
    return "".join(c if c.isprintable() or c in "\n\t" else "□" for c in shown)


def number(value: float | None, digits: int = 3) -> str:
    """Return a number of some digits; "unknown" for none.

    Examples
    --------
    >>> from locosweep.diagnosis.report.written import number, percent
    >>> number(-0.01234567), percent(0.9995), percent(None)
    ('−0.0123', '100.0 %', 'unknown')
    """
    if value is None or not np.isfinite(value):
        return "unknown"
    return f"{value:.{digits}g}".replace("-", "−")


def percent(value: float | None) -> str:
    """Return a share in percent, with a digit more where it is nearly none or all."""
    if value is None or not np.isfinite(value):
        return "unknown"
    # 99.95 % is not 100 %.
    digits = 1 if 0.99 < abs(value) < 1.0 or 0.0 < abs(value) < 0.01 else 0
    return f"{100 * value:.{digits}f} %".replace("-", "−")


def rest_of(diagnosis: Diagnosis) -> str:
    """Return what the rest of a gap is called: down to the noise there is nothing to explain."""
    if diagnosis.law_mismatch:
        return "left by the nearest formula"
    noise = diagnosis.status in ("explained", "ambiguous")
    return "left, as noise" if noise else "nobody has explained"


def interval(ends: list[float | None] | None) -> str:
    """Return an interval of shares; nothing where it is not known."""
    low, high = ends or (None, None)
    return "" if low is None or high is None else f"{percent(low)} to {percent(high)}"


def sizes(diagnosis: Diagnosis) -> Callable[..., str]:
    """Return what writes an error of a channel in a unit that reads well."""

    def sized(value: float | None, name: str | None = None) -> str:
        if value is None or not np.isfinite(value):
            return "unknown"
        of = channel(name or gap_channel(diagnosis), diagnosis.nominal)
        factor, unit = of.scale(abs(value))
        return f"{number(factor * value)} {unit}"

    return sized
