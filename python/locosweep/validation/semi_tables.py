"""The outcome of a blind check on a rig as text and as JSON."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.files.strict_json import plain
from locosweep.validation.metrics import wilson

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from locosweep.validation.semi_check import SemiJudged

_COLUMNS = (
    "planted", "size", "status", "first cause", "share", "right", "baseline", "right", "CPU s",
)  # fmt: skip


def _class(names: Sequence[str], most: int = 3) -> str:
    more = f" +{len(names) - most}" if len(names) > most else ""
    return "|".join(names[:most]) + more if names else "-"


def _yes(right: bool) -> str:
    return "yes" if right else "NO"


def _share(share: float | None) -> str:
    return "-" if share is None else f"{share:.2f}"


def sums(judged: Sequence[SemiJudged]) -> list[dict[str, Any]]:
    """Return the figures of each size, and of the controls as size 0."""
    found = []
    for size in sorted({case.size for case in judged}):
        own = [case for case in judged if case.size == size]
        row: dict[str, Any] = {"size": size, "cases": len(own)}
        for key in ("right", "baseline_right", "baseline_holds"):
            hits = sum(bool(getattr(case, key)) for case in own)
            row[key] = {"share": hits / len(own), "interval": wilson(hits, len(own)), "hits": hits}
        fair = [case for case in own if case.decidable]
        row["decidable"] = {
            "cases": len(fair),
            "right": sum(case.right for case in fair),
            "baseline_right": sum(case.baseline_right for case in fair),
        }
        row["baseline_alike"] = float(np.mean([case.baseline_alike for case in own]))
        row["median_seconds"] = float(np.median([case.seconds for case in own]))
        found.append(row)
    return found


def as_text(judged: Sequence[SemiJudged], skipped: Mapping[str, str]) -> str:
    """Return the table of cases, the sums of each size, and what was skipped."""
    rows = [_COLUMNS]
    rows += [
        (
            case.planted or case.case, f"{case.size:g}", case.status, _class(case.first),
            _share(case.share), _yes(case.right), case.baseline or "none",
            _yes(case.baseline_right), f"{case.seconds:.0f}",
        )
        for case in judged
    ]  # fmt: skip
    widths = [max(len(row[i]) for row in rows) for i in range(len(_COLUMNS))]
    lines = [
        "  ".join(f"{text:<{width}}" for text, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    lines.append("")
    for row in sums(judged):
        right, base, holds = row["right"], row["baseline_right"], row["baseline_holds"]
        count = row["cases"]
        if row["size"] == 0.0:
            lines.append(
                f"controls: a cause with a share above 0.2 in {count - right['hits']} of {count} "
                f"(baseline {count - base['hits']})"
            )
            continue
        low, high = right["interval"]
        lines.append(
            f"{row['size']:g} times: right first in {right['hits']} of {count} "
            f"({right['share']:.2f}, 95 % interval {low:.2f} to {high:.2f}); "
            f"baseline {base['share']:.2f}, among those as good {holds['share']:.2f} "
            f"of {row['baseline_alike']:.1f} on average; median {row['median_seconds']:.0f} s"
        )
        fair = row["decidable"]
        lines.append(
            f"    where the planted effect alone fits as well as any: {fair['right']} of "
            f"{fair['cases']}, baseline {fair['baseline_right']}"
        )
    if skipped:
        lines += ["", "not drawn:", *(f"  {name}: {why}" for name, why in skipped.items())]
    return "\n".join(lines) + "\n"


def as_json(
    judged: Sequence[SemiJudged], skipped: Mapping[str, str], about: Mapping[str, Any]
) -> dict[str, Any]:
    """Everything that stands in the table, for programs."""
    found: dict[str, Any] = plain(
        {
            "schema": "locosweep.semireal/1",
            **about,
            "sums": sums(judged),
            "skipped": dict(skipped),
            "cases": [asdict(case) for case in judged],
        }
    )
    return found
