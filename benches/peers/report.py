"""Tables for a terminal, for Markdown and as JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from peers.measure import Row
from peers.targets import Times, Verdict
from peers.work import SEARCH

_HEAD = [
    "",
    "threads",
    "ns/point",
    "x locosweep",
    "GB/s written",
    "x limit",
    "fastest run",
    "max diff",
]
_MET = {True: "yes", False: "NO", None: "-"}


def times_of(groups: Mapping[str, Sequence[Row]]) -> Times:
    """Index the times by group, variant and threads."""
    return {(g, r.variant.key, r.variant.threads): r.ns for g, rows in groups.items() for r in rows}


def cells(group: str, rows: Sequence[Row]) -> list[list[str]]:
    """Return one line per variant, each beside locosweep and the limit on as many threads."""
    times = times_of({group: rows})
    lines = [_HEAD]
    for row in rows:
        threads = row.variant.threads
        ours = times[group, "ours", threads]
        limit = times.get((group, "fill", threads))
        lines.append(
            [
                row.variant.label,
                str(threads),
                f"{row.ns:.3g}",
                f"{row.ns / ours:.2f}",
                # Eight bytes per point, whatever else is read or written.
                "-" if group == SEARCH else f"{8 / row.ns:.1f}",
                f"{row.ns / limit:.2f}" if limit else "-",
                f"{row.least:.3g}",
                "-" if row.difference is None else f"{row.difference:.0e}",
            ]
        )
    return lines


def scaling(groups: Mapping[str, Sequence[Row]]) -> list[list[str]]:
    """Return how much faster two threads are, for our side."""
    times = times_of(groups)
    lines = [["1 thread / 2 threads", *groups]]
    labels = {r.variant.key: r.variant.label for rows in groups.values() for r in rows}
    for key in (key for key in labels if key.startswith("ours")):
        pairs = [(times.get((g, key, 1)), times.get((g, key, 2))) for g in groups]
        lines.append([labels[key], *(f"{a / b:.2f}" if a and b else "-" for a, b in pairs)])
    return lines


def verdicts(found: Sequence[Verdict]) -> list[list[str]]:
    """Return one line per target."""
    return [
        ["target", "wanted", "measured", "met"],
        *([v.text, v.wanted, v.measured, _MET[v.met]] for v in found),
    ]


def record(
    machine: Mapping[str, Any],
    groups: Mapping[str, Sequence[Row]],
    memory: Mapping[str, float],
    found: Sequence[Verdict],
) -> dict[str, Any]:
    """Return everything measured, for a JSON file."""
    named = {
        group: [
            {
                "key": row.variant.key,
                "label": row.variant.label,
                "threads": row.variant.threads,
                "kind": row.variant.kind,
                "ns_per_point": row.ns,
                "ns_per_point_fastest": row.least,
                "max_relative_difference": row.difference,
                "unequal_nan_cells": row.other_nans,
            }
            for row in rows
        ]
        for group, rows in groups.items()
    }
    return {
        "machine": dict(machine),
        "groups": named,
        "memory": dict(memory),
        "targets": [asdict(verdict) for verdict in found],
    }
