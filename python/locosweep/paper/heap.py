"""Figure 11: the lubricant before the head, as an illustration.

The paper prints no numbers. Motion and force are those of the stroke of Figure 10; the heap's
shape follows from the volume of an assumed layer alone.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core
from locosweep.paper.surfaces import GROUND, SURFACES, strokes
from locosweep.plot import style
from locosweep.plot.gait import line
from locosweep.registry import parameter

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from locosweep.paper.surfaces import Head
    from locosweep.result import Result

    Floats = NDArray[np.float64]

_LAYER = 0.5e-3
"""Assumed thickness of the lubricant on the pipe in m, all of which is scraped up."""
_FRONT_DEG = 30.0
"""Assumed slope of the heap's front."""
_PLACES = (0.005, 0.010, 0.020)
"""Ways of the head in m at which the heap is drawn."""
_MM = 1e3


def heap_force(t: Floats, way: Floats, surface: str) -> Floats:
    """Return what the heap adds to friction in N along a motion forward, by the engine's law."""
    weight = np.full(t.size, _weight())
    contact = {"mu_coulomb": GROUND["mu_coulomb"], **SURFACES[surface]}
    with_heap, without = (
        np.asarray(
            _core.imposed_force(
                "buildup", list(given.items()), t, way, np.gradient(way, t), weight,
                np.zeros(t.size),
            ),
            dtype=np.float64,
        )
        for given in (contact, contact | {"buildup": 0.0})
    )  # fmt: skip
    return with_heap - without


def _weight() -> float:
    mass, gravity = (parameter(name).default or 0.0 for name in ("mass", "gravity"))
    return mass * gravity


def heap_size(way: float) -> tuple[float, float]:
    """Return length and height in m of the heap after the head has moved this far.

    A wedge that holds all of the layer scraped up: height H, length H / tan of the front's
    slope, area H^2 / (2 tan) = layer times way.
    """
    slope = np.tan(np.radians(_FRONT_DEG))
    height = float(np.sqrt(2 * _LAYER * way * slope))
    return height / slope, height


def _motion(ax: Axes, heads: dict[str, Head]) -> None:
    small = ax.inset_axes((0.58, 0.09, 0.32, 0.26))
    late = min(head.arrival for head in heads.values())
    for surface, head in heads.items():
        rank = list(SURFACES).index(surface)
        line(head.t, _MM * head.x, ax, label="displacement of the head $x$ [mm]", rank=rank,
             name=f"{surface}: 20 mm after {head.arrival:.4f} s")  # fmt: skip
        colour, dash, _ = style.LINES[rank]
        end = head.t > 0.94 * late
        small.plot(head.t[end], _MM * head.x[end], color=colour, linestyle=dash, linewidth=1.4)
    small.set_title("enlarged", fontsize=8)
    small.tick_params(labelsize=7)
    small.locator_params(nbins=3)
    small.yaxis.tick_right()
    small.margins(x=0)
    style.grid(small)
    ax.set_xlabel("time $t$ [s]")
    ax.set_title("head", fontsize=10)
    ax.legend(loc="upper left", fontsize=8.5, handlelength=3)


def _push(ax: Axes, heads: dict[str, Head]) -> None:
    dry = GROUND["mu_coulomb"] * _weight()
    for surface, head in heads.items():
        force = heap_force(head.t, head.x, surface)
        rank = list(SURFACES).index(surface)
        colour, dash, _ = style.LINES[rank]
        share = f", {force[-1] / dry:.0%} of the dry friction {dry:.3g} N" if force[-1] else ""
        ax.plot(_MM * head.x, force, color=colour, linestyle=dash, linewidth=1.8, clip_on=False,
                label=f"{surface}: {force[-1]:.3g} N at 20 mm{share}")  # fmt: skip
    ax.set(xlabel="displacement of the head $x$ [mm]", ylabel="force of the heap $F_b$ [N]")
    ax.set(xlim=(0, _MM * _PLACES[-1]), ylim=(0, 0.14))
    ax.set_title("force before the head", fontsize=10)
    style.grid(ax)
    ax.legend(loc="upper left", fontsize=8.5, handlelength=3)


def _shape(ax: Axes) -> None:
    layer, edge = _MM * _LAYER, _MM * 1.6 * heap_size(_PLACES[-1])[0]
    ax.axhspan(0, layer, color="0.85", zorder=0, label=f"layer of {layer:g} mm")
    for rank, way in enumerate(_PLACES):
        length, height = (_MM * size for size in heap_size(way))
        colour, dash, _ = style.LINES[rank + 3]
        ax.plot([0, 0, length], [layer, layer + height, layer], color=colour, linestyle=dash,
                linewidth=1.8,
                label=f"x = {_MM * way:g} mm: {length:.2g} mm long, {height:.2g} mm high",
                )  # fmt: skip
    ax.axvspan(-0.25 * edge, 0, color="0.55", zorder=0)
    ax.text(-0.125 * edge, 0.3 * edge, "head", rotation=90, ha="center", va="center", fontsize=10)
    ax.set(xlim=(-0.25 * edge, edge), ylim=(0, 0.95 * edge), aspect="equal")
    ax.set(xlabel="distance before the head [mm]", ylabel="height above the pipe [mm]")
    ax.set_title("heap, to scale", fontsize=10)
    ax.legend(loc="upper right", fontsize=8.5, handlelength=3)


def _figure_11() -> tuple[Figure, list[Result]]:
    heads = strokes()
    del heads["dry"]
    figure = style.figure(15.0, 5.6)
    motion, push, shape = figure.subplots(1, 3)
    _motion(motion, heads)
    _push(push, heads)
    _shape(shape)
    figure.suptitle(
        "Figure 11: lubricant before the head, against oil. Illustration: the paper prints no "
        f"numbers\nassumed: build-up {SURFACES['lubricant']['buildup']:g} N/m, both "
        f"{SURFACES['oil']['viscous']:g} N s/m, motor 20 ohm at 10 V; layer {_MM * _LAYER:g} mm, "
        f"all scraped up, front at {_FRONT_DEG:g} deg (the shape does not enter the force)",
        fontsize=11,
    )
    return figure, [head.result for head in heads.values()]


HEAP_FIGURES: dict[int, Callable[[], tuple[Figure, list[Result]]]] = {11: _figure_11}
"""By figure, as ``figures.FIGURES``."""
