"""Pictures of where the gap lies: in time, channel, kind of motion, velocity, position."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.patches import Patch, Rectangle
from matplotlib.patheffects import withStroke

from locosweep.diagnosis.data.regimes import REGIMES
from locosweep.diagnosis.report import figures_style as style
from locosweep.diagnosis.report.figures_motion import gap_channel, residual
from locosweep.files.robot import is_rotary
from locosweep.plot.numbers import PlainNumbers, log_axis, plain_numbers
from locosweep.plot.style import figure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from locosweep.diagnosis.report.result import Diagnosis, Trace

_MOST = 24
"""Runs that strips show."""
_TICKS = 4
"""Numbers below the errors of the runs, about: the picture is a third of the page wide."""

_BINS = 240
_STRIPS = "YlGnBu"
_REGIME_COLOURS = ("#f2f2f2", "#1a1a1a", "#a6cee3", "#c26a00", "#5e3c99")
_RIM = withStroke(linewidth=3.2, foreground="white")
_VARIABLES = {
    "v": ("velocity $v$", "m/s", "rad/s"),
    "x": ("position $x$", "m", "rad"),
    "t": ("time in the run $t$", "s", "s"),
    "drive": ("drive command, in units of its column", "", ""),
    "distance": ("distance swept forward $s$", "m", "rad"),
}


def window_strips(diagnosis: Diagnosis, ax: Axes) -> Axes:
    """Draw the nominal model's residual over time, a strip a run, and its worst windows."""
    name = gap_channel(diagnosis)
    info = style.channel(name, diagnosis.nominal)
    traces = diagnosis.traces[:_MOST]
    rows = [_binned(trace, name) for trace in traces]
    factor, unit = info.scale(style.reach([sizes for _, sizes in rows]))
    norm = Normalize(0.0, factor * style.reach([sizes for _, sizes in rows]) or 1.0)
    for y, (edges, sizes) in enumerate(rows):
        image = ax.pcolormesh(edges, [y - 0.4, y + 0.4], factor * sizes[None], norm=norm,
                              cmap=_STRIPS)  # fmt: skip
    bar = ax.get_figure(root=True).colorbar(  # type: ignore[union-attr]
        image, ax=ax, pad=0.01, aspect=10, format=PlainNumbers()
    )
    bar.set_label(f"$|\\Delta {info.symbol}|$ [{unit}]")
    _boxes(ax, traces, diagnosis.where["windows"])
    return _runs_axis(ax, traces, "where it shows: residual of the whole free run")


def origin_strips(diagnosis: Diagnosis, ax: Axes) -> Axes:
    """Draw the kind of motion over time, a strip a run, and where the gap arises."""
    traces = diagnosis.traces[:_MOST]
    for y, trace in enumerate(traces):
        edges = _edges(trace.t)
        change = np.flatnonzero(np.diff(trace.regime)) + 1
        first, last = np.r_[0, change], np.r_[change, trace.t.size]
        bars = list(zip(edges[first], edges[last] - edges[first], strict=True))
        colours = [_REGIME_COLOURS[int(kind)] for kind in trace.regime[first]]
        ax.broken_barh(bars, (y - 0.4, 0.8), facecolors=colours)
    _boxes(ax, traces, diagnosis.where["origin"])
    return _runs_axis(ax, traces, "where it arises: residual after a restart at the window's start")


def where_in_time(diagnosis: Diagnosis) -> Figure:
    """Show both: where the gap shows, and where it arises."""
    count = min(len(diagnosis.traces), _MOST)
    made = figure(9.0, 2.6 + 0.5 * count)
    top, bottom = made.subplots(2, 1, sharex=True, sharey=True)
    window_strips(diagnosis, top)
    origin_strips(diagnosis, bottom)
    handles = [Patch(facecolor=colour, edgecolor="0.5", linewidth=0.4, label=style.words(regime))
               for regime, colour in zip(REGIMES, _REGIME_COLOURS, strict=True)]  # fmt: skip
    made.legend(handles=handles, loc="outside lower center", ncols=5, fontsize=8, frameon=False)
    top.set_xlabel("")
    return made


def _binned(trace: Trace, name: str) -> tuple[Any, Any]:
    """Edges of time bins and the root mean square of the residual in each."""
    left = residual(trace, trace.nominal, name)
    count = min(_BINS, trace.t.size)
    bins = np.minimum(np.arange(trace.t.size) * count // trace.t.size, count - 1)
    known = np.isfinite(left)
    total = np.bincount(bins[known], left[known] ** 2, count)
    number = np.bincount(bins[known], minlength=count)
    sizes = np.sqrt(np.divide(total, number, out=np.full(count, np.nan), where=number > 0))
    first = np.searchsorted(bins, np.arange(count))
    edges = _edges(trace.t)
    return np.append(edges[first], edges[-1]), sizes


def _edges(t: Any) -> Any:
    return np.concatenate([t[:1], (t[1:] + t[:-1]) / 2, t[-1:]])


def _boxes(ax: Axes, traces: Sequence[Trace], windows: Sequence[dict[str, Any]]) -> None:
    heights = {trace.label: y for y, trace in enumerate(traces)}
    for run, t0, t1, share in _joined(windows):
        if run not in heights:
            continue
        y = heights[run]
        ax.add_patch(Rectangle((t0, y - 0.4), t1 - t0, 0.8, fill=False, edgecolor="black",
                               linewidth=1.4, zorder=4, path_effects=[_RIM]))  # fmt: skip
        text = ax.annotate(f"{share:.0%}", ((t0 + t1) / 2, y), ha="center",
                           va="center", fontsize=7.5, zorder=5)  # fmt: skip
        text.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 0.8})


