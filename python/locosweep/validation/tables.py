"""The outcome of a blind check as text and as JSON."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from locosweep.files.strict_json import plain
from locosweep.validation.metrics import calibration, confusion, figures, power, splits

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.validation.judge import Judged
    from locosweep.validation.metrics import Figure


def _number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.3f}"


def _row(figure: Figure, width: int) -> str:
    interval = f"{_number(figure.low)} .. {_number(figure.high)}" if figure.count else "-"
    open_ = "too few cases" if figure.target and figure.count else ""
    met = open_ if figure.met is None else "met" if figure.met else "MISSED"
    text = f"{figure.name:<{width}}  {_number(figure.value):>7}  {interval:>16}  {figure.count:>5}"
    return f"{text}  {figure.target:<40} {met}".rstrip()


def block(title: str, rows: Sequence[Figure]) -> list[str]:
    """Return the lines of a table of figures, and an empty one."""
    width = max([len(row.name) for row in rows] + [len(title)])
    head = f"{title:<{width}}  {'figure':>7}  {'95 % interval':>16}  {'cases':>5}  target"
    return [head, *(_row(row, width) for row in rows), ""]


def wrong_cases(judged: Sequence[Judged]) -> list[str]:
    """Say of every wrong verdict what was true and what was said."""
    lines = []
    for case in judged:
        if case.right:
            continue
        form = " (another law)" if case.mismatch else ""
        said = f"{case.said} ({case.status}, {case.probability:.2f})"
        said = f"failed: {case.error}" if case.error else said
        size = (
            "" if case.kind == "none" else f", d {case.d:.3g}, apart from others {case.d_name:.3g}"
        )
        lines.append(f"{case.case}  {case.family}{form}{size}: {said}")
    return lines


def as_text(judged: Sequence[Judged]) -> str:
    """Table of figures, what they are by kinds of case, and the confusions."""
    lines = block("figure", figures(judged))
    for name, rows in splits(judged).items():
        if rows:
            lines += block(f"right, by {name}", rows)
    counts = confusion(judged)
    mixed = sorted(((n, k) for k, n in counts.items() if k[0] != k[1]), reverse=True)
    mixed = [(n, k) for n, k in mixed if k != ("outside the list", "unexplained")]
    lines.append("largest confusions (true, said, cases):" if mixed else "no confusions")
    lines += [f"  {true} -> {said}: {n}" for n, (true, said) in mixed[:15]]
    return "\n".join(lines) + "\n"


def as_json(judged: Sequence[Judged], about: dict[str, Any]) -> dict[str, Any]:
    """Everything that stands in the tables, for programs."""
    found: dict[str, Any] = plain(
        {
            "schema": "locosweep.blindcheck/1",
            **about,
            "figures": [asdict(f) for f in figures(judged)],
            "splits": {name: [asdict(f) for f in rows] for name, rows in splits(judged).items()},
            "power": [
                {"from": low, "to": high, "detected": asdict(seen), "right": asdict(right)}
                for low, high, seen, right in power(judged)
            ],
            "calibration": [
                {"stated": stated, "right": asdict(right)} for stated, right in calibration(judged)
            ],
            "confusion": [
                {"true": true, "said": said, "cases": n}
                for (true, said), n in sorted(confusion(judged).items())
            ],
            "cases": [asdict(case) for case in judged],
        }
    )
    return found
