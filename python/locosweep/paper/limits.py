"""Two claims on limits: the drive that moves other segments too, velocity beyond the best count."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.engine import sweep
from locosweep.grid import Grid
from locosweep.paper.claims import DRIVE, FIGURE_2, VARIANTS, Row, judge
from locosweep.simulation.gait import run_gait

if TYPE_CHECKING:
    from collections.abc import Callable

_SEGMENTS = 4
_STATED = 3.2
"""Drive force in N above which the paper has the other segments move."""
_DIGIT = 0.05
"""Half of the last digit that is stated, in N."""
_CLOSE = 1e-6
"""Width in N down to which the drive is bisected."""
_COUNTS = np.arange(2, 65)
_SLOPES = np.arange(0, 21, 2)
"""In degrees; the text does not say which ones Figure 2 has."""


def ways_of_others(drive: float) -> list[float]:
    """Return how far in mm any other segment moves in each phase, under this drive in N."""
    run = run_gait(
        "single", segments=_SEGMENTS, drive_limit=drive, dwell=0.05, break_away=0, impact=0,
        cycles=1, mu_static=FIGURE_2["mu_static"], mu_coulomb=FIGURE_2["mu_coulomb"],
    )  # fmt: skip
    ways = []
    for mover in range(_SEGMENTS):
        others = np.delete(run.x[run.phase == mover], mover, axis=1)
        ways.append(1000 * float(np.ptp(others, axis=0).max()))
    return ways


def drive_that_moves_others(phases: slice) -> float:
    """Return the drive in N above which other segments move in one of these phases.

    Whole robots are simulated; the drive is bisected from the paper's own upward.
    """

    def moved(drive: float) -> bool:
        return any(ways_of_others(drive)[phases])

    holds, moves = DRIVE, 2 * DRIVE
    while not moved(moves):
        holds, moves = moves, 2 * moves
    while moves - holds > _CLOSE:
        middle = (holds + moves) / 2
        if moved(middle):
            moves = middle
        else:
            holds = middle
    return moves


def _others_move() -> list[Row]:
    head = drive_that_moves_others(slice(0, 1))
    any_phase = drive_that_moves_others(slice(None))
    beyond = _STATED + _DIGIT
    still = ways_of_others(beyond)[0]
    names = ["propulsive_force", "net_force"]
    held = sweep(names, Grid(segments=_SEGMENTS, **FIGURE_2))
    gross, net = (float(held[name]) for name in names)
    return [
        Row(
            "The other segments move once the drive exceeds the anchoring limit",
            "text",
            "above 3.2 N",
            f"above {head:.4g} N; at {beyond:g} N they move {still:.3g} mm",
            judge(abs(head - _STATED) <= _DIGIT),
            f"whole robots simulated, head's stroke, μ 0.5/0.3: anchors hold (N - 1) μ_S m g = "
            f"{gross:.4g} N, the net force is {net:.4g} N; inner segments have a second joint, "
            f"whose lone anchor ahead slides above {any_phase:.4g} N",
        )
    ]


def _beyond_optimum() -> list[Row]:
    grid = Grid(anchor_weight=list(VARIANTS), slope_deg=_SLOPES, segments=_COUNTS, **FIGURE_2)
    velocity = 1000 * sweep("mean_velocity", grid).values
    best = np.nanargmax(velocity, axis=2)
    falls = np.array(
        [
            [
                bool((np.diff(curve[top:]) < 0).all())
                for curve, top in zip(curves, tops, strict=True)
            ]
            for curves, tops in zip(velocity, best, strict=True)
        ]
    )
    texts = []
    for w, curves, tops, down in zip(VARIANTS, velocity, best, falls, strict=True):
        ends = []
        for i in (0, -1):
            count = int(_COUNTS[tops[i]])
            shown = (count, 2 * count, int(_COUNTS[-1]))
            speeds = ", ".join(f"{curves[i][np.equal(_COUNTS, n)][0]:.3g}" for n in shown)
            ends.append(f"{_SLOPES[i]} deg {speeds} mm/s (N = {', '.join(map(str, shown))})")
        texts.append(f"w = {w}: at {down.sum()} of {len(_SLOPES)} slopes, {'; '.join(ends)}")
    return [
        Row(
            "Velocity falls with the number of segments beyond the optimum",
            "Figure 2",
            "falls",
            ". ".join(texts),
            judge(*(bool(down.all()) for down in falls)),
            f"from the best count on, then twice of it, up to N = {_COUNTS[-1]}; slopes "
            "0 to 20 deg in steps of 2; closed form, stroke 20 mm is assumed",
        )
    ]


LIMIT_CLAIMS: dict[int, Callable[[], list[Row]]] = {0: _others_move, 2: _beyond_optimum}
"""By figure, as ``claims.CLAIMS``."""
