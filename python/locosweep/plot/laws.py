"""Pictures of friction laws: force over speed, and what that does not show."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import InputError
from locosweep.plot import style
from locosweep.plot.current import current_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from locosweep.simulation.law_data import Behaviour, Characteristic

KIND_COLOURS = {"dry": "#0072b2", "smooth": "#d55e00", "bristle": "#009e73"}
"""Colours of Okabe and Ito."""

_AT_REST = {
    "dry": "holds any force on the bar at rest",
    "smooth": "nought at rest: creeps under any load",
    "bristle": "bridged by the deflection of bristles",
}


def characteristic(
    *laws: Characteristic,
    ax: Axes | None = None,
    frame: tuple[float, float] | None = None,
    legend: bool = True,
) -> Axes:
    """Draw friction over Coulomb level against speed, one line for each law.

    What friction may take at rest is a bar for dry laws; a smooth law passes
    through nought; a bristle law jumps over a dotted line, which a deflection
    bridges.

    Parameters
    ----------
    *laws : Characteristic
        One to eight, from ``locosweep.simulation.law_data.characteristic_of``.
    ax : Axes, optional
        Where to draw; default the current axes of pyplot while they are empty.
    frame : tuple of float, optional
        Lowest and highest ordinate, so that several pictures compare.
    legend : bool
        Name the laws, and for one alone what happens at rest.

    Returns
    -------
    Axes

    Raises
    ------
    InputError
        No law or too many.

    Examples
    --------
    >>> from locosweep.plot import characteristic
    >>> from locosweep.simulation.law_data import characteristic_of
    >>> dry = characteristic_of("coulomb", mu_coulomb=0.3)
    >>> characteristic(dry).get_xlabel()
    'speed $v$ [m/s]'
    """
    if not 1 <= len(laws) <= len(style.LINES):
        raise InputError(f"{len(laws)} laws: allowed are 1 to {len(style.LINES)}")
    ax = current_axes(ax, 6.8, 4.6)
    single = len(laws) == 1
    style.zero_line(ax)
    ax.axvline(0.0, color="0.75", linewidth=0.8, zorder=0)
    for rank, (law, (colour, dash, _)) in enumerate(zip(laws, style.LINES, strict=False)):
        if single:
            colour, dash = KIND_COLOURS[law.kind], "-"
        force = law.force / law.level
        back, ahead = law.speed < 0, law.speed > 0
        speed = law.speed
        if law.kind == "smooth":
            speed, force = np.insert(speed, np.sum(back), 0.0), np.insert(force, np.sum(back), 0.0)
            ax.plot(speed, force, color=colour, linestyle=dash, label=law.law)
        else:
            ax.plot(speed[ahead], force[ahead], color=colour, linestyle=dash, label=law.law)
            ax.plot(speed[back], force[back], color=colour, linestyle=dash)
        at_rest = _AT_REST[law.kind] if single else None
        if law.rest is not None:
            bar = np.array(law.rest) / law.level
            # Each narrower than the one before, so that all stay in sight.
            width = 4.5 if single else 2.5 * (len(laws) - rank) + 1.0
            ax.plot([0, 0], bar, color=colour, linewidth=width, alpha=0.55 if single else 1.0,
                    solid_capstyle="butt", label=at_rest, zorder=1.5)  # fmt: skip
            ax.plot([0, 0], bar, color=colour, linestyle="none", marker="_", markersize=9)
        elif law.kind == "bristle":
            ends = [force[back][-1], force[ahead][0]]
            ax.plot([0, 0], ends, color=colour, linestyle=":", linewidth=1.6, label=at_rest)
        elif single:
            ax.plot([0], [0], color=colour, marker="o", markersize=5, linestyle="none",
                    label=at_rest)  # fmt: skip
    ax.set(xlabel="speed $v$ [m/s]", ylabel="friction over Coulomb level")
    ax.margins(x=0)
    if frame is not None:
        ax.set_ylim(*frame)
    style.grid(ax)
    if legend:
        ax.legend(loc="lower right", fontsize=8, frameon=True, framealpha=0.85, edgecolor="none")
    return ax


def frame_of(*laws: Characteristic) -> tuple[float, float]:
    """Return ordinates that hold all laws, with some room."""
    low = min(min([float(law.force.min()), *(law.rest or ())]) / law.level for law in laws)
    high = max(max([float(law.force.max()), *(law.rest or ())]) / law.level for law in laws)
    room = 0.06 * (high - low)
    return low - room, high + room


def behaviour(seen: Behaviour, *, ax: Axes | None = None) -> Axes:
    """Draw one more look at a law: presliding loops, creep, track, load, pull.

    Parameters
    ----------
    seen : Behaviour
        From ``locosweep.simulation.law_data.behaviour_of``.
    ax : Axes, optional
        Where to draw; default the current axes of pyplot while they are empty.

    Returns
    -------
    Axes

    Examples
    --------
    >>> from locosweep.plot import behaviour
    >>> from locosweep.simulation.law_data import behaviour_of
    >>> behaviour(behaviour_of("dahl", mu_coulomb=0.3)).get_xlabel()
    'displacement [µm]'
    """
    ax = current_axes(ax, 6.8, 4.6)
    # The widest first, so that the narrower ones stay in sight.
    for rank, (label, x, y) in enumerate(seen.lines):
        colour, dash, _ = style.LINES[rank % len(style.LINES)]
        ax.plot(x, y, color=colour, linestyle=dash, linewidth=1.4, label=label or None,
                zorder=3 - 0.1 * rank)  # fmt: skip
    ax.set(xlabel=seen.x_label, ylabel=seen.y_label)
    ax.set_title(seen.title, fontsize=10)
    style.grid(ax)
    if any(label for label, _, _ in seen.lines):
        ax.legend(loc="best", fontsize=8, frameon=True, framealpha=0.85, edgecolor="none")
    return ax
