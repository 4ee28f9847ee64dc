"""The outcome of a stratum of the blind check as text and as JSON."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from locosweep.files.strict_json import plain
from locosweep.validation.strata import STRATA
from locosweep.validation.strata_metrics import bad_figures, by_family, by_fault, stratum_figures
from locosweep.validation.tables import block, wrong_cases

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from locosweep.validation.bad_readings import BadJudged
    from locosweep.validation.judge import Judged
    from locosweep.validation.metrics import Figure


def stratum_text(name: str, judged: Sequence[Judged]) -> str:
    """Return the table of a stratum and its wrong verdicts."""
    lines = [f"{name}: {STRATA[name].about}", *block("figure", stratum_figures(name, judged))]
    if rows := by_family(judged):
        lines += block("right, by true cause", rows)
    return "\n".join([*lines, "wrong verdicts:", *wrong_cases(judged)]) + "\n"


def bad_text(judged: Sequence[BadJudged]) -> str:
    """Return the table of cases with bad readings, and their confident false causes."""
    about = STRATA["bad-readings"].about
    lines = [f"bad-readings: {about}", *block("figure", bad_figures(judged))]
    lines += block("no confident false cause, by fault", by_fault(judged))
    lines.append("confident false causes, and faults that were not found:")
    lines += [
        f"{c.case}  {c.fault} ({c.form}), truth {c.truth}: {c.said} ({c.status}, "
        f"{c.probability:.2f}), findings {', '.join(c.kinds) or 'none'}{c.error and f': {c.error}'}"
        for c in judged
        if c.false_cause or not c.found
    ]
    return "\n".join(lines) + "\n"


def stratum_json(
    name: str, judged: Sequence[Judged] | Sequence[BadJudged], figures: Sequence[Figure],
    about: Mapping[str, Any],
) -> dict[str, Any]:  # fmt: skip
    """Everything that stands in the table, for programs."""
    found: dict[str, Any] = plain(
        {
            "schema": "locosweep.stratum/1",
            "stratum": name,
            **about,
            "figures": [asdict(figure) for figure in figures],
            "cases": [asdict(case) for case in judged],
        }
    )
    return found
