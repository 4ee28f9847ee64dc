"""Pictures of a result: heat maps and curves, with units and named gaps."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from locosweep.errors import InputError
from locosweep.grid import few, index_of
from locosweep.plot import cells, style
from locosweep.plot.caption import better_when_larger, fixed_settings, how_of, reason, title
from locosweep.plot.current import current_axes
from locosweep.plot.legends import dress
from locosweep.registry import Status, parameter, unknown

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap, Normalize
    from numpy.typing import NDArray

    from locosweep.result import Output, Result

    Floats = NDArray[np.float64]

_RASTER_FROM = 10_000
"""Cells from which a heat map is stored as an image inside SVG and PDF."""
_SEAM = 0.3
"""Points that a cell reaches over its neighbours: less than a dot of a screen."""
_MOST_CELLS = 600
"""Cells along an axis that a heat map draws: a picture has no more dots, and each takes memory."""


class Plotter:
    r"""Pictures of one result; ``Result.plot`` makes it.

    Every method draws into `ax`, else into pyplot's current axes while they are empty, else
    into a new figure of pyplot, and returns the axes: a notebook shows them below the cell, a
    script at ``plt.show()``. ``ax.figure.savefig("map.png")`` saves them, and
    ``locosweep.plot.save_figure`` does with their origin in the file. With `ax`, pyplot is
    not loaded, which threads and programs without a display want.

    Examples
    --------
    >>> import locosweep as ls
    >>> r = ls.sweep("mean_velocity", mu_static=0.5, mu_coulomb=0.3,
    ...              slope_deg=[0, 10, 20, 30], segments=range(2, 9))
    >>> ax = r.plot.heatmap()
    >>> ax.get_xlabel(), ax.get_ylabel()
    ('number of segments of the robot $N$', 'slope of the ground $\\alpha$ [deg]')
    """

    def __init__(self, result: Result) -> None:
        self.result = result

    def heatmap(
        self,
        x: str | None = None,
        y: str | None = None,
        value: str | None = None,
        *,
        ax: Axes | None = None,
        norm: Normalize | str | None = None,
        cmap: Colormap | str | None = None,
        levels: int | Sequence[float] | None = None,
        mark_optimum: bool | None = None,
        note: str = "",
        **at: float,
    ) -> Axes:
        r"""Draw an output over two axes; cells without a value are hatched and named.

        Of an axis that is longer than a picture is wide in dots, evenly chosen cells are
        drawn; colours and the marked optimum are those of all cells.

        Parameters
        ----------
        x, y : str, optional
            Axes of the result; default the last and the one before it, of those
            that `at` does not fix.
        value : str, optional
            Output; default the first.
        ax : Axes, optional
            Where to draw; default the current axes of pyplot while they are empty.
        norm : {"linear", "log"} or Normalize, optional
            Default: classes for whole numbers, else linear, around zero where
            both signs occur.
        cmap : str or Colormap, optional
            Default viridis, or RdBu_r where both signs occur.
        levels : int or sequence of float, optional
            How many contours, or which; 0 for none. Default about seven. Whole numbers
            have none unless told which.
        mark_optimum : bool, optional
            Mark the highest value, never of whole numbers. Default: where more is better, so
            not of times, losses and costs.
        note : str
            A line below what is fixed, for instance the name of a robot.
        **at
            Value of every other axis, as it stands in the axis.

        Returns
        -------
        Axes

        Raises
        ------
        InputError
            An unknown or missing axis, output or axis value.

        Examples
        --------
        >>> import locosweep as ls
        >>> r = ls.sweep("best_segments", mu_static=[0.3, 0.4, 0.5], mu_coulomb=[0.2, 0.3],
        ...              slope_deg=[0, 10, 20])
        >>> ax = r.plot.heatmap("slope_deg", "mu_static", mu_coulomb=0.3)
        >>> print(ax.get_title())
        $\mu_C$ = 0.3
        fixed: $m$ = 0.271 kg, $g$ = 9.81 m/s², $\delta$ = 0.02 m
        """
        output = self.result.output(value)
        x, y = two(self.result.axes, x, y, at)
        index, words = cut(self.result.axes, (y, x), at)
        flip = list(self.result.axes).index(x) < list(self.result.axes).index(y)
        values, codes = self._slice(output, index)
        if flip:
            values, codes = values.T, codes.T
        (xs, columns), (ys, rows) = (_centres(name, self.result.axes[name]) for name in (x, y))
        best = _highest(values, rows, columns)
        peak = None if best is None else ((x, float(xs[best[1]])), (y, float(ys[best[0]])))
        extremes = [float(fold.reduce(values, axis=None)) for fold in (np.fmin, np.fmax)]
        (xs, columns), (ys, rows) = drawn(xs, columns), drawn(ys, rows)
        values, codes = values[np.ix_(rows, columns)], codes[np.ix_(rows, columns)]

        ax = current_axes(ax, 6.8, 5.0)
        works = np.isfinite(values)
        finite = values[works]
        if finite.size:
            # Cells that are not drawn count for the colours all the same.
            finite = np.append(finite, extremes)
        shown = style.colours(finite, integer=output.integer, norm=norm, cmap=cmap)
        x_edges, y_edges = (cells.edges(n, c) for n, c in ((x, xs), (y, ys)))
        raster = values.size >= _RASTER_FROM
        mesh = ax.pcolormesh(
            x_edges,
            y_edges,
            np.ma.masked_array(values, ~works),
            norm=shown.norm,
            cmap=shown.cmap,
            rasterized=raster,
            # Without an edge of its colour, each cell has a seam in SVG and PDF; an image has none.
            edgecolors="none" if raster else "face",
            linewidth=_SEAM,
        )
        handles: list[Line2D | Patch] = []
        if finite.size:
            cells.colour_bar(ax, mesh, finite, shown, output)
            cells.contours(ax, xs, ys, values, levels, shown.norm, output)
        if mark_optimum is None:
            mark_optimum = better_when_larger(output)
        if mark_optimum and peak is not None and not output.integer:
            where = ", ".join(style.setting(name, at_) for name, at_ in peak)
            label = f"highest: {style.with_unit(extremes[1], output.unit)} at {where}"
            star = ax.plot(peak[0][1], peak[1][1], "*", ls="none", label=label)[0]
            star.set(markersize=14, markerfacecolor="white", markeredgecolor="black", clip_on=False)
            # Above the labels of contours.
            star.set_zorder(6)
            cells.keep_inside(star, (x_edges[0], x_edges[-1]), (y_edges[0], y_edges[-1]))
            handles.append(star)
        handles += cells.hatch_cells(ax, codes, x_edges, y_edges, partial(reason, self.result))
        fixed = fixed_settings(self.result, output, self.result.axes)
        dress(
            ax, title([style.simulated(how_of(self.result, output)), *words], fixed, note), handles
        )
        cells.name_axis(ax.xaxis, x, xs)
        cells.name_axis(ax.yaxis, y, ys)
        return ax

    def curves(
        self,
        x: str,
        *,
        value: str | None = None,
        by: str | None = None,
        ax: Axes | None = None,
        mark_optimum: bool | None = None,
        note: str = "",
        **at: float | Sequence[float],
    ) -> Axes:
        r"""Draw an output over one axis, one line for each value of another.

        Parameters
        ----------
        x : str
            Axis of the result.
        value : str, optional
            Output; default the first.
        by : str, optional
            Axis with one line for each value, at most eight; give some of its
            values as a sequence, by name, to draw only those.
        ax : Axes, optional
            Where to draw; default the current axes of pyplot while they are empty.
        mark_optimum : bool, optional
            Mark the highest value of each line; default as for `heatmap`.
        note : str
            As for `heatmap`.
        **at
            Value of every other axis, as it stands in the axis.

        Returns
        -------
        Axes

        Raises
        ------
        InputError
            An unknown or missing axis, output or axis value, or too many lines.

        Examples
        --------
        >>> import locosweep as ls
        >>> r = ls.sweep("mean_velocity", mu_static=0.5, mu_coulomb=0.3,
        ...              slope_deg=[0, 10, 20, 30], segments=range(2, 9))
        >>> ax = r.plot.curves("segments", by="slope_deg", slope_deg=[0, 10])
        >>> ax.get_ylabel()
        'mean velocity $\\bar v$ [m/s]'
        """
        output = self.result.output(value)
        check_axis(self.result.axes, x)
        lines: list[tuple[dict[str, float | Sequence[float]], str]] = [({}, "")]
        if by is not None:
            check_axis(self.result.axes, by)
            if by == x:
                raise InputError(f"by is {by}: that axis is already x")
            lines = [
                ({by: wanted}, style.setting(by, wanted))
                for wanted in self._lines(by, at.pop(by, None))
            ]
        ax = current_axes(ax, 6.8, 5.0)
        xs, order = _centres(x, self.result.axes[x])
        whole_x = parameter(x).integer
        seen: set[int] = set()
        handles: list[Line2D | Patch] = []
        words: list[str] = []
        if mark_optimum is None:
            mark_optimum = better_when_larger(output)
        for (extra, label), (colour, dash, marker) in zip(lines, style.LINES, strict=False):
            index, words = cut(self.result.axes, (x,), {**at, **extra}, hide=by)
            values, codes = self._slice(output, index)
            values, codes = values[order], codes[order]
            seen |= set(np.unique(codes).tolist())
            line = ax.plot(
                xs,
                values,
                color=colour,
                linestyle=dash,
                linewidth=0.8 if whole_x else 1.6,
                marker=marker if whole_x or len(xs) == 1 else "",
                markersize=4.5,
                drawstyle="steps-mid" if output.integer and not whole_x else "default",
                label=label or output.label,
            )
            alone = np.pad(np.isfinite(values), 1)
            alone = alone[1:-1] & ~alone[:-2] & ~alone[2:]
            if alone.any() and not (whole_x or len(xs) == 1):
                # A value between two gaps has no line.
                ax.plot(xs[alone], values[alone], ls="none", marker=marker, ms=4.5, color=colour)
                # The gaps beside it are to be seen as well.
                ax.update_datalim([(x_end, values[alone][0]) for x_end in (xs[0], xs[-1])])
                ax.autoscale_view()
            if by is not None:
                if not np.isfinite(values).any():
                    line[0].set_label(f"{label}: no value")
                handles += line
            if mark_optimum and not output.integer and np.isfinite(values).any():
                best = int(np.nanargmax(values))
                ax.plot(xs[best], values[best], "*", ms=13, mfc=colour, mec="black", ls="none")
        if mark_optimum and not output.integer and seen & {0}:
            star = Line2D([], [], marker="*", linestyle="none", label="highest")
            star.set(markersize=13, markerfacecolor="white", markeredgecolor="black")
            handles.append(star)
        gaps = [
            Line2D(
                [], [], ls="none", label=style.wrapped(f"gap: {reason(self.result, Status(code))}")
            )
            for code in sorted(seen - {0})
        ]
        fixed = fixed_settings(self.result, output, self.result.axes)
        dress(
            ax,
            title([style.simulated(how_of(self.result, output)), *words], fixed, note),
            gaps,
            handles,
        )
        cells.name_axis(ax.xaxis, x, xs)
        ax.set_ylabel(style.output_label(output))
        if output.integer:
            ax.yaxis.set_major_locator(MaxNLocator(integer=True))
        style.grid(ax)
        return ax

    def _lines(self, by: str, wanted: float | Sequence[float] | None) -> list[float]:
        axis = self.result.axes[by]
        some = axis if wanted is None else np.atleast_1d(np.asarray(wanted, dtype=object))
        indices = [index_of(by, axis, value) for value in some]
        if not 1 <= len(indices) <= len(style.LINES):
            most = len(style.LINES)
            raise InputError(
                f"{by} would give {len(indices)} lines: allowed are 1 to {most}, "
                f"choose some with {by}=[...]"
            )
        return [float(axis[index]) for index in indices]

    def _slice(
        self, output: Output, index: tuple[int | slice, ...]
    ) -> tuple[Floats, NDArray[np.uint8]]:
        values = np.asarray(self.result[output.name][index], np.float64)
        if np.isfinite(values).all():
            return values, np.zeros(values.shape, np.uint8)
        return values, self.result.status_of(output.name)[index]


def _centres(name: str, axis: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Axis values in rising order, and which they were."""
    if not np.isfinite(axis).all():
        raise InputError(f"{name} has infinite values: along an axis of a picture allowed are none")
    return np.unique(axis, return_index=True)


