"""Title and legends of a picture of a result."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.legend import Legend


def dress(ax: Axes, head: str, below: Sequence[Artist], beside: Sequence[Artist] = ()) -> None:
    """Title, and legends below and beside the axes, where they cover no data."""
    if head:
        ax.set_title(head, fontsize=9)
    # Below: the distance is in units of the font, room for ticks and label.
    if below:
        first = _legend(ax, below, "upper center", (0.5, 0.0), 4.6)
    if beside:
        if below:
            ax.add_artist(first)
            # Clipped to the axes it would get no room from the layout.
            first.set_clip_on(False)
        _legend(ax, beside, "upper left", (1.0, 1.0), 0.5)


def _legend(
    ax: Axes,
    handles: Sequence[Artist],
    corner: Literal["upper left", "upper center"],
    anchor: tuple[float, float],
    distance: float,
) -> Legend:
    return ax.legend(
        handles=handles,
        loc=corner,
        bbox_to_anchor=anchor,
        borderaxespad=distance,
        fontsize=8,
        handlelength=2.6,
        frameon=False,
    )
