"""Pictures of distributions and of indices."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import offset_copy

from locosweep.plot import style
from locosweep.plot.caption import fixed_values, title
from locosweep.plot.current import current_axes
from locosweep.registry import parameter
from locosweep.uncertainty.propagation import QUANTILES, Propagation, too_many

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from locosweep.uncertainty.sensitivity import Sensitivity

_BINS = 60
"""Of a histogram: each about two dots of a small picture wide."""
_LARGE = (6.8, 4.6)
"""Inches of a picture of a distribution."""
_FEW = 41
"""Cells along an axis up to which each has a marker."""
_SIZE, _FONT = (4.6, 3.2), 8
"""Inches of a small picture, and points of its letters."""
_BELOW = -32.0
"""Points from the axis below a picture to the legend below its label."""


def distribution(found: Propagation, ax: Axes | None = None) -> Axes:
    """Draw a histogram, or quantiles along the only axis."""
    if len(found.axes) > 1:
        raise too_many(found.axes)
    ax = current_axes(ax, *_LARGE)
    if found.axes:
        _along(found, ax)
    else:
        _histogram(found, ax)
    unknown = ", ".join(f"${parameter(name).symbol}$" for name in found.points)
    _title(found, ax, f"{found.samples} points of {unknown}", {*found.points, *found.axes})
    return ax


def _title(found: Propagation | Sensitivity, ax: Axes, words: str, shown: set[str]) -> None:
    """Write what is drawn, what was simulated and what is fixed above axes."""
    fixed = [style.setting(*one) for one in fixed_values(found, found.output, shown)]
    ax.set_title(title([style.simulated(found.how), words], fixed), fontsize=9, loc="left")


def _histogram(found: Propagation, ax: Axes) -> None:
    values = found.values[np.isfinite(found.values)]
    colour = style.LINES[0][0]
    if values.size:
        ax.hist(values, bins=_BINS, color=colour, alpha=0.6)
    for rank, (q, value) in enumerate(zip(QUANTILES, found.quantile(QUANTILES), strict=True)):
        if np.isfinite(value):
            _, dash, _ = style.LINES[rank]
            ax.axvline(float(value), color="black", linestyle=dash, linewidth=1.2,
                       label=f"quantile {q:g}: {value:.4g}")  # fmt: skip
    if found.need is not None:
        share = f"{100 * float(found.share):.3g} %"
        ax.axvline(found.need.bound, color=style.LINES[1][0], linewidth=1.6,
                   label=f"need {found.need}: {share} of the points")  # fmt: skip
    missing = 1.0 - float(found.with_value)
    if missing:
        why = found.to_polars()["without_value"][0].replace("_", " ")
        ax.plot([], [], " ", label=f"{100 * missing:.3g} % without a value, mostly: {why}")
    ax.set(xlabel=style.output_label(found.output), ylabel="points [1]")
    ax.legend(fontsize=8)
    style.grid(ax)


def _along(found: Propagation, ax: Axes) -> None:
    ((name, axis),) = found.axes.items()
    order = np.argsort(axis)
    low, middle, high = (values[order] for values in found.quantile(QUANTILES))
    colour, dash, marker = style.LINES[0]
    ax.fill_between(axis[order], low, high, color=colour, alpha=0.25, linewidth=0,
                    label=f"quantiles {QUANTILES[0]:g} to {QUANTILES[2]:g}")  # fmt: skip
    marks = marker if len(axis) <= _FEW else ""
    ax.plot(axis[order], middle, color=colour, linestyle=dash, marker=marks, markersize=4,
            label="median")  # fmt: skip
    if found.need is not None:
        ax.axhline(found.need.bound, color=style.LINES[1][0], linewidth=1.4,
                   label=f"need {found.need}")  # fmt: skip
    ax.set(xlabel=style.axis_label(name), ylabel=style.output_label(found.output))
    if parameter(name).integer:
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    shares = ax.twinx()
    share, words = found.with_value[order], "with a value"
    if found.need is not None:
        share, words = found.share[order], "that meet the need"
        between = found.share_interval[:, order]
        shares.fill_between(axis[order], between[0], between[1], color="0.4", alpha=0.3,
                            linewidth=0)  # fmt: skip
    shares.plot(axis[order], share, color="0.3", linestyle=":", linewidth=1.6)
    shares.set(ylim=(0.0, 1.05), ylabel=f"share of points {words} [1]")
    ax.plot([], [], color="0.3", linestyle=":", linewidth=1.6, label=f"share {words} (right)")
    # Curves fill the picture: below its labels there is always room.
    below = offset_copy(ax.transAxes, fig=ax.get_figure(root=True), y=_BELOW, units="points")
    ax.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=below,
              ncols=2, frameon=False)  # fmt: skip
    style.grid(ax)


def bars(found: Sensitivity, ax: Axes | None = None) -> Axes:
    """Draw first-order and total indices of each parameter."""
    table = found.to_polars()
    ax = current_axes(ax, *_size(found))
    places = np.arange(len(found.names))
    for kind, shift, (colour, _, _) in zip(("first", "total"), (-0.2, 0.2), style.LINES,
                                           strict=False):  # fmt: skip
        # Of a share that is none, estimates below 0 are noise; intervals stay where they are.
        index = np.maximum(table[kind].to_numpy(), 0.0)
        ends = [index - table[f"{kind}_low"].to_numpy(), table[f"{kind}_high"].to_numpy() - index]
        ends = [np.maximum(end, 0.0) for end in ends]
        ax.barh(places + shift, index, 0.36, xerr=ends, color=colour,
                edgecolor="black", linewidth=0.6, capsize=3, hatch="" if kind == "first" else "//",
                label="first order: alone" if kind == "first" else "total: with all others",
                )  # fmt: skip
    names = [_words(name) for name in table["unknown"]]
    ax.set_yticks(places, names, fontsize=9)
    ax.invert_yaxis()
    ax.set_xlim(left=min(0.0, float(table["first_low"].min())))  # type: ignore[arg-type]
    ax.set_xlabel(f"share of the variance of the {found.output.label} [1]\nline: 95 % interval")
    ax.set_ylabel("unknown parameter")
    ax.legend(fontsize=8, loc="lower right")
    style.grid(ax)
    ax.set_axisbelow(True)
    _title(found, ax, "", {name.partition("/")[0] for name in found.names})
    return ax


def _size(found: Propagation | Sensitivity) -> tuple[float, float]:
    """Return width and height of a picture in inches."""
    return _LARGE if isinstance(found, Propagation) else (6.8, 1.9 + 0.6 * len(found.names))


def _words(name: str) -> str:
    parts = [f"${parameter(part).symbol}$" for part in name.split("/")]
    words = style.words_of(name) if len(parts) == 1 else "ratio"
    return f"{words} {' / '.join(parts)}"


def small(found: Propagation | Sensitivity) -> Figure | None:
    """Return the picture that a notebook shows, if one says anything."""
    if isinstance(found, Propagation) and (len(found.axes) > 1 or not found.with_value.any()):
        return None
    # Names of parameters are long.
    made = style.figure(*(_SIZE if isinstance(found, Propagation) else _size(found)))
    found.plot(made.subplots())
    for ax in made.axes:
        ax.tick_params(labelsize=_FONT)
        for text in (ax.xaxis.label, ax.yaxis.label):
            text.set_fontsize(_FONT)
    return made


def drawn(found: Propagation | Sensitivity) -> Figure:
    """Return the picture without making it the current one of pyplot."""
    made = style.figure(*_size(found))
    found.plot(made.subplots())
    return made
