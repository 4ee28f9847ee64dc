"""Pictures of motion: position, speed and drive force over time, rest shaded."""

from __future__ import annotations

from math import prod
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import Patch

from locosweep.errors import InputError
from locosweep.plot import style
from locosweep.plot.current import current_figure
from locosweep.registry import law

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from locosweep.simulation.trajectories import Trajectories

    Floats = NDArray[np.float64]

_REST = "0.85"
_LANE = 0.045
"""Height of a bar that shows rest, in shares of the axes."""


def motion(
    run: Trajectories, *, axes: Sequence[Axes] | None = None, title: str | None = None
) -> tuple[Axes, Axes, Axes]:
    """Draw position, speed and drive force over time, one above the other.

    Phases in which dry friction holds the segment are shaded and named; where
    there are several trajectories, each has its own bar below the speeds. The legend, or
    the title of a single one, says which trajectory fails, why and from when on.

    Parameters
    ----------
    run : Trajectories
        From ``locosweep.simulate``, with one to eight trajectories.
    axes : sequence of Axes, optional
        Three, for position, speed and force; default those of a figure of pyplot.
    title : str, optional
        Default: law, drive and method.

    Returns
    -------
    tuple of Axes
        For position, speed and force.

    Raises
    ------
    InputError
        Too many trajectories, or not three axes.

    Examples
    --------
    >>> import locosweep as ls
    >>> from locosweep.plot import motion
    >>> run = ls.simulate(law="coulomb", drive="sine", mu_coulomb=0.3, drive_amplitude=2)
    >>> [ax.get_ylabel() for ax in motion(run)]
    ['position $x$ [m]', 'speed $v$ [m/s]', 'drive force $F_P$ [N]']
    """
    shape = run.x.shape[:-1]
    count = prod(shape)
    if not 1 <= count <= len(style.LINES):
        raise InputError(f"{count} trajectories: a picture has 1 to {len(style.LINES)}")
    if axes is None:
        axes = current_figure(8.0, 7.0).subplots(3, 1, sharex=True)
    if len(axes) != 3:
        raise InputError(f"axes has {len(axes)} entries: allowed are 3")
    top, middle, bottom = axes
    times = np.broadcast_to(run.t, run.x.shape).reshape(count, -1)
    fields = [getattr(run, name).reshape(count, -1) for name in ("x", "v", "force")]
    for ax, field in zip((top, middle, bottom), fields, strict=True):
        style.zero_line(ax)
        for rank, (t, values) in enumerate(zip(times, field, strict=True)):
            colour, dash, _ = style.LINES[rank]
            # A line of one point would be invisible.
            lone = "o" if np.isfinite(values).sum() == 1 else ""
            ax.plot(t, values, color=colour, linestyle=dash, linewidth=1.5, label=_name(run, rank),
                    marker=lone, clip_on=not lone)  # fmt: skip
        style.grid(ax)
        ax.set_xlim(float(times.min()), float(times.max()))
    top.set_ylabel("position $x$ [m]")
    middle.set_ylabel("speed $v$ [m/s]")
    bottom.set(ylabel="drive force $F_P$ [N]", xlabel="time $t$ [s]")
    # Smooth laws never hold, and bristles always yield a little.
    if law(run.law).kind == "dry":
        _shade((top, middle, bottom), times, run.way.reshape(count, -1))
    said = title or f"law {run.law}, drive {run.drive}, method {run.method}"
    if count == 1 and run.status.any():
        said += f"\n{_name(run, 0)}"
    top.set_title(said, fontsize=10, loc="left")
    if count > 1:
        top.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8, frameon=False,
                   handlelength=2.6)  # fmt: skip
    return top, middle, bottom


def _name(run: Trajectories, rank: int) -> str:
    """Say which point of the grid a curve is."""
    shape = run.x.shape[:-1]
    index = tuple(int(i) for i in np.unravel_index(rank, shape)) if shape else ()
    words = [
        style.setting(name, float(values[i]))
        for (name, values), i in zip(run.axes.items(), index, strict=True)
    ]
    status, since = run.failure(index)
    if status:
        end = "" if since is None else f", no values from {since:g} s on"
        fate = f"{status.name.lower()}{end}"
        return ",\n".join([", ".join(words), fate]) if words else fate
    return ", ".join(words)


def _shade(axes: tuple[Axes, Axes, Axes], times: Floats, sliding: Floats) -> None:
    spells = [_spells(t, held == 0) for t, held in zip(times, sliding, strict=True)]
    if not any(spells):
        return
    middle = axes[1]
    if len(spells) == 1:
        for ax in axes:
            for begin, length in spells[0]:
                ax.axvspan(begin, begin + length, color=_REST, linewidth=0, zorder=-1)
        # Above the axes, where it covers no data.
        entry = Patch(color=_REST, label="at rest, held by friction")
        axes[0].legend(handles=[entry], loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=8,
                       borderaxespad=0.1, frameon=False)  # fmt: skip
        return
    low, high = middle.get_ylim()
    room = _LANE * (len(spells) + 2)
    middle.set_ylim(low - (high - low) * room / (1 - room), high)
    for rank, spell in enumerate(spells):
        colour, _, _ = style.LINES[rank]
        height = _LANE * (len(spells) - rank)
        middle.broken_barh(spell, (height - 0.4 * _LANE, 0.7 * _LANE), color=colour, alpha=0.75,
                           linewidth=0, transform=middle.get_xaxis_transform())  # fmt: skip
    middle.annotate(
        "bars: at rest, held by friction", (0.995, _LANE * (len(spells) + 0.8)),
        xycoords="axes fraction", ha="right", va="bottom", fontsize=8, color="0.25",
    )  # fmt: skip


def _spells(t: Floats, held: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Begin and length of each run of samples at rest, half a step wider at both ends."""
    change = np.diff(np.concatenate([[False], held, [False]]).astype(np.int8))
    first, last = np.flatnonzero(change == 1), np.flatnonzero(change == -1) - 1
    edges = np.concatenate([t[:1], (t[1:] + t[:-1]) / 2, t[-1:]])
    return [
        (float(edges[a]), float(edges[b + 1] - edges[a])) for a, b in zip(first, last, strict=True)
    ]
