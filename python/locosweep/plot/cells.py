"""Cells of a heat map: edges, contours, and hatches where there is no value."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator, MaxNLocator
from matplotlib.transforms import offset_copy

from locosweep.errors import InputError
from locosweep.plot import style
from locosweep.plot.numbers import PlainNumbers, plain_axis
from locosweep.registry import Status, parameter

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.collections import QuadMesh
    from matplotlib.colors import Normalize
    from matplotlib.contour import QuadContourSet
    from matplotlib.lines import Line2D
    from numpy.typing import NDArray

    from locosweep.result import Output

    Floats = NDArray[np.float64]

_INK = "0.35"
_ROUNDING = 1e-9
"""Share of the largest value below which differences are rounding errors, with room above those of
thousands of operations on 64 bits."""
_PLAIN = 0.02
"""Share of the cells from which equal values are a plain: a line crosses fewer."""
_MOST_LEVELS = 100
"""Contours that can be told apart in a picture of 600 dots."""
_RIM = 0.03
"""Share of an axis at whose ends half a mark would stand outside."""


def edges(name: str, centres: Floats) -> Floats:
    """Edges of the cells around rising centres; one alone gets some width."""
    if len(centres) == 1:
        half = 0.5 if parameter(name).integer else 0.05 * abs(float(centres[0])) or 0.5
        return np.array([centres[0] - half, centres[0] + half])
    middle = (centres[:-1] + centres[1:]) / 2
    first, last = 2 * centres[0] - middle[0], 2 * centres[-1] - middle[-1]
    return np.concatenate([[first], middle, [last]])


def name_axis(axis: Axis, name: str, values: Floats) -> None:
    """Label an axis with words and unit of a parameter, with whole ticks where it counts."""
    axis.set_label_text(style.axis_label(name))
    if len(values) == 1:
        axis.set_ticks(values.tolist())
    elif parameter(name).integer:
        axis.set_major_locator(MaxNLocator(integer=True))
    plain_axis(axis)


def colour_bar(
    ax: Axes, mesh: QuadMesh, finite: Floats, shown: style.Colours, output: Output
) -> None:
    """Add the colour bar, labelled at the classes of whole numbers."""
    norm = shown.norm
    below = norm.vmin is not None and finite.min() < norm.vmin
    above = norm.vmax is not None and finite.max() > norm.vmax
    extend = {(True, True): "both", (True, False): "min", (False, True): "max"}
    bar = ax.figure.colorbar(
        mesh,
        ax=ax,
        label=style.output_label(output),
        extend=extend.get((below, above), "neither"),
        ticks=LogLocator(subs=(1, 2, 5)) if isinstance(norm, LogNorm) else None,
        format="{x:g}" if isinstance(norm, LogNorm) else PlainNumbers(),
    )
    if isinstance(norm, LogNorm):
        bar.ax.minorticks_off()
    if shown.ticks:
        bar.set_ticks(list(shown.ticks), labels=list(shown.names))
        bar.ax.minorticks_off()


def keep_inside(mark: Line2D, x: tuple[float, float], y: tuple[float, float]) -> None:
    """Draw a mark at the edge of the axes half of its size further in, off the tick labels.

    Its place in the data stays; `x` and `y` are the ends of the axes.
    """
    place = zip((x, y), (mark.get_xdata(), mark.get_ydata()), strict=True)
    shares = [(float(np.ravel(at)[0]) - low) / (high - low) for (low, high), at in place]
    half = 0.5 * float(mark.get_markersize())
    right, up = (half * ((share < _RIM) * 1 - (share > 1.0 - _RIM) * 1) for share in shares)
    ax, figure = mark.axes, mark.get_figure(root=True)
    if ax is not None and figure is not None and (right or up):
        mark.set_transform(offset_copy(ax.transData, figure, x=right, y=up, units="points"))


def contours(
    ax: Axes,
    xs: Floats,
    ys: Floats,
    values: Floats,
    levels: int | Sequence[float] | None,
    norm: Normalize,
    output: Output,
) -> None:
    """Draw labelled contours inside the range of the values, none of rounding errors."""
    counted = levels is None or isinstance(levels, int | np.integer)
    _check_levels(levels)
    if min(values.shape) < 2 or (counted and output.integer):
        return
    logarithmic = isinstance(norm, LogNorm)
    if logarithmic:
        values = np.where(values > 0.0, values, np.nan)
        if not np.isfinite(values).any():
            return
    largest = float(np.nanmax(np.abs(values)))
    if not logarithmic:
        values = np.where(np.abs(values) < _ROUNDING * largest, 0.0, values)
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if high - low <= _ROUNDING * largest:
        return
    if isinstance(levels, int | np.integer) or levels is None:
        count = 7 if levels is None else int(levels)
        if count == 0:
            return
        locator = LogLocator(subs=(1, 2, 5)) if logarithmic else MaxNLocator(count)
        levels = list(locator.tick_values(low, high))
    inner = sorted({float(level) for level in levels if low < level < high})
    if counted:
        # A plain at a level has no line of that level, only the edge of its rounding errors.
        inner = [level for level in inner if not _is_plain(values, level, largest)]
    if not inner:
        return
    masked = np.ma.masked_invalid(values)
    lines = ax.contour(xs, ys, masked, levels=inner, colors="black", linewidths=0.7)
    texts = ax.clabel(
        lines,
        manual=_label_places(lines),
        fontsize=8,
        inline=False,
        use_clabeltext=True,
        fmt={level: style.with_unit(level, output.unit) for level in inner},
    )
    for text in texts or ():
        text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])


def _check_levels(levels: object) -> None:
    """Refuse what is neither a count that a picture has room for, nor numbers."""
    if levels is None:
        return
    if isinstance(levels, int | np.integer) and not isinstance(levels, bool):
        if not 0 <= levels <= _MOST_LEVELS:
            raise InputError(f"levels is {levels}: allowed is a count from 0 to {_MOST_LEVELS}")
        return
    try:
        given = np.asarray(levels, np.float64)
    except (TypeError, ValueError):
        given = np.empty(())
    if isinstance(levels, str | bool) or np.ndim(given) != 1 or not np.isfinite(given).all():
        raise InputError(f"levels is {levels!r}: allowed is a count, or several finite numbers")


def _is_plain(values: Floats, level: float, largest: float) -> bool:
    """Return whether many cells have the value of a level."""
    near = np.abs(values - level) <= _ROUNDING * largest
    return bool(near.sum() > _PLAIN * np.isfinite(values).sum())


def _label_places(lines: QuadContourSet) -> list[tuple[float, float]]:
    """Middle of each contour: away from the edges, which would cut the label."""
    paths = [np.asarray(path.vertices, np.float64) for path in lines.get_paths()]
    middles = [vertices[len(vertices) // 2] for vertices in paths if len(vertices)]
    return [(float(x), float(y)) for x, y in middles]


def hatch_cells(
    ax: Axes,
    codes: NDArray[np.uint8],
    x_edges: Floats,
    y_edges: Floats,
    reason: Callable[[Status], str],
) -> list[Patch]:
    """Hatch the cells of each status, and return the entries for the legend, with the reason."""
    entries: list[Patch] = []
    for code in np.unique(codes[codes > 0]).tolist():
        area = PathPatch(_runs(codes == code, x_edges, y_edges), facecolor="none")
        entry = Patch(facecolor=style.NO_VALUE, label=style.wrapped(reason(Status(code))))
        for patch in (area, entry):
            patch.set(hatch=style.hatch(code), edgecolor=_INK, linewidth=0.0)
        ax.add_patch(area)
        entries.append(entry)
    return entries


def _runs(cells: NDArray[np.bool_], x_edges: Floats, y_edges: Floats) -> Path:
    """One path around all cells, a rectangle for each run within a row."""
    padded = np.pad(cells.astype(np.int8), ((0, 0), (1, 1)))
    change = np.diff(padded, axis=1)
    rows, first = np.nonzero(change == 1)
    last = np.nonzero(change == -1)[1]
    left, right = x_edges[first], x_edges[last]
    low, high = y_edges[rows], y_edges[rows + 1]
    corners = [(left, low), (right, low), (right, high), (left, high), (left, low)]
    points = np.stack([np.stack(corner, axis=-1) for corner in corners], axis=1)
    codes = np.tile([Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY], len(rows))
    return Path(points.reshape(-1, 2), codes)
