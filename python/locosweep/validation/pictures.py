"""Pictures of a blind check: confusion matrix, power and calibration curves, shrink."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure as Canvas

from locosweep.plot.style import LINES, SEQUENTIAL
from locosweep.validation.metrics import PLAIN, calibration, confusion, power

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from locosweep.validation.judge import Judged
    from locosweep.validation.metrics import Figure

_LAST = ("several", "unexplained", "none", "error")


def _axes(width: float, height: float) -> Axes:
    return Canvas(figsize=(width, height), layout="constrained", dpi=150).add_subplot()


def _curve(ax: Axes, x: Sequence[float], rows: Sequence[Figure], label: str, line: int) -> None:
    colour, dash, marker = LINES[line]
    value = np.array([row.value for row in rows])
    # A rounding error must not make a whisker negative.
    low = np.maximum(value - [row.low for row in rows], 0.0)
    high = np.maximum([row.high for row in rows] - value, 0.0)
    ax.errorbar(
        x,
        value,
        yerr=[low, high],
        color=colour,
        linestyle=dash,
        marker=marker,
        capsize=3,
        label=label,
    )


def plot_power(judged: Sequence[Judged], ax: Axes | None = None) -> Axes:
    """Draw the shares detected and right against the size of what is there."""
    ax = ax or _axes(6.4, 4.2)
    rows = power(judged)
    if rows:
        inside = [[c.d for c in judged if c.kind != "none" and a <= c.d < b] for a, b, _, _ in rows]
        x = [float(np.median(d)) for d in inside]
        _curve(ax, x, [row[2] for row in rows], "a gap is seen", 0)
        _curve(ax, x, [row[3] for row in rows], "the verdict is right", 1)
        ax.set_xscale("log")
        ax.legend(loc="lower right", frameon=False)
    for share, size in ((0.9, 6.0), (0.99, 10.0)):
        ax.plot([size], [share], marker="x", color="0.3", linestyle="none")
        ax.annotate(
            f"target {share:g}", (size, share), (4, -12), textcoords="offset points", fontsize=8
        )
    ax.set(
        xlabel="size d of what is there [standard deviations]",
        ylabel="share of cases [1]",
        ylim=(0, 1.05),
    )
    return ax


def plot_calibration(judged: Sequence[Judged], ax: Axes | None = None) -> Axes:
    """Draw the share that is right against the probability that was stated."""
    ax = ax or _axes(4.8, 4.6)
    ax.plot([0, 1], [0, 1], color="0.6", linestyle="--", label="as stated")
    rows = calibration(judged)
    if rows:
        _curve(
            ax,
            [stated for stated, _ in rows],
            [row for _, row in rows],
            "verdicts, 95 % interval",
            0,
        )
        for stated, row in rows:
            ax.annotate(
                str(row.count),
                (stated, row.value),
                (5, -11),
                textcoords="offset points",
                fontsize=8,
            )
    _legend_above(ax)
    ax.set(
        xlabel="stated probability [1]", ylabel="share right [1]", xlim=(0, 1.04), ylim=(0, 1.04)
    )
    ax.set_aspect("equal")
    return ax


def _legend_above(ax: Axes) -> None:
    """Place the legend where no bar runs through it."""
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False, fontsize=8)


def plot_shrink(judged: Sequence[Judged], ax: Axes | None = None) -> Axes:
    """Draw the shrink that was claimed against the one on fresh runs."""
    ax = ax or _axes(4.8, 4.6)
    cases = [c for c in judged if c.right and c.claimed is not None and c.fresh is not None]
    claimed = np.array([c.claimed for c in cases], dtype=float)
    fresh = np.array([c.fresh for c in cases], dtype=float)
    ax.plot([0, 1], [0, 1], color="0.6", linestyle="--", label="as stated")
    ends = np.array([c.interval or (c.claimed, c.claimed) for c in cases], dtype=float)
    if cases:
        size = np.maximum(np.abs(ends.T - claimed), 0.0)
        ax.errorbar(
            fresh,
            claimed,
            yerr=size,
            fmt="o",
            color=LINES[0][0],
            ecolor="0.75",
            markersize=3,
            alpha=0.7,
            label="right verdicts, stated 90 % interval",
        )
    _legend_above(ax)
    ax.set(
        xlabel="shrink on fresh runs [1]",
        ylabel="shrink stated [1]",
        xlim=(-0.05, 1.02),
        ylim=(-0.05, 1.02),
    )
    ax.set_aspect("equal")
    return ax


def _ordered(names: set[str], last: Sequence[str]) -> list[str]:
    return [*sorted(names - set(last)), *(name for name in last if name in names)]


def plot_confusion(judged: Sequence[Judged], ax: Axes | None = None) -> Axes:
    """Draw what was said against what is true, as shares of each true cause."""
    counts = confusion(judged)
    true = _ordered({t for t, _ in counts}, ("outside the list", "none"))
    said = _ordered({s for _, s in counts} | set(true) - {"outside the list"}, _LAST)
    ax = ax or _axes(3.6 + 0.3 * len(said), 2.6 + 0.27 * len(true))
    ax.set(
        xlabel="said (what cannot be told apart counts as right)",
        ylabel=f"true, told apart by {PLAIN:g} or more",
    )
    if not counts:
        return ax
    table = np.array([[counts.get((t, s), 0) for s in said] for t in true], dtype=float)
    shares = table / np.maximum(table.sum(axis=1, keepdims=True), 1.0)
    image = ax.imshow(
        np.where(table > 0, shares, np.nan), cmap=SEQUENTIAL, vmin=0, vmax=1, aspect="auto"
    )
    for i, j in np.argwhere(table > 0):
        dark = shares[i, j] < 0.6
        ax.text(
            j,
            i,
            f"{table[i, j]:.0f}",
            ha="center",
            va="center",
            fontsize=7,
            color="w" if dark else "k",
        )
    ax.set_xticks(range(len(said)), said, rotation=90, fontsize=7)
    ax.set_yticks(range(len(true)), true, fontsize=7)
    if ax.figure is not None:
        ax.figure.colorbar(image, ax=ax, label="share of the true cause [1]", shrink=0.8)
    return ax


PICTURES = {
    "confusion.png": plot_confusion,
    "power.png": plot_power,
    "calibration.png": plot_calibration,
    "shrink.png": plot_shrink,
}
"""File names and what draws them."""
