"""Tables and a record of what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from dynamics_peers.battery import Rate
from dynamics_peers.measure import Row
from dynamics_peers.memory import Held
from dynamics_peers.targets import Verdict
from dynamics_peers.work import UNITS


def cells(work: str, rows: Sequence[Row]) -> list[list[str]]:
    """Return one line per way, beside ours on as many threads, or else the fastest peer."""
    unit, factor = UNITS[work]
    ours = [row for row in rows if row.way.kind == "ours"]
    beside = "x locosweep" if ours else "x fastest"
    lines = [
        ["", "threads", "points", unit, beside, "ns/step", "fastest run", "max diff", "median diff"]
    ]
    for row in rows:
        base = _base(row, ours) if ours else min(r.seconds for r in rows)
        step = f"{1e9 * row.seconds / row.way.steps:.3g}" if row.way.steps else "-"
        # Another model has no error, only a distance.
        mark = "" if row.way.allowed is not None else "*"
        lines.append(
            [
                row.way.label,
                str(row.way.threads),
                str(row.way.points),
                f"{factor * row.seconds:.4g}",
                f"{row.seconds / base:.3g}",
                step,
                f"{factor * row.least:.4g}",
                f"{row.worst:.0e}{mark}",
                f"{row.typical:.0e}{mark}",
            ]
        )
    return lines


def agreement(rows: Sequence[Row]) -> list[list[str]]:
    """Return how far each way is off the reference, and how far it may be; no times."""
    lines = [["", "threads", "points", "max diff", "allowed"]]
    for row in rows:
        allowed = "*" if row.way.allowed is None else f"{row.way.allowed:.0e}"
        way = row.way
        lines.append([way.label, str(way.threads), str(way.points), f"{row.worst:.0e}", allowed])
    return lines


def _base(row: Row, ours: Sequence[Row]) -> float:
    """Return the time of our first way on as many threads, or on one."""
    alike = [r for r in ours if r.way.threads == row.way.threads]
    return (alike or list(ours))[0].seconds


def notes(rows: Sequence[Row]) -> list[str]:
    """Say what a table cannot."""
    found = []
    if any(row.way.allowed is None for row in rows):
        found.append("* another model of friction: its distance to the reference, not an error")
    own = {row.way.label: row.own for row in rows if row.own is not None}
    found += [f"{name}: {off:.1e} off its own small-step limit" for name, off in own.items()]
    return found


def record(
    machine: Mapping[str, Any],
    groups: Mapping[str, Sequence[Row]],
    rates: Sequence[Rate],
    held: Sequence[Held],
    found: Sequence[Verdict],
) -> dict[str, Any]:
    """Return everything measured, for a JSON file."""
    named = {
        work: [
            {
                "key": row.way.key,
                "label": row.way.label,
                "threads": row.way.threads,
                "kind": row.way.kind,
                "points": row.way.points,
                "steps": row.way.steps,
                "seconds_per_trajectory": row.seconds,
                "seconds_per_trajectory_fastest": row.least,
                "max_relative_difference": row.worst,
                "median_relative_difference": row.typical,
                "allowed_difference": row.way.allowed,
                "off_own_limit": row.own,
            }
            for row in rows
        ]
        for work, rows in groups.items()
    }
    return {
        "machine": dict(machine),
        "groups": named,
        "effects": [asdict(rate) for rate in rates],
        "memory": [asdict(one) for one in held],
        "targets": [asdict(verdict) for verdict in found],
    }
