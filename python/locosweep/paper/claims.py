"""Claims of the paper, each beside the value computed here.

Every number is computed by the engine when asked for, and every verdict is a
comparison with the stated value.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from locosweep.engine import sweep
from locosweep.grid import Grid
from locosweep.registry import parameter

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from locosweep.files.robot import Robot
    from locosweep.result import Result

Verdict = Literal["agrees", "differs", "ambiguous in the paper"]

VARIANTS = {
    1: "w = 1 (anchors hold their own weight)",
    0: "w = 0 (anchors' own weight left out)",
}
"""Both readings of the paper's slope terms, by ``anchor_weight``."""

FIGURE_2 = {"mu_static": 0.5, "mu_coulomb": 0.3}
FIGURE_5 = {"mu_static": 0.3, "mu_coulomb": 0.15, "segments": 3}
VISCOUS = 0.5
DRIVE = 0.85


@dataclass(frozen=True)
class Row:
    """One claim of the paper, its source, the paper's value and ours with units, and the verdict.

    A verdict is ambiguous where the text allows readings that disagree; `note` gives its rule.
    """

    claim: str
    source: str
    paper: str
    ours: str
    verdict: Verdict
    note: str = ""


def judge(*readings: bool) -> Verdict:
    """One truth for each reading that the text allows."""
    if all(readings):
        return "agrees"
    return "ambiguous in the paper" if any(readings) else "differs"


def _number(quantity: str, **fixed: float) -> float:
    return float(sweep(quantity, Grid(**fixed)).values)


def _text() -> list[Row]:
    return [*_equal_friction(), *_forces(), *_times(), *_inputs()]


def _equal_friction() -> list[Row]:
    mu = np.linspace(0.05, 1.0, 20)
    names = ["optimal_segments", "best_segments"]
    both = sweep(names, mu_static=mu, mu_coulomb=mu, anchor_weight=list(VARIANTS))
    real, whole = (np.einsum("iij->ij", both[name]) for name in names)
    low, high = float(real.min()), float(real.max())
    equal = {"mu_static": 0.5, "mu_coulomb": 0.5}
    free, braked = (_number("best_segments", brake=brake, **equal) for brake in (0, 1))
    spans = {w: _span_of_four(w) for w in VARIANTS}
    four = any(len(span) for span in spans.values())
    return [
        Row(
            "Four segments are best on the flat with equal coefficients",
            "text, (8)",
            "N = 4",
            f"N_opt = {_range(low, high)}, whole: {_range(whole.min(), whole.max())}",
            judge(max(abs(low - 4), abs(high - 4)) < 1e-9 and bool((whole == 4).all())),
            "μ from 0.05 to 1, w = 1 and w = 0",
        ),
        Row(
            "Each phase only accelerates, without braking",
            "text, before (6)",
            "N = 4",
            f"N* = {free:.0f} without brake, {braked:.0f} with it",
            judge(free == 4 and braked != 4),
            "equal coefficients, flat: only the phase without brake gives four",
        ),
        Row(
            "Four segments are best only for equal coefficients",
            "conclusion",
            "N = 4 only there",
            f"N* = 4 also with 0.5/0.3, {_span_text(spans[1])} (w = 1)",
            judge(not four, four),
            "Figure 2 states four with 0.5/0.3: conclusion and figure cannot both hold",
        ),
    ]


def _range(low: float, high: float) -> str:
    texts = [f"{value:.10g}" for value in (low, high)]
    return texts[0] if texts[0] == texts[1] else " to ".join(texts)


def _forces() -> list[Row]:
    robot = {**FIGURE_2, "segments": 4}
    net, gross = (_number(name, **robot) for name in ("net_force", "propulsive_force"))
    safety = _number("anchor_safety", drive_limit=DRIVE, **robot)
    fewest = _number("best_segments", drive_limit=DRIVE, **FIGURE_2)
    drags = [_number("resistance", mu_coulomb=mu) for mu in (0.3, 0.15)]
    source = "text, 'by (9)'"
    rule = "to the two digits stated, ± 0.05 N"
    return [
        Row(
            "Largest propulsive force, four segments: net of friction",
            source,
            "about 3.2 N",
            f"{net:.4g} N",
            judge(abs(net - 3.2) <= 0.05),
            f"μ 0.5/0.3; {rule}",
        ),
        Row(
            "Largest propulsive force, four segments: gross, as (4)",
            source,
            "about 3.2 N",
            f"{gross:.4g} N",
            judge(abs(gross - 3.2) <= 0.05),
            f"μ 0.5/0.3; {rule}; (9) is a velocity elsewhere: the numbering slipped",
        ),
        Row(
            "The actuator's force is far below what the anchors hold",
            "experiment",
            "0.85 N at 10 V, 3.2 N",
            f"{DRIVE / net:.0%} of {net:.3g} N net; anchors hold {safety:.3g} times the drive",
            judge(min(safety, net / DRIVE) >= 2),
            f"far: at least twice; with this drive the best count is N* = {fewest:.0f}",
        ),
        Row(
            "The propulsive force is far above friction",
            "experiment",
            "0.85 N",
            " and ".join(f"{DRIVE / drag:.3g} times {drag:.3g} N" for drag in drags),
            judge(*(drag * 2 <= DRIVE for drag in drags)),
            "far: at least twice; μ_C 0.3 (Figure 2) and 0.15 (Figure 5), the text does not say",
        ),
    ]


