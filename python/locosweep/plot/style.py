"""Style of all pictures: words, units, colours, hatches and lines."""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.colors import BoundaryNorm, CenteredNorm, Colormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from locosweep.errors import InputError
from locosweep.plot.numbers import plain_numbers
from locosweep.registry import parameter, words_of_name

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from locosweep.result import Output

SEQUENTIAL = "viridis"
DIVERGING = "RdBu_r"
NO_VALUE = "0.87"
"""Grey behind the hatches."""

HATCHES = (
    *("////", "\\\\\\\\", "xxxx", "....", "ooo", "++++"),
    *("----", "||||", "OO", "//", "//..", "\\\\oo", "||..."),
    *("\\\\--", "xx..", "++OO", "--oo", "oo//", "||//", "++..", "OO--"),
    *("\\\\..", "xxoo", "||OO", "////--", "++oo"),
)
"""One per status after ok, the same one in every picture."""

LINES: tuple[tuple[str, str | tuple[int, tuple[int, ...]], str], ...] = (
    ("#0072b2", "-", "o"),
    ("#d55e00", "--", "s"),
    ("#009e73", "-.", "^"),
    ("#cc79a7", ":", "D"),
    ("#000000", (0, (5, 1)), "v"),
    ("#e69f00", (0, (3, 1, 1, 1)), "P"),
    ("#56b4e9", (0, (1, 1)), "X"),
    ("#7f7f7f", (0, (7, 3)), "<"),
)
"""Colour (Okabe and Ito), dash and marker of each line: any one tells them apart."""

_MOST_CLASSES = 12
_NICE = (1, 2, 3, 4, 5, 6, 8, 10, 15, 20, 30, 50)


def figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in inches, which shares no state with pyplot."""
    return Figure(figsize=(width, height), layout="constrained")


def grid(ax: Axes) -> None:
    """Draw faint grid lines, and write the numbers of axes in full."""
    plain_numbers(ax)
    ax.grid(visible=True, linewidth=0.4, alpha=0.5)


def zero_line(ax: Axes) -> None:
    """Draw the zero of the ordinate behind everything else."""
    ax.axhline(0.0, color="0.75", linewidth=0.8, zorder=0)


def hatch(code: int) -> str:
    """Hatch of a status that is not ok."""
    return HATCHES[(code - 1) % len(HATCHES)]


def escaped(text: str) -> str:
    """Make text from outside fit to be drawn: printable, never taken for a formula."""
    return "".join(c if c.isprintable() else "□" for c in text).replace("$", r"\$")


def wrapped(text: str) -> str:
    """Break a long entry of a legend into lines."""
    return textwrap.fill(text, 76)


def unit_text(unit: str) -> str:
    """Return a unit of the registry with raised exponents; nothing for 1."""
    return "" if unit == "1" else unit.replace("^2", "²").replace("^3", "³")


def with_unit(value: float, unit: str) -> str:
    """Return a number for people, with its unit."""
    number = "∞" if value == np.inf else f"{value:.4g}".replace("-", "−")
    return f"{number} {unit_text(unit)}".rstrip()


def setting(name: str, value: float) -> str:
    """Return a parameter and its value: symbol, number, unit."""
    record = parameter(name)
    # Counts in full: one segment more is another robot.
    count = f"{value:.0f}" if record.integer and np.isfinite(value) else ""
    return f"${record.symbol}$ = {count or with_unit(value, record.unit)}"


def simulated(how: Mapping[str, str]) -> str:
    """Law and drive, or gait, of what was simulated, else nothing."""
    return ", ".join(f"{name} {how[name]}" for name in ("law", "drive", "gait") if name in how)


_ROOM = 3, 52
"""Characters of words beside an axis: a name of less says nothing, and more than stand along the
shorter side of a picture at its least."""


def words_of(name: str) -> str:
    """Words of a parameter: the beginning of its meaning, or its name."""
    words = re.split(r"[,:;(]", parameter(name).meaning)[0].strip()
    if not _ROOM[0] <= len(words) <= _ROOM[1]:
        words = words_of_name(name)
    return words


def axis_label(name: str) -> str:
    """Words, symbol and unit of a parameter."""
    record = parameter(name)
    return _label(words_of(name), record.symbol, record.unit)


def output_label(output: Output) -> str:
    """Words, symbol and unit of an output."""
    return _label(output.label, output.symbol, output.unit)


def _label(words: str, symbol: str, unit: str) -> str:
    text = f"{words} ${symbol}$"
    return f"{text} [{unit_text(unit)}]" if unit_text(unit) else text


@dataclass(frozen=True)
class Colours:
    """Norm and map, and for whole numbers where the colour bar is labelled."""

    norm: Normalize
    cmap: Colormap
    ticks: tuple[float, ...] = ()
    names: tuple[str, ...] = ()


def colours(
    values: NDArray[np.float64],
    *,
    integer: bool,
    norm: Normalize | str | None = None,
    cmap: Colormap | str | None = None,
) -> Colours:
    """Choose colours for finite values: classes, one-signed or around zero."""
    signed = bool(values.size) and both_signs(float(values.min()), float(values.max()))
    picked = _cmap(cmap or (DIVERGING if signed and norm is None else SEQUENTIAL))
    picked = picked.with_extremes(bad=NO_VALUE)
    if norm is not None:
        return Colours(_norm(norm, values), picked)
    if integer and values.size:
        bounds, names = _classes(np.unique(values))
        middle = (bounds[:-1] + bounds[1:]) / 2
        spread = picked.resampled(max(len(names), 2)).with_extremes(bad=NO_VALUE)
        return Colours(BoundaryNorm(bounds.tolist(), spread.N), spread, tuple(middle), tuple(names))
    if signed:
        return Colours(CenteredNorm(0.0, float(np.abs(values).max())), picked)
    return Colours(_norm("linear", values), picked)


def both_signs(low: float, high: float) -> bool:
    """Return whether zero becomes the middle of the colours: not for a trace of one sign."""
    return low < 0 < high and min(-low, high) > 0.01 * max(-low, high)


def _cmap(cmap: Colormap | str) -> Colormap:
    if isinstance(cmap, Colormap):
        return cmap
    if cmap not in mpl.colormaps:
        raise InputError(f"cmap is {cmap!r}: allowed is a name from matplotlib.colormaps")
    return mpl.colormaps[cmap]


def _norm(norm: Normalize | str, values: NDArray[np.float64]) -> Normalize:
    if isinstance(norm, Normalize):
        return norm
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 1.0)
    if norm == "linear":
        return Normalize(low, high)
    if norm == "log":
        if values.size and low <= 0:
            raise InputError(f"norm is 'log', but values go down to {low:g}: use 'linear'")
        return LogNorm(low or 0.1, high)
    raise InputError(f"norm is {norm!r}: allowed are 'linear', 'log' or a matplotlib norm")


def _classes(distinct: NDArray[np.float64]) -> tuple[NDArray[np.float64], list[str]]:
    """Bounds and names of classes of whole numbers: one each, or sensible groups."""
    low, high = float(distinct[0]), float(distinct[-1])
    if high - low < _MOST_CLASSES:
        starts = np.arange(low, high + 1)
    elif len(distinct) <= _MOST_CLASSES:
        middle = (distinct[:-1] + distinct[1:]) / 2
        bounds = np.concatenate([[low - 0.5], middle, [high + 0.5]])
        return bounds, [f"{value:.0f}" for value in distinct]
    else:
        starts = _starts(low, high)
    bounds = np.append(starts, high + 1) - 0.5
    lasts = bounds[1:] - 0.5
    pairs = zip(starts, lasts, strict=True)
    return bounds, [f"{a:.0f}" if a == b else f"{a:.0f}–{b:.0f}" for a, b in pairs]


def _starts(low: float, high: float) -> NDArray[np.float64]:
    """First number of each class, the lowest value first."""
    choices: list[Sequence[float]] = []
    if low > 0:
        powers = 10.0 ** np.arange(2, max(3.0, np.floor(np.log10(high)) + 1))
        choices = [
            [*_NICE, *(float(p * f) for p in powers for f in (1, 2, 3, 5))],
            [*_NICE, *powers],
            [1, 2, 3, 4, 6, 10, 20, 50, *powers],
            [1, 10, *powers],
        ]
    even = MaxNLocator(_MOST_CLASSES - 2, integer=True).tick_values(low, high)
    for choice in [*choices, even]:
        inner = [value for value in choice if low < value <= high]
        if 5 <= len(inner) < _MOST_CLASSES + 2:
            return np.array([low, *inner])
    return np.array([low, *(value for value in even if low < value <= high)])
