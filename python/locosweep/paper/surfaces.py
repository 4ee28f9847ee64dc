"""The paper's experiment on three surfaces: Figures 10, 12 and 13 and what the text says of them.

The paper measured; here the head's stroke is simulated. What the paper does not
state is assumed, and every row and picture says so.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from locosweep.engine import sweep
from locosweep.grid import Grid
from locosweep.paper.claims import FIGURE_2, Row, judge
from locosweep.plot import style
from locosweep.plot.gait import line
from locosweep.registry import parameter
from locosweep.simulation.gait import run_gait
from locosweep.simulation.trajectories import simulate

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from locosweep.result import Result

    Floats = NDArray[np.float64]

GROUND = {"mu_static": 0.3, "mu_coulomb": 0.15}
"""Friction coefficients of Figure 5: with Figure 2's 0.3 the drive would hardly exceed friction."""

_SEGMENTS, _STROKE = 4, 0.02
_SUPPLY = 10.0
"""Supply voltage in V at which the paper states its actuator's force."""
SURFACES = {
    "dry": {"viscous": 0.0, "buildup": 0.0},
    "oil": {"viscous": 0.2, "buildup": 0.0},
    "lubricant": {"viscous": 0.2, "buildup": 5.0},
}
"""Viscous friction in N s/m, and lubricant piled up before the segment in N/m."""

_ASSUMED = "assumed: stroke 20 mm, oil and lubricant 0.2 N s/m, build-up 5 N/m, motor 20 ohm"
_PHASE, _NEARLY = 0.4, 0.95
"""Duration in s of a phase of the whole robot; share of its stroke that counts as arrival."""
_NEAR = 0.1
"""Share within which numbers count as nearly the same."""


@dataclass(frozen=True)
class Head:
    """One stroke of the head: time in s, displacement in m, force in N, power in W."""

    t: Floats
    x: Floats
    force: Floats
    power: Floats
    result: Result

    @property
    def arrival(self) -> float:
        """When the stroke has ended, in s."""
        return float(self.t[-1])


def _default(name: str) -> float:
    value = parameter(name).default
    if value is None:
        raise AssertionError(f"{name} has no default")
    return value


def _motor() -> tuple[float, float]:
    """Force in N at constant voltage at a standstill, and its loss in N per m/s.

    The motor pushes with F = k (U - k v)/R: a constant force, and a part that falls
    with speed and so adds to viscous friction in the equation of motion.
    """
    resistance, constant = (_default(name) for name in ("winding_resistance", "force_constant"))
    return constant * _SUPPLY / resistance, constant**2 / resistance


def _head(surface: str) -> Head:
    constant = _default("force_constant")
    stall, loss = _motor()
    ground = SURFACES[surface]
    given = {
        "mu_coulomb": GROUND["mu_coulomb"],
        "viscous": ground["viscous"] + loss,
        "buildup": ground["buildup"],
        "drive_force": stall,
    }
    result = sweep("stroke_time", Grid(stroke=_STROKE, duration=1.0, **given), law="buildup")
    run = simulate(Grid(duration=float(result.values), **given), law="buildup", samples=401)
    force = stall - loss * run.v
    return Head(run.t, run.x, force, _SUPPLY * force / constant, result)


def strokes() -> dict[str, Head]:
    """Return the head's stroke on each surface."""
    return {surface: _head(surface) for surface in SURFACES}


def _rear() -> tuple[Floats, Floats]:
    """Time and displacement of the rear while the head moves, in the whole robot."""
    run = run_gait(
        "single", segments=_SEGMENTS, stroke=_STROKE, mu_static=GROUND["mu_static"],
        mu_coulomb=GROUND["mu_coulomb"], drive_limit=_motor()[0], dwell=0.05,
        break_away=0, impact=0, cycles=1, samples=2001,
    )  # fmt: skip
    first = run.phase == 0
    return run.t[first], run.x[first, -1]


