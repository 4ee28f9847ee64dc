"""Picture of distances between effects."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.design.distinguish import APART
from locosweep.diagnosis.report import figures_style as style
from locosweep.plot.current import current_axes
from locosweep.plot.style import figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from locosweep.diagnosis.design.distinguish import Distinction


def matrix_figure(distinction: Distinction) -> Figure:
    """Draw the same as a figure of its own, which needs no pyplot."""
    made = figure(*_size(distinction))
    matrix(distinction, ax=made.subplots())
    return made


def _size(distinction: Distinction) -> tuple[float, float]:
    """Return width and height in inches at which all names can be read."""
    side = 3.2 + 0.31 * len(distinction.names)
    return side + 0.8, side


def matrix(distinction: Distinction, *, ax: Axes | None = None) -> Axes:
    """Draw the distance of each effect from each rival, on axes of pyplot if none are given."""
    names = [style.words(name) for name in distinction.names]
    count = len(names)
    ax = current_axes(ax, *_size(distinction))
    shown = distinction.distances
    image = ax.imshow(shown, cmap="cividis", vmin=0.0, vmax=distinction.size)
    for row in range(count):
        for column in range(count):
            if row == column:
                continue
            value = shown[row, column]
            near = value < APART
            ax.annotate(f"{value:.1f}", (column, row), ha="center", va="center", fontsize=6,
                        color="white" if value < 0.55 * distinction.size else "black",
                        weight="bold" if near else "normal")  # fmt: skip
    ax.plot(np.arange(count), np.arange(count), "s", color="0.8", markersize=4)
    ax.set_xticks(range(count), names, rotation=60, ha="right", rotation_mode="anchor", fontsize=8)
    ax.set_yticks(range(count), names, fontsize=8)
    ax.set(xlabel="rival that is refitted",
           ylabel=f"effect at work, its signal {distinction.size:g} σ long")  # fmt: skip
    bar = ax.get_figure(root=True).colorbar(image, ax=ax, shrink=0.8, pad=0.02)  # type: ignore[union-attr]
    bar.set_label("what is left of the signal [σ]")
    bar.ax.axhline(APART, color="white", linewidth=1.6)
    bar.ax.axhline(APART, color="black", linewidth=0.8, linestyle="--")
    ax.set_title(f"below {APART:g} σ (bold) the experiment cannot tell them apart", fontsize=9,
                 loc="left")  # fmt: skip
    return ax
