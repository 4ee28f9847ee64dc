"""A whole blind check: draw, seal, diagnose from files, open, judge."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from locosweep.kept_work.processes import code_digest, over_processes
from locosweep.kept_work.records import digest, keep, kept
from locosweep.kept_work.staged import staged
from locosweep.validation.bad_readings import BadJudged, judge_bad
from locosweep.validation.case_files import SEAL, read_truth, runs_file
from locosweep.validation.fresh_runs import fresh_reduction
from locosweep.validation.judge import NAMING, Judged, judge
from locosweep.validation.next_run import NextRun, carried_out

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path


@dataclass(frozen=True)
class Outcome:
    """Name, processor time and error of a diagnosis."""

    name: str
    seconds: float
    error: str


def _diagnose(folder: Path, into: Path, seed: int, code: str) -> Outcome:
    """Diagnose one case from its two files; keep a diagnosis that the same code has made."""
    from locosweep.diagnosis.pipeline import diagnose
    from locosweep.diagnosis.report.model_file import write_augmented

    runs, nominal = runs_file(folder), folder / "nominal.toml"
    key = {"runs": digest(runs), "nominal": digest(nominal), "seed": seed, "code": code}
    record = into / "outcome.json"
    if (known := kept(record, key)) is not None:
        return Outcome(folder.name, known["seconds"], known["error"])
    into.mkdir(parents=True, exist_ok=True)
    made = []
    begin, error = time.process_time(), ""
    try:
        found = diagnose(runs, nominal, seed=seed, threads=1)
    except Exception as problem:
        # The error of a diagnosis is a verdict on it, not on the check.
        error = f"{type(problem).__name__}: {' '.join(str(problem).split())}"[:300]
    seconds = time.process_time() - begin
    if not error:
        made = [into / "report.json", into / "augmented.toml"]
        with staged(into.parent) as place:
            (place / into.name).mkdir()
            report = json.dumps(found.report, allow_nan=False)
            (place / into.name / made[0].name).write_text(report)
            write_augmented(found.augmented, place / into.name / made[1].name, nominal.read_text())
    keep(record, key, made, seconds=seconds, error=error)
    return Outcome(folder.name, seconds, error)


def diagnose_cases(
    out: Path,
    names: Sequence[str],
    *,
    seed: int = 0,
    processes: int = 1,
    progress: Callable[[int, int], object] | None = None,
    shard: tuple[int, int] | None = None,
) -> list[Outcome]:
    """Diagnose sealed cases; they must have been sealed before."""
    if not (out / SEAL).exists():
        raise FileNotFoundError(out / SEAL)
    code = code_digest("diagnosis", "files", "simulation", engine=True)
    calls = [(out / name, out / "diagnoses" / name, seed, code) for name in names]
    return over_processes(_diagnose, calls, processes, progress, shard)


def _judge(out: Path, outcome: Outcome) -> Judged:
    truth = read_truth(out, outcome.name)
    diagnosis = out / "diagnoses" / outcome.name
    if outcome.error:
        return judge(truth, None, seconds=outcome.seconds, error=outcome.error)
    report: dict[str, Any] = json.loads((diagnosis / "report.json").read_text())
    fresh = None
    if report["verdict"]["status"] in NAMING and truth["kind"] != "none":
        fresh = fresh_reduction(
            out / "sealed" / outcome.name / "check.csv",
            out / outcome.name / "nominal.toml",
            diagnosis / "augmented.toml",
            report["gap"]["channel"] or "x",
            truth,
        )
    return judge(truth, report, fresh=fresh, seconds=outcome.seconds)


def judge_cases(out: Path, outcomes: Sequence[Outcome]) -> list[Judged]:
    """Open the truths, after the last diagnosis, and judge each verdict."""
    return [_judge(out, outcome) for outcome in outcomes]


def judge_bad_readings(out: Path, outcomes: Sequence[Outcome]) -> list[BadJudged]:
    """Open the truths of cases with bad readings, and judge each verdict."""
    judged = []
    for one in outcomes:
        truth, file = read_truth(out, one.name), out / "diagnoses" / one.name / "report.json"
        report = None if one.error else json.loads(file.read_text())
        judged.append(judge_bad(truth, report, seconds=one.seconds, error=one.error))
    return judged


def _carry_out(out: Path, name: str, seed: int) -> NextRun | None:
    report = json.loads((out / "diagnoses" / name / "report.json").read_text())
    return carried_out(name, seed, int(name.rpartition("_")[2]), report)


def carry_out(
    out: Path,
    judged: Sequence[Judged],
    seed: int,
    count: int,
    *,
    processes: int = 1,
    progress: Callable[[int, int], object] | None = None,
) -> list[Judged]:
    """Carry out the run that a report proposes, of the first `count` that propose one.

    Only where a class of one effect holds the true one and others.
    """
    names = [c.case for c in judged if c.kind == "one" and c.status == "ambiguous" and c.right]
    calls = [(out, name, seed) for name in names[:count]]
    tried = over_processes(_carry_out, calls, processes, progress)
    found = {run.case: run for run in tried if run is not None}
    return [
        replace(c, next_resolves=found[c.case].resolves, next_possible=found[c.case].possible)
        if c.case in found
        else c
        for c in judged
    ]