def _sampled(heads: dict[str, Head], name: str) -> list[Floats]:
    """One number on all surfaces at common times, as long as all heads move."""
    times = np.linspace(0.0, min(head.arrival for head in heads.values()), 401)
    return [np.interp(times, head.t, getattr(head, name)) for head in heads.values()]


def _displacement() -> list[Row]:
    heads = strokes()
    times = [head.arrival for head in heads.values()]
    dry, oil, lubricant = times
    gap = float(max(np.ptp(np.array(_sampled(heads, "x")), axis=0)))
    _, rear = _rear()
    moved = float(np.abs(rear).max())
    hold, strong = (
        float(sweep("propulsive_force", Grid(segments=_SEGMENTS, **mu)).values)
        for mu in (GROUND, FIGURE_2)
    )
    drive = float(heads["dry"].force[0])
    return [
        Row(
            "Head displacements on dry, oiled and lubricated pipe are almost equal",
            "Figure 10",
            "almost equal",
            f"at most {1000 * gap:.2g} of 20 mm apart; 20 mm after "
            + ", ".join(f"{t:.4f}" for t in times) + " s",
            judge(gap < _NEAR * _STROKE),
            f"almost: within {_NEAR:.0%} of the stroke; {_ASSUMED}",
        ),
        Row(
            "The lubricated segment arrives later",
            "Figures 10, 11",
            "later",
            f"{lubricant / dry - 1:.1%} later than dry, {lubricant / oil - 1:.1%} than oil",
            judge(lubricant > max(dry, oil)),
            "the paper sees lubricant pile up; with the assumed build-up force it must be later: "
            "this shows how much, not why",
        ),
        Row(
            "The rear stands still: its anchors hold far more than the drive gives",
            "Figure 10",
            "0 mm, 0.85 N, 3.2 N",
            f"{1000 * moved:g} mm; {drive:.2f} N is {drive / hold:.0%} of {hold:.3g} N, "
            f"{drive / strong:.0%} of {strong:.3g} N",
            judge(moved == 0.0 and 2 * drive <= hold),
            "whole robot simulated; anchors with μ_S 0.3 and 0.5, also where oiled (assumed); "
            "far: at most half",
        ),
    ]  # fmt: skip


def _arrivals(buildup: float) -> Floats:
    """When each segment of the whole robot has gone nearly its stroke, from its phase's start.

    A joint's force then still is the drive's limit: its spring takes over just before the end.
    """
    surface = SURFACES["lubricant"]
    run = run_gait(
        "single", segments=_SEGMENTS, stroke=_STROKE, mu_static=FIGURE_2["mu_static"],
        mu_coulomb=GROUND["mu_coulomb"], viscous=surface["viscous"], buildup=buildup,
        drive_limit=_motor()[0], joint_stiffness=2e3, joint_damping=20.0, dwell=_PHASE,
        time_step=1e-4, break_away=0, cycles=1, every=1e-4,
    )  # fmt: skip
    starts = _PHASE * np.arange(_SEGMENTS)
    arrivals: Floats = run.t[np.argmax(run.x > _NEARLY * _STROKE, axis=0)]
    return arrivals - starts


def _swept() -> Row:
    """Only the head of the whole robot finds fresh lubricant."""
    later = _arrivals(SURFACES["lubricant"]["buildup"]) / _arrivals(0.0) - 1
    followers = float(np.abs(later[1:]).max())
    return Row(
        "Build-up in the whole robot: it delays the head, followers find the pipe swept",
        "Figures 10, 11",
        "later",
        f"head {later[0]:.1%} later than without build-up, followers at most {followers:.2%} off",
        judge(bool(later[0] > 10 * followers)),
        f"four elastic segments at {_NEARLY:.0%} of the stroke; anchors with μ_S 0.5; {_ASSUMED}",
    )


