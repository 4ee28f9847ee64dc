"""Channels, units, labels and line styles that the pictures of a diagnosis share."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.font_manager import FontProperties, findfont, get_font

from locosweep.diagnosis.report.units import scale
from locosweep.files.channels import CHANNELS
from locosweep.files.robot import is_rotary
from locosweep.plot import style as plot_style
from locosweep.registry import words_of_name

words = words_of_name

if TYPE_CHECKING:
    from collections.abc import Iterable

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from locosweep.files.robot import Robot

    Floats = NDArray[np.float64]

MEASURED: dict[str, Any] = {"color": "0.65", "linestyle": "-", "linewidth": 3.2}
NOMINAL: dict[str, Any] = {"color": plot_style.LINES[1][0], "linestyle": "--", "linewidth": 1.4}
AUGMENTED: dict[str, Any] = {"color": plot_style.LINES[0][0], "linestyle": "-", "linewidth": 1.1}
"""Colours differ in lightness and lines in dash and width: legible in grey too."""

_LONGEST = 24


class Channel:
    """Words, symbol and unit of a measured channel, scaled for people."""

    def __init__(self, name: str, unit: str) -> None:
        self.name = name
        self.unit = unit
        known = CHANNELS.get(name)
        self.words, self.symbol = (known.words, known.symbol) if known else (words(name), name)

    def scale(self, largest: float) -> tuple[float, str]:
        """Return factor and unit in which values up to `largest` read well."""
        return scale(largest, self.unit)

    def axis(self, unit: str, what: str = "") -> str:
        """Label of an axis."""
        return f"{what or self.words} ${self.symbol}$ [{unit}]"


def channel(name: str, robot: Robot) -> Channel:
    """Return a channel's record for a robot or bench."""
    return Channel(
        name, CHANNELS[name].unit_on(rotary=is_rotary(robot)) if name in CHANNELS else "1"
    )


def reach(fields: Iterable[Floats]) -> float:
    """Largest finite magnitude."""
    sizes = [float(np.abs(f[np.isfinite(f)]).max(initial=0.0)) for f in fields]
    return max(sizes, default=0.0)


def unit_text(unit: str) -> str:
    """Return a unit of the registry with raised exponents."""
    return unit.replace("^2", "²").replace("^3", "³")


@cache
def _known() -> frozenset[int]:
    return frozenset(get_font(findfont(FontProperties(family="DejaVu Sans"))).get_charmap())


def label(text: str) -> str:
    """Make text from a file fit to be drawn: short, printable, never taken for a formula."""
    shown = "".join(c if c.isprintable() and ord(c) in _known() else "□" for c in text)
    if len(shown) > _LONGEST:
        shown = shown[: _LONGEST - 1] + "…"
    return shown.replace("$", r"\$")


def run_label(text: str, *, kept: bool) -> str:
    """Return a run's label, with a mark if the run was kept from the fit."""
    return label(text) + (" (kept)" if kept else "")


def finish(ax: Axes) -> Axes:
    """Give axes their grid."""
    plot_style.grid(ax)
    ax.set_axisbelow(True)
    return ax