def _joined(windows: Sequence[dict[str, Any]]) -> list[tuple[str, float, float, float]]:
    """Windows of a run that touch, as one: run, start, end, share."""
    found: list[tuple[str, float, float, float]] = []
    for window in sorted(windows, key=lambda w: (w["run"], w["t0"])):
        run, t0, t1, share = (window[key] for key in ("run", "t0", "t1", "share"))
        if found and found[-1][0] == run and t0 - found[-1][2] < 0.05 * (t1 - t0):
            _, begin, _, sum_ = found.pop()
            t0, share = begin, share + sum_
        found.append((run, t0, t1, share))
    return found


def _runs_axis(ax: Axes, traces: Sequence[Trace], title: str) -> Axes:
    names = [style.run_label(t.label, kept=t.held_out) for t in traces]
    ax.set_yticks(range(len(traces)), names, fontsize=8)
    ax.set_ylim(len(traces) - 0.5, -0.5)
    ax.set(xlabel="time since the run's start $t$ [s]", ylabel="run")
    ax.set_title(f"{title}; boxes: shares of its square", fontsize=9, loc="left")
    plain_numbers(ax)
    return ax


def shares(diagnosis: Diagnosis) -> Figure:
    """Show which channels and kinds of motion hold the gap, and each run's error."""
    where = diagnosis.where
    runs = where["runs"][:_MOST]
    made = figure(9.0, max(2.6, 1.2 + 0.3 * max(len(runs), 5)))
    left, middle, right = made.subplots(1, 3, width_ratios=[1, 1, 1.3])
    _bars(left, [row["channel"] for row in where["channels"]],
          [row["share"] for row in where["channels"]], "channel")  # fmt: skip
    _bars(middle, [row["regime"] for row in where["regimes"]],
          [row["share"] for row in where["regimes"]], "kind of motion")  # fmt: skip
    info = style.channel(gap_channel(diagnosis), diagnosis.nominal)
    known = [float(row[key]) for row in runs for key in ("before", "after") if row[key]]
    factor, unit = info.scale(max(known, default=0.0))
    for y, row in enumerate(runs):
        pair = [(row[key], marker, line["color"]) for key, marker, line in
                (("before", "o", style.NOMINAL), ("after", "D", style.AUGMENTED))]  # fmt: skip
        if not diagnosis.effects:
            pair.pop()
        ends = [factor * value for value, _, _ in pair if value]
        right.plot(ends, [y] * len(ends), color="0.6", linewidth=1.0, zorder=1)
        for value, marker, colour in pair:
            if value:
                right.plot(factor * value, y, marker, color=str(colour), markersize=6)
    floor = diagnosis.gap.get("noise_floor")
    if floor:
        right.axvline(factor * floor, color="0.3", linestyle=":", linewidth=1.2)
        right.annotate("noise floor", (factor * floor, 1.0), xycoords=("data", "axes fraction"),
                       ha="center", va="bottom", fontsize=8)  # fmt: skip
    if known:
        right.set_xscale("log")
        log_axis(right.xaxis, _TICKS)
    kept = set(diagnosis.gap["held_out"])
    names = [style.run_label(row["run"], kept=row["run"] in kept) for row in runs]
    right.set_yticks(range(len(runs)), names, fontsize=8)
    right.set_ylim(len(runs) - 0.4, -0.6)
    after = ", ◆ after" if diagnosis.effects else ""
    right.set(xlabel=f"rmse of ${info.symbol}$ [{unit}], ● before{after}", ylabel="run")
    style.finish(right)
    return made


def _bars(ax: Axes, names: Sequence[str], values: Sequence[float | None], what: str) -> None:
    for y, value in enumerate(values):
        ax.barh(y, value or 0.0, color=style.AUGMENTED["color"], height=0.6)
        text = "unknown" if value is None else f"{value:.0%}"
        ax.annotate(text, (value or 0.0, y), xytext=(3, 0), textcoords="offset points",
                    va="center", fontsize=8)  # fmt: skip
    ax.set_yticks(range(len(names)), [style.words(name) for name in names], fontsize=8)
    ax.set_ylim(max(len(names), 5) - 0.4, -0.6)
    ax.set(xlim=(0, 1.28), xlabel="share of the squared residual [1]", ylabel=what)
    style.finish(ax)


def force_view(diagnosis: Diagnosis) -> Figure | None:
    """Show the force that the nominal model lacks over each variable it may depend on."""
    tables = {name: table for name, table in diagnosis.details.get("force_view", {}).items()
              if len(table[0])}  # fmt: skip
    if not tables:
        return None
    rotary = is_rotary(diagnosis.nominal)
    made = figure(9.0, 2.7 * -(-len(tables) // 3))
    grid = made.subplots(-(-len(tables) // 3), 3, squeeze=False).ravel()
    size = style.reach([np.asarray(table[1]) for table in tables.values()])
    factor, unit = style.channel("force", diagnosis.nominal).scale(size)
    for ax, (name, (centres, force, half)) in zip(grid, tables.items(), strict=False):
        force, half = factor * np.asarray(force), factor * np.asarray(half)
        ax.axhline(0.0, color="0.4", linewidth=0.8)
        ax.errorbar(centres, force, half, fmt="o", color=style.AUGMENTED["color"], markersize=3.5,
                    linewidth=1.0, capsize=2)  # fmt: skip
        words, linear, turning = _VARIABLES.get(name, (style.words(name), "1", "1"))
        of = turning if rotary else linear
        ax.set_xlabel(f"{words} [{of}]" if of else words, fontsize=9)
        ax.set_ylabel(f"missing {'torque' if rotary else 'force'} [{unit}]", fontsize=9)
        ax.tick_params(labelsize=8)
        style.finish(ax)
    for ax in grid[len(tables) :]:
        ax.set_visible(False)
    return made
