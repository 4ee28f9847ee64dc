"""Results in a notebook: a few lines of text beside a small picture."""

from __future__ import annotations

import base64
import io
from html import escape
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from locosweep.plot import cells, style
from locosweep.plot.gait import space_time
from locosweep.plot.trajectories import motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from locosweep.result import Result
    from locosweep.simulation.gait import GaitRun
    from locosweep.simulation.trajectories import Trajectories

    Floats = NDArray[np.float64]

_DPI = 80
"""Dots per inch: a picture of about 25 kB, as each stays in the notebook's file."""
_SIZE = (4.6, 3.2)
"""Inches of a small picture."""
_MOST = 150
"""Cells along an axis of a small picture, which has no more than twice as many dots."""


def card(text: str, picture: Figure | None = None, caption: str = "") -> str:
    """Return HTML: the lines of a text, and a picture with its caption.

    Examples
    --------
    >>> from locosweep.plot.html import card
    >>> card("2 runs & a model")
    '<div><pre style="white-space:pre-wrap">2 runs &amp; a model</pre></div>'
    """
    shown = f'<pre style="white-space:pre-wrap">{escape(text)}</pre>'
    if picture is None:
        return f"<div>{shown}</div>"
    image = picture_of(picture, text.partition("\n")[0])
    below = f"<br><small>{escape(caption)}</small>" if caption else ""
    return f"<div>{shown}{image}{below}</div>"


def picture_of(picture: Figure, words: str) -> str:
    """Return the element of a small picture, with words for those who do not see it."""
    file = io.BytesIO()
    picture.savefig(file, format="png", dpi=_DPI)
    data = base64.b64encode(file.getvalue()).decode()
    alt = escape(words, quote=True)
    return f'<img style="max-width:100%" alt="{alt}" src="data:image/png;base64,{data}">'


def result_card(result: Result) -> str:
    """Describe a sweep: its text, and its first output over its last two axes."""
    names = [name for name, axis in result.axes.items() if len(axis) > 1][-2:]
    if not names or not all(np.isfinite(result.axes[name]).all() for name in names):
        return card(repr(result))
    index: list[object] = []
    words = []
    for name, axis in result.axes.items():
        if name in names:
            index.append(np.unique(np.linspace(0, len(axis) - 1, _MOST).round().astype(int)))
        else:
            index.append([len(axis) // 2])
            words.append(f"{name} = {axis[len(axis) // 2]:g}")
    grid = [result.axes[n][np.asarray(at)] for n, at in zip(result.axes, index, strict=True)]
    kept = [axis for axis, name in zip(grid, result.axes, strict=True) if name in names]
    values = np.asarray(result.values[np.ix_(*index)], np.float64)
    values = values.reshape([len(axis) for axis in kept])
    figure = style.figure(*_SIZE)
    ax = figure.subplots()
    (_line if len(names) == 1 else _map)(ax, result, names, kept, values)
    ax.tick_params(labelsize=8)
    ax.xaxis.label.set_fontsize(8)
    ax.yaxis.label.set_fontsize(8)
    caption = f"{result.outputs[0].label}" + (f" at {', '.join(words)}" if words else "")
    grey = " (grey: no value)" if not np.isfinite(values).all() and len(names) == 2 else ""
    return card(repr(result), figure, caption + grey)


def _line(ax: Axes, result: Result, names: list[str], axes: list[Floats], values: Floats) -> None:
    order = np.argsort(axes[0])
    colour, _, marker = style.LINES[0]
    ax.plot(axes[0][order], values[order], color=colour, marker=marker, markersize=3)
    cells.name_axis(ax.xaxis, names[0], axes[0])
    ax.set_ylabel(style.output_label(result.outputs[0]))
    style.grid(ax)


def _map(ax: Axes, result: Result, names: list[str], axes: list[Floats], values: Floats) -> None:
    (ys, rows), (xs, columns) = (np.unique(axis, return_index=True) for axis in axes)
    values = values[np.ix_(rows, columns)]
    works = np.isfinite(values)
    output = result.outputs[0]
    shown = style.colours(values[works], integer=output.integer)
    mesh = ax.pcolormesh(
        cells.edges(names[1], xs), cells.edges(names[0], ys),
        np.ma.masked_array(values, ~works), norm=shown.norm, cmap=shown.cmap,
    )  # fmt: skip
    ax.set_facecolor(style.NO_VALUE)
    if works.any():
        cells.colour_bar(ax, mesh, values[works], shown, output)
    cells.name_axis(ax.xaxis, names[1], xs)
    cells.name_axis(ax.yaxis, names[0], ys)


def trajectories_card(run: Trajectories) -> str:
    """Describe trajectories: their text, and the motion of one to eight of them."""
    if not 1 <= prod(run.x.shape[:-1]) <= len(style.LINES):
        return card(repr(run))
    figure = style.figure(6.0, 5.0)
    motion(run, axes=figure.subplots(3, 1, sharex=True))
    return card(repr(run), figure)


def gait_card(run: GaitRun) -> str:
    """Describe a robot's run: its text, and where each segment is over time."""
    figure = style.figure(7.0, 3.6)
    space_time(run, figure.subplots())
    return card(repr(run), figure)
