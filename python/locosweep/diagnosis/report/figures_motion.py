"""Pictures of runs: measured against the nominal and the augmented model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from locosweep.diagnosis.report import figures_style as style
from locosweep.diagnosis.report.units import sized
from locosweep.plot.style import figure

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from locosweep.diagnosis.report.result import Diagnosis, Trace

    Floats = NDArray[np.float64]

_SMALL = 24
"""Runs that a page of small pictures shows."""

NOISE_BAND = 2.0
"""Standard deviations of noise that the band around zero is wide on either side."""


def channel_over_time(diagnosis: Diagnosis, trace: Trace, name: str, ax: Axes) -> Axes:
    """Draw one channel of a run, measured, nominal and augmented."""
    sources = [
        (trace.measured.get(name), "measured", style.MEASURED),
        (trace.nominal.get(name), "nominal model", style.NOMINAL),
        (trace.augmented.get(name), "augmented model", style.AUGMENTED),
    ]
    if not diagnosis.effects:
        sources.pop()
    drawn = [(field, words, line) for field, words, line in sources if field is not None]
    info = style.channel(name, diagnosis.nominal)
    factor, unit = info.scale(style.reach(field for field, _, _ in drawn))
    for field, words, line in drawn:
        ax.plot(trace.t, factor * field, label=words, **line)
    ax.set_ylabel(info.axis(unit))
    ax.margins(x=0)
    return style.finish(ax)


def residual_over_time(
    diagnosis: Diagnosis, trace: Trace, ax: Axes, *, after: bool, name: str | None = None
) -> Axes:
    """Draw measured minus simulated, with the band that noise alone would fill.

    The model is the augmented one with `after`, else the nominal one; the channel is that of
    the gap if `name` gives none.
    """
    name = name or gap_channel(diagnosis, trace)
    info = style.channel(name, diagnosis.nominal)
    model = trace.augmented if after else trace.nominal
    line = style.AUGMENTED if after else style.NOMINAL
    left = residual(trace, model, name)
    noise = diagnosis.details.get("noise", {}).get(name)
    factor, unit = info.scale(max(style.reach([left]), NOISE_BAND * (noise or 0.0)))
    if noise:
        band = NOISE_BAND * noise * factor
        ax.axhspan(-band, band, color="0.8", linewidth=0, zorder=0,
                   label=f"noise, ±{NOISE_BAND:g} standard deviations")  # fmt: skip
    ax.plot(trace.t, factor * left, **{**line, "linestyle": "-", "linewidth": 0.8})
    ax.axhline(0.0, color="0.4", linewidth=0.6)
    ax.set_ylabel(f"measured −\n{'augmented' if after else 'nominal'} ${info.symbol}$ [{unit}]")
    ax.margins(x=0)
    return style.finish(ax)


def residual(trace: Trace, model: dict[str, Floats], name: str) -> Floats:
    """Measured minus simulated; NaN where either is missing."""
    measured, simulated = trace.measured.get(name), model.get(name)
    if measured is None or simulated is None:
        return np.full(trace.t.size, np.nan)
    left: Floats = measured - simulated
    return left


def gap_channel(diagnosis: Diagnosis, trace: Trace | None = None) -> str:
    """Channel in which the gap is stated, or the first measured one of a run."""
    name = diagnosis.gap.get("channel") or "x"
    if trace is not None and name not in trace.measured:
        name = next(iter(trace.measured), "x")
    return str(name)


def runs_large(diagnosis: Diagnosis) -> Figure:
    """Show one or two runs large: the worst kept from the fit, and the worst fitted."""
    chosen = _worst(diagnosis)
    channels = [name for name in ("x", "v", "force", "x_rear")
                if name in ("x", "v") or any(name in t.measured for t in chosen)]  # fmt: skip
    after = (False, True) if diagnosis.effects else (False,)
    rows = len(channels) + len(after)
    made = figure(5.2 * len(chosen) + 0.6, 1.75 * rows + 0.7)
    grid = made.subplots(rows, len(chosen), sharex="col", squeeze=False)
    for column, trace in enumerate(chosen):
        axes: list[Axes] = list(grid[:, column])
        for name, ax in zip(channels, axes, strict=False):
            channel_over_time(diagnosis, trace, name, ax)
            if name not in trace.measured:
                text = ax.annotate("not measured", (0.99, 0.95), xycoords="axes fraction",
                                   ha="right", va="top", fontsize=8)  # fmt: skip
                text.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1})
        for which, ax in zip(after, axes[len(channels) :], strict=True):
            residual_over_time(diagnosis, trace, ax, after=which)
        role = "kept from the fit" if trace.held_out else "used for the fit"
        axes[0].set_title(f"run {style.label(trace.label)}, {role}", fontsize=10, loc="left")
        axes[-1].set_xlabel("time $t$ [s]")
    first = {text: handle for ax in grid[:, 0]
             for handle, text in zip(*ax.get_legend_handles_labels(), strict=True)}  # fmt: skip
    made.legend(first.values(), first.keys(), loc="outside upper center", ncols=4, fontsize=9,
                frameon=False)  # fmt: skip
    made.align_ylabels()
    return made


def _worst(diagnosis: Diagnosis) -> list[Trace]:
    """One run kept from the fit and one used for it, with the largest gaps."""
    before = {row["run"]: row["before"] or 0.0 for row in diagnosis.where["runs"]}
    found = []
    for held in (True, False):
        some = [t for t in diagnosis.traces if t.held_out is held]
        if some:
            found.append(max(some, key=lambda t: before.get(t.label, 0.0)))
    return found


def runs_small(diagnosis: Diagnosis) -> Figure:
    """Show the gap's channel of the first 24 runs in small, with its error before and after."""
    traces: Sequence[Trace] = diagnosis.traces[:_SMALL]
    columns = min(4, len(traces))
    rows = -(-len(traces) // columns)
    made = figure(max(2.7 * columns, 5.4), 2.0 * rows + 0.6)
    grid = made.subplots(rows, columns, squeeze=False).ravel()
    errors = {row["run"]: row for row in diagnosis.where["runs"]}
    for ax, trace in zip(grid, traces, strict=False):
        name = gap_channel(diagnosis, trace)
        channel_over_time(diagnosis, trace, name, ax)
        ax.set_xlabel("time $t$ [s]", fontsize=8)
        ax.yaxis.label.set_fontsize(8)
        ax.tick_params(labelsize=7)
        ax.xaxis.set_major_locator(MaxNLocator(4))
        ax.yaxis.set_major_locator(MaxNLocator(4))
        change = _change_of_error(diagnosis, errors.get(trace.label), name)
        title = f"run {style.run_label(trace.label, kept=trace.held_out)}"
        ax.set_title(f"{title}\n{change}", fontsize=8)
    for ax in grid[len(traces) :]:
        ax.set_visible(False)
    made.legend(*grid[0].get_legend_handles_labels(), loc="outside upper center", ncols=3,
                fontsize=8, frameon=False)  # fmt: skip
    return made


def _change_of_error(diagnosis: Diagnosis, row: dict[str, float | None] | None, name: str) -> str:
    """Say a run's error before and after."""
    before = None if row is None else row["before"]
    after = None if row is None else row["after"]
    if before is None:
        return ""
    unit = style.channel(name, diagnosis.nominal).unit
    later = "" if after is None or not diagnosis.effects else f" → {sized(after, unit, 3)}"
    return f"rmse {sized(before, unit, 3)}{later}"
