"""Sentences of a report: its verdict, and what stands out in runs and windows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.report.localization import by_run, windows

if TYPE_CHECKING:
    from locosweep.diagnosis.report.comparison import Comparison

_FEW = 0.05
"""Part of a run's error whose fall is no fall."""
_UNUSUAL = 3.0
"""Error of a run over the median of all runs, from which it is unusual."""
_RESTING = 0.01
"""Part of a run's steps beyond the noise, below which its head hardly ever moves."""
_MOST, _MANY = 0.4, 20
"""Share of the squared error that one window of so many should not hold."""


def _said(name: str) -> str:
    return name.replace("_", " ")


def _near(nearest: dict[str, Any], candidates: list[dict[str, Any]]) -> str:
    """Say how much the nearest effects would take away, without calling them the cause."""
    sets = [nearest["effects"], *nearest["as_near"]]
    shown = " or, as well, ".join(" with ".join(map(_said, names)) for names in sets[:3])
    if len(sets) > 3:
        shown += f" or {len(sets) - 3} more"
    first = next(c for c in candidates if c["effects"] == nearest["effects"])
    much = ""
    if first["shrink"] is not None and nearest["shrink_without_worst"] is not None:
        much = f" would make it {first['shrink']:.0%} smaller"
        much += f" ({nearest['shrink_without_worst']:.0%} without the worst tenth of windows) but"
    return f"; {shown}{much} leaves more than noise, so none of them is named as its cause"


def summary(report: dict[str, Any]) -> str:
    """Return the verdict of a report as one sentence for a person."""
    verdict, gap = report["verdict"], report["gap"]
    sure = f"{verdict['probability']:.0%}"
    if verdict["status"] == "none":
        return f"The nominal model accounts for these runs: no gap beyond the noise ({sure} sure)."
    size = f"the size of the gap in {gap['channel']} is not known"
    if gap["before"] is not None and gap["noise_floor"]:
        times = gap["before"] / gap["noise_floor"]
        size = f"the gap in {gap['channel']} is {times:.3g} times the noise"
    if verdict["status"] == "unexplained":
        best = next((c for c in report["candidates"] if c["effects"]), None)
        near = ""
        if unlisted := verdict.get("unlisted"):
            names = " with ".join(map(_said, unlisted["effects"]))
            near = f"; {names} would do, and so would one force along the way"
        elif nearest := verdict.get("nearest"):
            near = _near(nearest, report["candidates"])
        elif "nearest" in verdict:
            near = "; none makes it surely smaller"
        elif best and best["shrink"] is not None:
            names = " with ".join(map(_said, best["effects"]))
            near = f"; nearest comes {names}, which leaves more than noise"
        return f"A gap is there that no known effect accounts for: {size}{near} ({sure} sure)."
    causes = [" or ".join(_said(n) for n in names) for names in verdict["equivalent"]]
    cause = " and ".join(f"({c})" if " or " in c and len(causes) > 1 else c for c in causes)
    text = f"The gap comes from {cause}"
    if verdict["law_mismatch"]:
        text = f"The gap may come from {cause}, by another law than the usual formula"
    if gap["shrink"] is not None:
        them = "it" if len(causes) == 1 else "them"
        text += f": with {them} the error in {gap['channel']} falls by {gap['shrink']:.1%}"
        text += f" to {gap['after']:.2g} {gap['unit']} (noise {gap['noise_floor']:.2g})"
    if verdict["status"] == "ambiguous":
        text += "; these runs cannot tell which"
    return f"{text} ({sure} sure)."


def no_gap(parts: str) -> str:
    """Say that the data kept from the fit, runs or windows, show no gap."""
    return (
        f"the {parts} kept from the fit show no gap beyond the noise: "
        "how far it shrinks there is not known"
    )


def odd_windows(comparison: Comparison, channel: str, count: int) -> list[str]:
    """Say which runs hardly move or are not helped, and which of `count` windows holds most."""
    problem = comparison.problem
    noise = problem.noise["x"]
    said, still = [], []
    for run in problem.runs:
        x = run.channels["x"]
        x = x[np.isfinite(x)]
        moves = np.abs(np.diff(x[:: max(1, x.size // 2000)])) > 4.0 * max(noise.sd, noise.step)
        if moves.mean() < _RESTING:
            still.append(run.label)
            said.append(f"run {run.label}: the head hardly ever moves: it says what holds "
                        "the head, and little of what moves it")  # fmt: skip
    rows = [row for row in by_run(comparison, channel) if row["after"] is not None]
    usual = float(np.median([row["after"] for row in rows])) if rows else 0.0
    for row in rows if len(problem.runs) > 2 else []:
        helped = row["before"] is None or row["after"] < (1.0 - _FEW) * row["before"]
        if row["run"] not in still and row["after"] > _UNUSUAL * usual and not helped:
            said.append(
                f"run {row['run']}: no effect makes its error smaller than {row['after']:.2g} "
                f"{comparison.unit(channel)}, {row['after'] / usual:.2g} times the usual one: "
                "something acts there that the other runs lack, which may be clearer "
                "without it"
            )
    left = [np.nan_to_num(squares) for squares in comparison.squares[1][channel]]
    for row in windows(problem, left)[:1]:
        if row["share"] > _MOST and count >= _MANY:
            said.append(
                f"run {row['run']}, {row['t0']:.3g} to {row['t1']:.3g} s holds {row['share']:.0%} "
                "of the squared error that is left: a push from outside, or a reading that jumped?"
            )
    return said
