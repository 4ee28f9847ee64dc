"""A blind check on semi-real cases: the plain baseline beside it, and the judgement."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from locosweep.files.strict_json import plain
from locosweep.kept_work.processes import code_digest, over_processes
from locosweep.kept_work.records import digest, keep, kept
from locosweep.validation.baseline import baseline
from locosweep.validation.case_files import read_truth
from locosweep.validation.semi_files import rig_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from locosweep.validation.check import Outcome


@dataclass(frozen=True)
class SemiJudged:
    """The outcome of one case.

    Attributes
    ----------
    case : str
        Its folder.
    planted : str
        The planted effect; empty in a control.
    size : float
        Wanted error of the new model on the new log, in that of the calibrated model.
    reached : float
        The size as it came out.
    accepted : tuple of str
        The planted effect and its measured equivalents.
    status : str
        Of the verdict; ``error`` where there was none.
    first : tuple of str
        The class of the first cause that is named.
    share, alone : float or None
        Its share of the gap, and what it takes away by itself, where the report says so.
    right : bool
        The first class holds an accepted effect; in a control, no cause has a large share.
    baseline : str
        What the plain baseline names.
    baseline_right, baseline_holds : bool
        It names an accepted effect; the effects as good as its best hold one.
    baseline_alike : int
        How many are as good.
    decidable : bool
        The planted effect, refitted alone, is one of them: on these runs no other effect takes
        away both the gap and some of what was there before.
    seconds : float
        Processor time of the diagnosis.
    error : str
        Reason for a missing report.
    """

    case: str
    planted: str
    size: float
    reached: float
    accepted: tuple[str, ...]
    status: str
    first: tuple[str, ...]
    share: float | None
    alone: float | None
    right: bool
    baseline: str
    baseline_share: float
    baseline_right: bool
    baseline_holds: bool
    baseline_alike: int
    decidable: bool
    seconds: float
    error: str = ""


LARGE = 0.2
"""Share of the gap from which a cause that is not there counts against a diagnosis."""


def _baseline(folder: Path, record: Path, code: str) -> dict[str, Any]:
    files = {name: digest(folder / name) for name in ("runs.parquet", "nominal.toml")}
    key = {**files, "code": code}
    if (known := kept(record, key)) is not None:
        return known
    found = baseline(rig_of(folder / "runs.parquet", folder / "nominal.toml", ()))
    said: dict[str, Any] = plain(asdict(found))
    keep(record, key, **said)
    return said


def baselines(
    out: Path,
    names: Sequence[str],
    *,
    processes: int = 1,
    progress: Callable[[int, int], object] | None = None,
    shard: tuple[int, int] | None = None,
) -> list[dict[str, Any]]:
    """Ask the plain baseline about each case; answers of the same code are kept."""
    code = code_digest("validation/baseline.py", "validation/rig_problem.py", engine=False)
    calls = [(out / name, out / "baselines" / f"{name}.json", code) for name in names]
    return over_processes(_baseline, calls, processes, progress, shard)


def first_cause(verdict: dict[str, Any]) -> tuple[tuple[str, ...], float | None, float | None]:
    """Return the class of the first cause that a verdict names, its share, and it alone."""
    contributions = verdict.get("contributions") or []
    if contributions:
        first = contributions[0]
        return tuple(first["effects"]), first.get("share"), first.get("alone")
    if verdict["effects"]:
        return tuple(verdict["equivalent"][0] or verdict["effects"][:1]), None, None
    return (), None, None


def _judge(out: Path, outcome: Outcome, plainly: dict[str, Any]) -> SemiJudged:
    truth = read_truth(out, outcome.name)
    planted, accepted = truth["effect"] or "", set(truth["accepted"])
    status, large = "error", False
    first: tuple[str, ...] = ()
    share: float | None = None
    alone: float | None = None
    if not outcome.error:
        report = json.loads((out / "diagnoses" / outcome.name / "report.json").read_text())
        verdict = report["verdict"]
        status = verdict["status"]
        first, share, alone = first_cause(verdict)
        shares = [c.get("share") or 0.0 for c in verdict.get("contributions") or []]
        # A report that says no shares claims the whole of its shrinking gap.
        claimed = report["gap"].get("shrink") if first and not shares else None
        large = max([*shares, claimed or 0.0]) > LARGE
    return SemiJudged(
        case=outcome.name,
        planted=planted,
        size=float(truth["size"]),
        reached=float(truth.get("reached", 1.0)),
        accepted=tuple(sorted(accepted)),
        status=status,
        first=first,
        share=share,
        alone=alone,
        right=bool(accepted & set(first)) if planted else not large,
        baseline=plainly["name"],
        baseline_share=float(plainly["share"]),
        baseline_right=plainly["name"] in accepted if planted else plainly["share"] <= LARGE,
        baseline_holds=bool(accepted & set(plainly["alike"])),
        baseline_alike=len(plainly["alike"]),
        decidable=planted in plainly["alike"],
        seconds=outcome.seconds,
        error=outcome.error,
    )


def judge_semi_real(
    out: Path, outcomes: Sequence[Outcome], plainly: Sequence[dict[str, Any]]
) -> list[SemiJudged]:
    """Open the truths, after the last diagnosis, and judge each first cause."""
    return [_judge(out, one, other) for one, other in zip(outcomes, plainly, strict=True)]
