"""Numbers at the ticks of axes: each complete, with no factor or offset in a corner."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from matplotlib.ticker import FixedLocator, Formatter, MaxNLocator, NullLocator, ScalarFormatter

if TYPE_CHECKING:
    from collections.abc import Iterable

    from matplotlib.axes import Axes
    from matplotlib.axis import Axis

_PLAIN = (1e-4, 1e6)
"""Numbers between these are written without a power of ten: six digits are still read."""
_FEW, _MANY = 3, 8
"""Ticks that tell a logarithmic scale, and those that a narrow picture has room for."""
_MOST = 15
"""Digits that a float has."""


class PlainNumbers(Formatter):
    """Write every tick as a whole number of its own, with as many digits as tell ticks apart.

    Examples
    --------
    >>> from locosweep.plot.numbers import PlainNumbers
    >>> PlainNumbers().format_ticks([0.85, 0.850005, 0.85001])
    ['0.850000', '0.850005', '0.850010']
    >>> PlainNumbers().format_ticks([0, 2e-6, 4e-6])
    ['0', '2e−6', '4e−6']
    >>> PlainNumbers().format_ticks([-5, 0, 5])
    ['−5', '0', '5']
    """

    def __init__(self) -> None:
        self._ticks: list[float] = []

    def set_locs(self, locs: Iterable[float]) -> None:
        """Take all ticks of the axis."""
        self._ticks = [float(one) for one in locs]

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Write one tick as the others are written."""
        del pos
        return self._written(float(x), self._ticks)

    def format_data_short(self, value: float) -> str:
        """Write the number under the pointer."""
        return f"{value:.6g}"

    @staticmethod
    def _written(x: float, ticks: list[float]) -> str:
        steps = [abs(b - a) for a, b in pairwise(ticks) if b != a]
        step = min(steps, default=abs(x) or 1.0)
        largest = max([abs(x), *map(abs, ticks)])
        if abs(x) < 1e-9 * step:
            x = 0.0
        if largest == 0.0 or _PLAIN[0] <= largest < _PLAIN[1]:
            text = f"{x:.{_decimals(ticks or [x], step)}f}"
        elif x == 0.0:
            text = "0"
        else:
            digits = max(0, math.floor(math.log10(largest)) - math.floor(math.log10(step)) + 1)
            number, _, power = f"{x:.{min(digits, _MOST)}e}".partition("e")
            number = number.rstrip("0").rstrip(".") if "." in number else number
            text = f"{number}e{int(power)}"
        return text.replace("-", "−")


def _decimals(ticks: list[float], step: float) -> int:
    """Return the decimals that write all ticks to a thousandth of their step, at least."""
    for count in range(_MOST):
        if all(abs(round(tick, count) - tick) < 1e-3 * step for tick in ticks):
            return count
    return _MOST


def log_axis(axis: Axis, most: int = _MANY) -> None:
    """Give a logarithmic axis as many ticks as its span asks for, about `most`, in plain numbers.

    Labels of whole powers alone would leave a narrow axis without one, and those of every digit
    run into each other.
    """
    low, high = sorted(axis.get_view_interval())
    for digits in ((1,), (1, 3), (1, 2, 5), range(1, 10)):
        powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        every = [float(f"{d}e{p}") for p in powers for d in digits]
        ticks = [tick for tick in every if low <= tick <= high]
        if len(ticks) >= _FEW:
            break
    many = len(ticks) // most + 1
    axis.set_major_locator(FixedLocator(ticks[::many]) if len(ticks) > 1 else MaxNLocator(_FEW))
    axis.set_major_formatter(lambda x, _: f"{x:g}".replace("e-0", "e−").replace("e-", "e−"))
    axis.set_minor_locator(NullLocator())


def plain_axis(axis: Axis) -> None:
    """Give an axis plain numbers, if it has those that matplotlib gives by default."""
    if type(axis.get_major_formatter()) is ScalarFormatter:
        axis.set_major_formatter(PlainNumbers())


def plain_numbers(ax: Axes) -> None:
    """Give both axes plain numbers, if they have those that matplotlib gives by default."""
    for axis in (ax.xaxis, ax.yaxis):
        plain_axis(axis)