def _same(name: str, words: str, source: str, unit: str) -> list[Row]:
    heads = strokes()
    table = np.array(_sampled(heads, name))
    apart = float((np.ptp(table, axis=0) / table[0]).max())
    last = [float(getattr(head, name)[-1]) for head in heads.values()]
    first = float(getattr(heads["dry"], name)[0])
    return [
        Row(
            f"{words} is nearly the same on the three surfaces",
            source,
            "nearly the same",
            f"{apart:.1%} apart at most; {first:.3g} {unit} at the start, then "
            + ", ".join(f"{value:.3g}" for value in last) + f" {unit} at 20 mm",
            judge(apart < _NEAR),
            f"nearly: within {_NEAR:.0%} at any time; {_ASSUMED}",
        )
    ]  # fmt: skip


def _drawn(number: int, title: str, name: str, label: str, scale: float) -> tuple[Figure, Axes,
                                                                        list[Result]]:  # fmt: skip
    figure = style.figure(9.0, 5.6)
    ax = figure.subplots()
    heads = strokes()
    for rank, (surface, head) in enumerate(heads.items()):
        line(head.t, scale * getattr(head, name), ax, label=label, rank=rank,
             name=f"head, {surface}: 20 mm after {head.arrival:.4f} s")  # fmt: skip
        ax.plot(head.t[-1], scale * getattr(head, name)[-1], "o", color=ax.lines[-1].get_color())
    ax.set(xlabel="time $t$ [s]", xlim=(0, 1.03 * max(h.arrival for h in heads.values())))
    figure.suptitle(
        f"Figure {number}: {title}, 10 V, μ 0.3/0.15\n{_ASSUMED}; the paper's are measurements",
        fontsize=11,
    )
    return figure, ax, [head.result for head in heads.values()]


def _enlarged(ax: Axes) -> None:
    """Show once more, below the curves, what lies so close together."""
    small = ax.inset_axes((0.5, 0.07, 0.46, 0.27))
    curves = [drawn for drawn in ax.lines if len(drawn.get_xdata()) > 2]  # type: ignore[arg-type]
    for drawn in curves:
        small.plot(*drawn.get_data(), color=drawn.get_color(), linestyle=drawn.get_linestyle())
    small.set_title("enlarged", fontsize=9)
    small.tick_params(labelsize=8)
    style.grid(small)
    small.margins(x=0)


def _figure_10() -> tuple[Figure, list[Result]]:
    figure, ax, results = _drawn(
        10, "displacement of head and rear on three surfaces", "x", "displacement $x$ [mm]", 1000.0
    )
    t, rear = _rear()
    ax.plot(t, 1000 * rear, color="black", linewidth=2.2, label="rear, every surface: stands still")
    ax.legend(loc="upper left", fontsize=9, handlelength=3)
    return figure, results


def _figure_12() -> tuple[Figure, list[Result]]:
    figure, ax, results = _drawn(
        12, "propulsive force of the head segment", "force", "propulsive force $F_P$ [N]", 1.0
    )
    drag = float(sweep("resistance", mu_coulomb=GROUND["mu_coulomb"]).values)
    ax.axhline(drag, color="0.3", linewidth=1.0, linestyle=(0, (6, 3)),
               label=f"dry friction {drag:.3g} N")  # fmt: skip
    ax.set_ylim(0, 1)
    _enlarged(ax)
    ax.legend(loc="lower left", fontsize=9, handlelength=3)
    return figure, results


def _figure_13() -> tuple[Figure, list[Result]]:
    figure, ax, results = _drawn(
        13, "electric power of the head segment", "power", "electrical power $P$ [W]", 1.0
    )
    ax.set_ylim(0, 6)
    _enlarged(ax)
    ax.legend(loc="lower left", fontsize=9, handlelength=3)
    return figure, results


SURFACE_CLAIMS: dict[int, Callable[[], list[Row]]] = {
    10: lambda: [*_displacement(), _swept()],
    12: partial(_same, "force", "Propulsive force of the head segment", "Figure 12", "N"),
    13: partial(_same, "power", "Electric power of the head segment", "Figure 13", "W"),
}
SURFACE_FIGURES: dict[int, Callable[[], tuple[Figure, list[Result]]]] = {
    10: _figure_10,
    12: _figure_12,
    13: _figure_13,
}
"""By figure, as ``claims.CLAIMS`` and ``figures.FIGURES``."""
