"""Sentences of a report: its verdict, and what stands out in runs and windows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.report.localization import by_run, windows
from locosweep.diagnosis.report.units import WIDE, rounded, sized
from locosweep.diagnosis.select.thresholds import LEAST_SHARE
from locosweep.simulation.replay import effect

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


def _value(report: dict[str, Any], name: str) -> str:
    """Return the first parameter of a named effect, in brackets; nothing where it is unknown."""
    named = set(report["verdict"]["effects"])
    rows = [c["parameters"] for c in report["candidates"] if set(c["effects"]) == named]
    for key, entry in rows[0].get(name, {}).items() if rows else ():
        if entry["value"] is not None:
            unit = "" if entry["unit"] == "1" else f" {entry['unit']}"
            return f" ({key} = {entry['value']:.3g}{unit})"
    return ""


def _partial(report: dict[str, Any], sure: str) -> str:
    """Say what each cause takes away, and how much nobody has explained."""
    verdict, gap = report["verdict"], report["gap"]
    parts = []
    for i, row in enumerate(verdict["contributions"]):
        names = [_said(n) + (_value(report, n) if k == 0 else "")
                 for k, n in enumerate(row["effects"])]  # fmt: skip
        verb = "makes " if i == 0 else ""
        much = f"{row['share']:.0%}" + (f" of the gap in {gap['channel']}" if i == 0 else "")
        parts.append(f"{' or '.join(names)} {verb}{much}")
    text = ", ".join(parts)
    left = verdict["remaining"]
    if left["share"] is not None:
        text += f"; {left['share']:.0%} ({sized(left['rmse'], gap['unit'])}) nobody has explained"
        if left["shape"]:
            text += f": most like {left['shape'][0]['formula']}"
    return f"{text[0].upper()}{text[1:]} ({sure} sure)."


def summary(report: dict[str, Any]) -> str:
    """Return the verdict of a report as one sentence for a person."""
    verdict, gap = report["verdict"], report["gap"]
    sure = f"{verdict['probability']:.0%}"
    wrong = sorted({row["column"] for row in report.get("readings", []) if not row["masked"]})
    if wrong:
        names = " and ".join(wrong)
        return f"No cause is looked for: {names} cannot be what it is called (see the warnings)."
    if verdict["status"] == "none":
        return f"The nominal model accounts for these runs: no gap beyond the noise ({sure} sure)."
    size = f"the size of the gap in {gap['channel']} is not known"
    if gap["before"] is not None and gap["noise_floor"]:
        times = gap["before"] / gap["noise_floor"]
        size = f"the gap in {gap['channel']} is {times:.3g} times the noise"
    if verdict["status"] == "unexplained":
        best = next((c for c in report["candidates"] if c["effects"]), None)
        near = ""
        if best and best["shrink"] is not None:
            near = f"; nearest comes {' with '.join(map(_said, best['effects']))}"
        like = ""
        if unlisted := verdict["unlisted"]:
            force = f"{family(unlisted)}, as of {unlisted['like']}"
            like = f"; it looks most like {force}{found_law(unlisted)}"
            if unlisted["outdoes"]:
                return (
                    f"No known effect accounts for the gap as well as {force}, does"
                    f"{found_law(unlisted)}: {size}{near} ({sure} sure)."
                )
        near += f", which {shortfall(verdict)}" if near else ""
        return (
            f"A gap is there that no known effect accounts for: {size}{like}{near} ({sure} sure)."
        )
    if verdict["status"] == "partial":
        return _partial(report, sure)
    causes = [" or ".join(_said(n) for n in names) for names in verdict["equivalent"]]
    cause = " and ".join(f"({c})" if " or " in c and len(causes) > 1 else c for c in causes)
    text = f"The gap comes from {cause}"
    if verdict["law_mismatch"]:
        found = " and ".join(text for law in verdict["laws"] if (text := found_law(law)))
        text = f"The gap may come from {cause}, by another law than the usual formula{found}"
    if gap["shrink"] is not None:
        them = "it" if len(causes) == 1 else "them"
        before, after, noise = (sized(gap[key], gap["unit"])
                                for key in ("before", "after", "noise_floor"))  # fmt: skip
        text += f": with {them} the error in {gap['channel']} falls from {before} to {after}"
        text += f" (noise {noise})"
    if unlisted := verdict["unlisted"]:
        text += f"; {family(unlisted)}, as of {unlisted['like']}, would do the same"
    if verdict["status"] == "ambiguous":
        text += "; these runs cannot tell which"
    return f"{text} ({sure} sure)."


def family(unlisted: dict[str, Any]) -> str:
    """Return the family of a force in no list, with its article where it takes one."""
    words = str(unlisted["family"])
    return f"a {words}" if words.split()[0] in ("force", "drive", "reading") else words


def found_law(law: dict[str, Any]) -> str:
    """Return the formula of a law in square brackets, and its share on unseen runs, if known.

    Examples
    --------
    >>> from locosweep.diagnosis.report.sentences import found_law
    >>> found_law({"formula": "(3.1 ± 0.2) N/m beyond x = 0.21 m", "share": 0.83})
    ' [(3.1 ± 0.2) N/m beyond x = 0.21 m; takes away 83% of the error]'
    >>> found_law({"formula": None, "share": None})
    ''
    """
    parts = [] if law["formula"] is None else [law["formula"]]
    share = law["share"] or 0.0
    if share >= LEAST_SHARE:
        parts.append(f"takes away {share:.0%} of the error")
    elif share <= -LEAST_SHARE:
        parts.append("only to first order: replayed, it makes the error larger")
    return f" [{'; '.join(parts)}]" if parts else ""


def shortfall(verdict: dict[str, Any]) -> str:
    """Return why the set that comes nearest is no cause, where nothing explains the gap."""
    return "does less than a force in no list" if outdone(verdict) else "leaves more than noise"


def outdone(verdict: dict[str, Any]) -> bool:
    """Return whether a force in no list does better than any effect."""
    return bool(verdict["unlisted"] and verdict["unlisted"]["outdoes"])


def advice(report: dict[str, Any]) -> str:
    """Return what to change in the model: the parameters of the causes; nothing without any.

    Of causes by another law than their formula, and of classes, the parameters are only those
    of the nearest formula, and are not advised.
    """
    verdict = report["verdict"]
    settled = verdict["status"] in ("explained", "partial") and not verdict["law_mismatch"]
    if not settled or any(len(alike) > 1 for alike in verdict["equivalent"]):
        return ""
    row = next(
        (c for c in report["candidates"] if set(c["effects"]) == set(verdict["effects"])), None
    )
    parts = []
    for name in verdict["effects"]:
        table = {} if row is None else row["parameters"].get(name, {})
        meanings = {p.name: p.meaning for p in effect(name).parameters}
        values = [
            f"{meanings.get(key, key)} {_advised(entry)}"
            for key, entry in table.items() if entry["value"] is not None
        ]  # fmt: skip
        parts.append(f"{_said(name)} ({', '.join(values)})" if values else _said(name))
    return f"What to do: give the model {' and '.join(parts)}."


def _advised(entry: dict[str, Any]) -> str:
    """Return a value of three digits, or fewer where its interval lets no more stand."""
    half = 0.0 if entry["std"] is None else WIDE * entry["std"]
    text = rounded(entry["value"], max(half, 1e-3 * abs(entry["value"])))
    text = f"{float(text):.3g}"
    return text if entry["unit"] == "1" else f"{text} {entry['unit']}"


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
