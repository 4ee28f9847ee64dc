"""Pictures of a blind check: confusion matrix, power, calibration, validation error reduction."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.plot import style
from locosweep.plot.style import LINES, SEQUENTIAL
from locosweep.validation.metrics import PLAIN, calibration, confusion, power

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

    from locosweep.validation.judge import Judged
    from locosweep.validation.metrics import Figure

_LAST = ("several", "unexplained", "none", "error")


def _curve(ax: Axes, x: Sequence[float], rows: Sequence[Figure], label: str, line: int) -> None:
    colour, dash, marker = LINES[line]
    value = np.array([row.value for row in rows])
    # A rounding error must not make a whisker negative.
    low = np.maximum(value - [row.low for row in rows], 0.0)
    high = np.maximum([row.high for row in rows] - value, 0.0)
    ax.errorbar(x, value, yerr=[low, high], color=colour, linestyle=dash, marker=marker, capsize=3,
                label=label)  # fmt: skip


def _agreement(ax: Axes, x: str, y: str, low: float, high: float) -> None:
    """Finish a picture of what is stated beside what is found, equal on the diagonal."""
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False, fontsize=8)
    ax.set(xlabel=x, ylabel=y, xlim=(low, high), ylim=(low, high))
    ax.set_aspect("equal")


def plot_power(judged: Sequence[Judged]) -> Canvas:
    """Draw the shares of gaps detected and of correct verdicts over the size of the gap."""
    figure = style.figure(6.4, 4.2)
    ax = figure.subplots()
    rows = power(judged)
    if rows:
        inside = [[c.d for c in judged if c.kind != "none" and a <= c.d < b] for a, b, _, _ in rows]
        x = [float(np.median(d)) for d in inside]
        _curve(ax, x, [row[2] for row in rows], "gap detected", 0)
        _curve(ax, x, [row[3] for row in rows], "verdict correct", 1)
        ax.set_xscale("log")
        ax.legend(loc="lower right", frameon=False)
    for share, size in ((0.9, 6.0), (0.99, 10.0)):
        ax.plot([size], [share], marker="x", color="0.3", linestyle="none")
        ax.annotate(
            f"target {share:g}", (size, share), (4, -12), textcoords="offset points", fontsize=8
        )
    ax.set(xlabel="size d of the gap [standard deviations]", ylabel="share of cases [1]",
           ylim=(0, 1.05))  # fmt: skip
    return figure


def plot_calibration(judged: Sequence[Judged]) -> Canvas:
    """Draw the share of correct verdicts over their stated probability."""
    figure = style.figure(4.8, 4.6)
    ax = figure.subplots()
    ax.plot([0, 1], [0, 1], color="0.6", linestyle="--", label="as stated")
    rows = calibration(judged)
    if rows:
        x = [stated for stated, _ in rows]
        _curve(ax, x, [row for _, row in rows], "verdicts, 95 % interval", 0)
        for stated, row in rows:
            ax.annotate(str(row.count), (stated, row.value), (5, -11), textcoords="offset points",
                        fontsize=8)  # fmt: skip
    _agreement(ax, "stated probability [1]", "share of correct verdicts [1]", 0.0, 1.04)
    return figure


def plot_reduction(judged: Sequence[Judged]) -> Canvas:
    """Draw the claimed validation error reduction over that on fresh runs."""
    figure = style.figure(4.8, 4.6)
    ax = figure.subplots()
    cases = [c for c in judged if c.right and c.claimed is not None and c.fresh is not None]
    ax.plot([0, 1], [0, 1], color="0.6", linestyle="--", label="as stated")
    if cases:
        claimed, fresh = (np.array([getattr(c, n) for c in cases]) for n in ("claimed", "fresh"))
        ends = np.array([c.interval or (c.claimed, c.claimed) for c in cases], dtype=float)
        size = np.maximum(np.abs(ends.T - claimed), 0.0)
        ax.errorbar(fresh, claimed, yerr=size, fmt="o", color=LINES[0][0], ecolor="0.75",
                    markersize=3, alpha=0.7,
                    label="correct verdicts, stated 90 % interval")  # fmt: skip
    _agreement(ax, "reduction on fresh runs [1]", "claimed reduction [1]", -0.05, 1.02)
    return figure


def _ordered(names: set[str], last: Sequence[str]) -> list[str]:
    return [*sorted(names - set(last)), *(name for name in last if name in names)]


def plot_confusion(judged: Sequence[Judged]) -> Canvas:
    """Draw the verdicts of each true cause as shares of its cases."""
    counts = confusion(judged)
    true = _ordered({t for t, _ in counts}, ("outside the list", "none"))
    said = _ordered({s for _, s in counts} | set(true) - {"outside the list"}, _LAST)
    figure = style.figure(3.6 + 0.3 * len(said), 2.6 + 0.27 * len(true))
    ax = figure.subplots()
    ax.set(
        xlabel="verdict (indistinguishable causes count as the true one)",
        ylabel=f"true cause, d_name of {PLAIN:g} or more",
    )
    if not counts:
        return figure
    table = np.array([[counts.get((t, s), 0) for s in said] for t in true], dtype=float)
    shares = table / np.maximum(table.sum(axis=1, keepdims=True), 1.0)
    image = ax.imshow(
        np.where(table > 0, shares, np.nan), cmap=SEQUENTIAL, vmin=0, vmax=1, aspect="auto"
    )
    for i, j in np.argwhere(table > 0):
        ax.text(j, i, f"{table[i, j]:.0f}", ha="center", va="center", fontsize=7,
                color="w" if shares[i, j] < 0.6 else "k")  # fmt: skip
    ax.set_xticks(range(len(said)), said, rotation=90, fontsize=7)
    ax.set_yticks(range(len(true)), true, fontsize=7)
    figure.colorbar(image, ax=ax, label="share of the true cause [1]", shrink=0.8)
    return figure


PICTURES = {
    "confusion.png": plot_confusion,
    "power.png": plot_power,
    "calibration.png": plot_calibration,
    "shrink.png": plot_reduction,
}
"""Functions that draw the pictures, by file name."""