def _times() -> list[Row]:
    counts = np.arange(2, 13)
    names = ["cycle_time", "phase_time"]
    times = sweep(names, Grid(segments=counts, **FIGURE_2))
    rows = []
    for name, words in zip(names, ("cycle time N t", "phase time t"), strict=True):
        values = times[name]
        falls = bool((np.diff(values) < 0).all())
        least = int(counts[np.argmin(values)])
        trend = "falls throughout" if falls else f"falls up to N = {least}, then grows"
        rows.append(
            Row(
                f"Cycle time falls with the number of segments: {words}",
                "text",
                "falls",
                f"{trend}: {values[0]:.3g}, {values.min():.3g}, {values[-1]:.3g} s",
                judge(falls),
                "flat, 0.5/0.3; at N = 2, the least, and at N = 12",
            )
        )
    return rows


def _inputs() -> list[Row]:
    mass, viscous = parameter("mass"), parameter("viscous")
    default = mass.default or 0.0
    return [
        Row(
            "Mass of one segment",
            "experiment",
            "271 g",
            f"{1000 * default:g} g",
            judge(abs(default - 0.271) < 1e-12),
            "default of the parameter mass",
        ),
        Row(
            "Unit of the viscous friction coefficient",
            "text, Figure 5",
            "0.5 Pa s",
            f"{VISCOUS:g} {viscous.unit}",
            judge(viscous.unit == "Pa s", viscous.unit == "N s/m"),
            "equations (10) and (11) need N s/m: force over speed, not a viscosity",
        ),
    ]


def robot_rows(robot: Robot) -> list[Row]:
    """Compare a robot file with what the paper says of its robot."""
    rows = []
    for name, paper in (("segments", 4.0), ("mass", 0.271), ("drive_limit", DRIVE)):
        record = parameter(name)
        unit = "" if record.unit == "1" else f" {record.unit}"
        here = robot.parameters.get(name, record.default)
        given = "not given" if here is None else f"{here:g}{unit}"
        agrees = here is not None and abs(here / paper - 1) < 1e-12
        note = "in the file" if name in robot.parameters else "not in the file: the default"
        rows.append(
            Row(
                f"Robot file: {record.meaning}",
                "experiment",
                f"{paper:g}{unit}",
                given,
                judge(agrees),
                note,
            )
        )
    return rows


def _span_of_four(w: int) -> NDArray[np.float64]:
    """Slopes at which four is the best whole count, with Figure 2's friction."""
    slopes = np.linspace(0, 20, 20_001)
    best = sweep("best_segments", Grid(slope_deg=slopes, anchor_weight=w, **FIGURE_2)).values
    return np.asarray(slopes[best == 4])


def _span_text(slopes: NDArray[np.float64]) -> str:
    return f"from {slopes[0]:.2f} to {slopes[-1]:.2f} deg" if len(slopes) else "nowhere"


def _figure_2() -> list[Row]:
    slopes = np.arange(0, 21, 2)
    rows = []
    for w, words in VARIANTS.items():
        best = sweep("best_segments", Grid(slope_deg=slopes, anchor_weight=w, **FIGURE_2)).values
        hits = best == 4
        text = f"{hits.sum()} of {len(slopes)} slopes; {_span_text(_span_of_four(w))}"
        rows.append(
            Row(
                f"Highest velocity with four segments, {words}",
                "Figure 2",
                "N = 4",
                text,
                judge(*hits.tolist()),
                "slopes 0 to 20 deg in steps of 2; the text does not say at which slopes",
            )
        )
    three, four = sweep("mean_velocity", Grid(segments=[3, 4], **FIGURE_2)).values
    flat = _number("best_segments", **FIGURE_2)
    rows.append(
        Row(
            "Highest velocity with four segments, flat ground",
            "Figure 2",
            "N = 4",
            f"N* = {flat:.0f}; {1000 * three:.2f} and {1000 * four:.2f} mm/s (N = 3, 4)",
            judge(flat == 4),
            f"three is faster by {three / four - 1:.1%}, hardly visible; stroke 20 mm is assumed",
        )
    )
    return rows


def figure_3_force() -> Result:
    """Sweep the propulsive force over slope and segments, for both variants."""
    slopes, counts = np.linspace(0, 20, 41), range(2, 13)
    grid = Grid(anchor_weight=list(VARIANTS), slope_deg=slopes, segments=counts, **FIGURE_2)
    return sweep("propulsive_force", grid)


