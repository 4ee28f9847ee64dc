"""Pictures of a whole robot in motion: where its segments are, who holds, forces, power."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import CenteredNorm
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from locosweep.plot import style
from locosweep.plot.current import current_axes
from locosweep.plot.numbers import PlainNumbers, plain_numbers

if TYPE_CHECKING:
    from collections.abc import Iterable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from locosweep.simulation.gait import GaitRun

    Floats = NDArray[np.float64]

_STATES = (
    (0, "anchored", "#b9d3e6", None),
    (1, "slides forward", "#e69f00", None),
    (-1, "slides backward", "#7a0177", "////"),
)
"""Sliding, words, colour and hatch. The colours differ in lightness too."""

_HEAP = "#5b3a1e"
"""Colour of lubricant."""
_MM = 1000.0
_WIDTH = 11.0
"""Width of a figure in inches."""
_MANY = 12
"""Segments beyond which not each one is labelled."""


def space_time(run: GaitRun, ax: Axes | None = None) -> Axes:
    """Draw each segment as a band over time: its position and direction of sliding.

    What it pushes along of a lubricant is a strip before the band, as wide as there is
    fresh ground swept.

    Parameters
    ----------
    run : GaitRun
        From ``locosweep.run_gait``.
    ax : Axes, optional
        Where to draw; default the current axes of pyplot while they are empty.

    Examples
    --------
    >>> import locosweep as ls
    >>> from locosweep.plot.gait import space_time
    >>> run = ls.run_gait("single", segments=3, mu_static=0.5, mu_coulomb=0.3,
    ...                   drive_limit=0.85, break_away=0, cycles=1)
    >>> space_time(run).get_xlabel()
    'time $t$ [s]'
    """
    x = _MM * run.x
    count = x.shape[1]
    ax = current_axes(ax, _WIDTH, _height(count))
    # Segments have no length in the model: the picture gives them room to part in.
    nearest = min(0.0, float((x[:, :-1] - x[:, 1:]).min()))
    reach = float(np.ptp(x[:, :-1] - x[:, 1:])) or 1.0
    room = 1.1 * reach - nearest
    half = 0.4 * reach
    # The widest strip just fits between two bands.
    most = float(run.heap.max())
    wide = 0.28 * reach / most if most else 0.0
    for i in range(count):
        middle = x[:, i] - i * room
        for state, _, colour, hatch in _STATES:
            # A sample belongs to the stretch that it begins.
            here = _with_ends(run.sliding[:, i] == state)
            ax.fill_between(
                run.t, middle - half, middle + half, where=here, facecolor=colour, hatch=hatch,
                edgecolor="white" if hatch else "none", linewidth=0.0,
            )  # fmt: skip
        front = middle + half
        heap = run.heap[:, i]
        ax.fill_between(
            run.t, front, front + wide * heap, where=_with_ends(heap > 0), facecolor=_HEAP,
            linewidth=0.0,
        )  # fmt: skip
        ax.plot(run.t, middle, color="0.15", linewidth=0.9)
        if count <= _MANY or i % 4 == 0 or i == count - 1:
            ax.annotate(_name(i, count), (run.t[-1], middle[-1]), xytext=(5, 0), fontsize=8,
                        textcoords="offset points", va="center", annotation_clip=False)  # fmt: skip
    _cycles(run, ax)
    ax.set(xlabel="time $t$ [s]", ylabel=f"position [mm], segments drawn {room:.3g} mm apart")
    ax.margins(x=0)
    plain_numbers(ax)
    seen = [entry for entry in _STATES if (run.sliding == entry[0]).any()]
    handles = [
        Patch(facecolor=colour, hatch=hatch, edgecolor="white" if hatch else "0.5", linewidth=0.4,
              label=words)
        for _, words, colour, hatch in seen
    ]  # fmt: skip
    if most:
        fresh = style.with_unit(_MM * most, "mm")
        words = f"lubricant pushed ahead, of up to {fresh} of fresh ground"
        handles.append(Patch(facecolor=_HEAP, label=words))
    ax.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, fontsize=9,
              frameon=False, borderaxespad=0.2)  # fmt: skip
    return ax


def _with_ends(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Extend each stretch to the sample that ends it, so that bands have no gaps."""
    wide = mask.copy()
    wide[1:] |= mask[:-1]
    return wide