def drawn(centres: Floats, order: NDArray[np.intp]) -> tuple[Floats, NDArray[np.intp]]:
    """Choose the cells along an axis that are drawn: all, or evenly some with both ends."""
    if len(centres) <= _MOST_CELLS:
        return centres, order
    chosen = np.linspace(0, len(centres) - 1, _MOST_CELLS).round().astype(np.intp)
    return centres[chosen], order[chosen]


def _highest(
    values: Floats, rows: NDArray[np.intp], columns: NDArray[np.intp]
) -> tuple[int, int] | None:
    """Row and column, in rising order of the axes, of the highest value; no copy of all."""
    tops = np.fmax.reduce(values, axis=1)[rows]
    if not np.isfinite(tops).any():
        return None
    row = int(np.nanargmax(tops))
    return row, int(np.nanargmax(values[rows[row]][columns]))


def check_axis(axes: Mapping[str, Floats], name: str) -> None:
    """Refuse a name that is no axis."""
    if name not in axes:
        raise unknown("axis", str(name), axes)


def two(
    axes: Mapping[str, Floats], x: str | None, y: str | None, at: Mapping[str, object]
) -> tuple[str, str]:
    """Return both axes of a heat map, the defaults filled in."""
    for name in (x, y):
        if name is not None:
            check_axis(axes, name)
    free = [name for name in axes if name not in (x, y, *at)]
    if len(free) < (x is None) + (y is None):
        names = ", ".join(axes) or "none"
        raise InputError(f"a heat map needs two axes that are not fixed: the axes are {names}")
    x = free.pop() if x is None else x
    y = free.pop() if y is None else y
    if x == y:
        raise InputError(f"x and y are both {x}: a heat map needs two axes")
    return x, y


def cut(
    axes: Mapping[str, Floats],
    keep: tuple[str, ...],
    at: Mapping[str, object],
    hide: str | None = None,
) -> tuple[tuple[int | slice, ...], list[str]]:
    """Return the index of a slice along `keep`, and what it is cut at, for the title."""
    for name in at:
        check_axis(axes, name)
        if name in keep:
            raise InputError(f"{name} is given, but it is an axis of the picture")
    missing = [n for n, a in axes.items() if n not in keep and n not in at and len(a) > 1]
    if missing:
        text = ", ".join(f"{name}={few(axes[name], 3)}" for name in missing)
        raise InputError(f"these axes need one value each: {text}")
    index: list[int | slice] = []
    words = []
    for name, axis in axes.items():
        if name in keep:
            index.append(slice(None))
            continue
        at_index = index_of(name, axis, at[name]) if name in at else 0
        index.append(at_index)
        if name != hide:
            words.append(style.setting(name, float(axis[at_index])))
    return tuple(index), words