def _figure_3() -> list[Row]:
    force = figure_3_force().values
    more, steeper = np.diff(force, axis=2), np.diff(force, axis=1)
    variants = range(len(VARIANTS))
    return [
        Row(
            "Propulsive force grows with the number of segments",
            "Figure 3",
            "grows",
            f"{'grows' if (more > 0).all() else 'not always'}: {more.min():.3g} N or more each",
            judge(*(bool((more[i] > 0).all()) for i in variants)),
            "w = 1 and w = 0, slopes 0 to 20 deg, N = 2 to 12",
        ),
        Row(
            "Propulsive force falls with the slope",
            "Figure 3",
            "falls",
            f"{'falls' if (steeper < 0).all() else 'not always'}: "
            f"{force[0, 0, 2]:.3g} to {force[0, -1, 2]:.3g} N (w = 1), "
            f"to {force[1, -1, 2]:.3g} N (w = 0) for N = 4",
            judge(*(bool((steeper[i] < 0).all()) for i in variants)),
            "0 to 20 deg; both variants fall, so this does not tell them apart",
        ),
    ]


def _figure_4() -> list[Row]:
    rows = []
    for (w, words), mu in zip(VARIANTS.items(), (0.5, 0.01), strict=True):
        slopes = np.linspace(0, 70, 70_001)
        values = sweep(
            "optimal_segments", slope_deg=slopes, mu_static=mu, mu_coulomb=mu, anchor_weight=w
        ).values
        high = slopes[values >= 500]
        ends = slopes[np.isfinite(values)][-1]
        text = f"500 at {high[0]:.2f} deg (μ = {mu:g})" if len(high) else "below 500"
        rows.append(
            Row(
                f"Optimal count takes extreme values, {words}",
                "Figure 4",
                "up to 500",
                text,
                judge(bool(len(high))),
                f"pole at tan α = μ, here no value beyond {ends:.2f} deg: the anchors slide"
                if ends < slopes[-1]
                else "no pole: grows steadily with tan α / μ",
            )
        )
    return rows


def crossing(
    time: NDArray[np.float64], one: NDArray[np.float64], other: NDArray[np.float64]
) -> tuple[float, float] | None:
    """Time and value at which two curves cross after their common start."""
    gap = one - other
    apart = np.flatnonzero(gap[1:]) + 1
    turns = np.flatnonzero(np.diff(np.sign(gap[apart])))
    if not len(turns):
        return None
    i, j = apart[turns[0]], apart[turns[0] + 1]
    if j > i + 1:
        return float(time[i + 1]), float(one[i + 1])
    share = gap[i] / (gap[i] - gap[j])
    when, level = (float(v[i] + share * (v[j] - v[i])) for v in (time, one))
    return when, level


def _figure_5() -> list[Row]:
    time = np.linspace(0, 2, 20_001)
    dry = sweep("velocity", Grid(time=time, **FIGURE_5)).values
    force = _number("propulsive_force", **FIGURE_5)
    acceleration = _number("acceleration", **FIGURE_5)
    straight = bool(np.allclose(dry, dry[-1] * time / time[-1], rtol=1e-12))
    rows = [
        Row(
            "Dry velocity grows in proportion to time",
            "Figure 5, (9)",
            "straight line",
            f"{acceleration:.5g} m/s², {np.interp(1.0, time, dry):.5g} m/s at 1 s",
            judge(straight),
            "N = 3, μ 0.3/0.15",
        )
    ]
    for term, words in enumerate(("Coulomb term dropped in (10)", "Coulomb term kept in (10)")):
        wet = {**FIGURE_5, "viscous": VISCOUS, "coulomb_term": term}
        limit = _number("velocity_limit", **wet)
        curve = sweep("velocity", Grid(time=time, **wet)).values
        met = crossing(time, dry, curve)
        rows += [
            Row(
                f"Dry and viscous curves cross, {words}",
                "Figure 5",
                "cross",
                f"at {met[0]:.4g} s, {met[1]:.4g} m/s" if met else "never, dry is always faster",
                judge(met is not None),
                f"viscous {np.interp(1.0, time, curve):.4g} m/s at 1 s",
            ),
            Row(
                f"Limit velocity is F_P / μ_V, {words}",
                "(11)",
                f"F_P/μ_V = {force / VISCOUS:.4g} m/s",
                f"{limit:.4g} m/s",
                judge(abs(limit - force / VISCOUS) <= 1e-9 * limit),
                f"F_P = {force:.4g} N, gross",
            ),
        ]
    return rows


CLAIMS: dict[int, Callable[[], list[Row]]] = {
    0: _text,
    2: _figure_2,
    3: _figure_3,
    4: _figure_4,
    5: _figure_5,
}
"""Rows by figure; 0 for what the text states without one."""