def _name(i: int, count: int) -> str:
    return "head" if i == 0 else "rear" if i == count - 1 else f"{i + 1}"


def _cycles(run: GaitRun, ax: Axes) -> None:
    """Mark where cycles begin."""
    for i in np.flatnonzero(np.diff(run.phase) < 0) + 1:
        ax.axvline(run.t[i], color="0.35", linewidth=0.8, linestyle=(0, (1, 2)), zorder=3)


def line(t: Floats, values: Floats, ax: Axes, *, label: str, rank: int = 0,
         name: str | None = None) -> Axes:  # fmt: skip
    """Draw one number over time; ``label`` has its unit, ``rank`` picks its look."""
    colour, dash, _ = style.LINES[rank]
    style.zero_line(ax)
    ax.plot(t, values, color=colour, linestyle=dash, linewidth=1.6, label=name)
    ax.set_ylabel(label)
    style.grid(ax)
    ax.margins(x=0)
    return ax


def joint_forces(run: GaitRun, ax: Axes) -> Axes:
    """Draw the force of every joint's actuator over time as colours, the head on top."""
    joints = run.force.shape[1]
    last = run.t[-1] - run.t[-2] if len(run.t) > 1 else run.results["time"]
    edges = np.concatenate([run.t, [run.t[-1] + last]])
    most = float(np.abs(run.force).max()) or 1.0
    mesh = ax.pcolormesh(
        edges, np.arange(joints + 1) + 0.5, run.force.T, cmap=style.DIVERGING,
        norm=CenteredNorm(0.0, most), rasterized=True,
    )  # fmt: skip
    ax.set(
        ylabel="joint, from the head",
        ylim=(joints + 0.5, 0.5),
        xlim=(run.t[0], run.t[-1] if len(run.t) > 1 else edges[-1]),
    )
    ax.yaxis.set_major_locator(MaxNLocator(8, integer=True))
    plain_numbers(ax)
    figure = ax.get_figure(root=True)
    if figure is not None:
        bar = figure.colorbar(mesh, ax=ax, pad=0.01, format=PlainNumbers())
        bar.set_label(
            "joint force $F_\\mathrm{j}$ [N]\n− pulls together, + pushes apart", fontsize=9
        )
    return ax


def _height(segments: int) -> float:
    """Return the height in inches at which bands stay apart."""
    return min(12.0, 4.0 + 0.45 * segments)


def space_time_figure(run: GaitRun, title: str) -> Figure:
    """Return the space-time picture as a figure of its own."""
    figure = style.figure(_WIDTH, _height(run.x.shape[1]))
    space_time(run, figure.subplots())
    figure.suptitle(title, fontsize=11)
    return figure


def force_power(run: GaitRun, title: str) -> Figure:
    """Return propulsive force, joint forces and electrical power as a figure."""
    figure = style.figure(_WIDTH, 8.5)
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    line(run.t, run.propulsive, top, label="propulsive force $F_P$ [N]")
    joint_forces(run, middle)
    line(run.t, run.power, bottom, label="electrical power $P$ [W]")
    levels: Iterable[tuple[Axes, str, str]] = (
        (top, "propulsive_mean", "N"), (bottom, "power_mean", "W"),
    )  # fmt: skip
    for ax, name, unit in levels:
        mean = run.results[name]
        ax.axhline(mean, color="0.3", linewidth=1.0, linestyle=(0, (6, 3)))
        when = "mean while driven" if name == "propulsive_mean" else "mean"
        ax.annotate(f"{when} {style.with_unit(mean, unit)}", (1.0, mean), ha="right", va="bottom",
                    xytext=(-4, 2), textcoords="offset points", fontsize=8.5, color="0.2",
                    xycoords=("axes fraction", "data"),
                    bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.8},
                    )  # fmt: skip
    for ax in (top, middle, bottom):
        _cycles(run, ax)
    bottom.set_xlabel("time $t$ [s]")
    figure.suptitle(title, fontsize=11)
    return figure
