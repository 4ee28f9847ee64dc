"""Diagnoses of many rigs into one folder: resumable, in shards, one bad rig costs its own line."""

from __future__ import annotations

import hashlib
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from locosweep import _core
from locosweep.errors import InputError
from locosweep.files.atomic import write_frame
from locosweep.kept_work.begun import begin
from locosweep.kept_work.processes import code_digest, over_processes
from locosweep.kept_work.records import digest, keep, kept
from locosweep.kept_work.staged import staged
from locosweep.run_folder.commit import beside, sweep_stale
from locosweep.run_folder.shards import check_shard

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import polars as pl

    from locosweep.diagnosis.report.result import Diagnosis
    from locosweep.progress import Progress

RIGS, _RECORDS = "rigs", "records"
"""Folders of the reports, and of what was done for each."""
_TABLES = ("verdicts.csv", "verdicts.parquet")
_ENDED = "its process ended twice: it takes more memory than there is, or was killed"
_COLUMNS = {
    "name": str, "runs": str, "nominal": str, "status": str, "effects": str,
    "probability": float, "channel": str, "unit": str, "before": float, "after": float,
    "warnings": int, "error": str,
}  # fmt: skip


@dataclass(frozen=True)
class Rig:
    """One rig of a batch.

    Attributes
    ----------
    name : str
        Folder of its report.
    runs, nominal : Path
        Its files.
    options : dict
        Options of `locosweep.diagnose` for it, but `threads` and `progress`.
    """

    name: str
    runs: Path
    nominal: Path
    options: Mapping[str, Any] = field(default_factory=dict)


def diagnose_batch(
    rigs: Sequence[Rig],
    out: Path,
    *,
    processes: int | None = None,
    shard: tuple[int, int] | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> pl.DataFrame:
    """Diagnose rigs, and return a row for each; what the same code has done is kept.

    Parameters
    ----------
    rigs : sequence of Rig
        Each with a name of its own.
    out : Path
        Folder; ``rigs/NAME`` gets the report of each, ``verdicts.csv`` and
        ``verdicts.parquet`` the rows.
    processes : int, optional
        Rigs at a time, each with one thread; default as threads of a sweep.
    shard : (int, int), optional
        (i, n): every n-th rig from the i-th on comes first, then what others have not done.
    force : bool
        Begin in a folder that is not empty.
    progress : Progress, optional
        Receives how many rigs are done, and all; by ``fail``, how many have no verdict.

    Returns
    -------
    polars.DataFrame
        Name, files, status (``error`` where there is no verdict), effects, probability, gap
        before and after in `unit`, number of warnings, and the error in a line.

    Raises
    ------
    InputError
        No rig, a name twice, a folder of something else, a disk that is full.
    """
    names = [rig.name for rig in rigs]
    check_shard(shard)
    if not rigs:
        raise InputError("a batch of no rigs: allowed is at least one")
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"name {name} is given twice: allowed is a name of its own each")
    begin(out, {"batch": "diagnose"}, force=force)
    (out / _RECORDS).mkdir(exist_ok=True)
    sweep_stale([out / _RECORDS])
    code = code_digest("diagnosis", "files", "simulation", engine=True)
    calls = [(rig, out, code) for rig in rigs]
    failed: set[int] = set()

    def count(i: int, row: Mapping[str, Any]) -> None:
        if row["error"]:
            failed.add(i)
            getattr(progress, "fail", lambda _: None)(len(failed))

    def tell(done: int, total: int) -> None:
        if progress is not None:
            progress(done, total, 0.0)

    workers = min(_core.threads_to_use(processes), len(rigs))
    while True:
        try:
            rows = over_processes(_row, calls, workers, tell, shard, count)
            break
        except BrokenProcessPool:
            _without_those_that_end(calls)
    table = _table(rows)
    for file in _TABLES:
        write_frame(out / file, table)
    return table


def _without_those_that_end(calls: Sequence[tuple[Rig, Path, str]]) -> None:
    """Give each rig that was worked on when a process ended another one of its own.

    Where that ends as well, the rig has no verdict.
    """
    records = calls[0][1] / _RECORDS
    before = {path.name for path in records.glob("*.partial")}
    sweep_stale([records])
    gone = before - {path.name for path in records.glob("*.partial")}
    suspects = [c for c in calls if any(n.startswith(f"{c[0].name}.json.") for n in gone)]
    if not suspects:
        raise InputError("processes end before they begin: is there memory for --threads of them?")
    for call in suspects:
        try:
            over_processes(_row, [call], 1)
        except BrokenProcessPool:
            rig, out, code = call
            keep(_record(out, rig), _key(rig, code), row=_failed(rig, _ENDED), again=False)
    sweep_stale([records])


def _record(out: Path, rig: Rig) -> Path:
    return out / _RECORDS / f"{rig.name}.json"


def _key(rig: Rig, code: str) -> dict[str, Any]:
    options = {k: dict(v) if isinstance(v, dict) else v for k, v in rig.options.items()}
    return {
        "runs": _content(rig.runs), "nominal": _content(rig.nominal), "options": options,
        "code": code,
    }  # fmt: skip


def _content(path: Path) -> str | None:
    """Hash of a file, or of all files of a folder; None where nothing can be read."""
    try:
        if not path.is_dir():
            return digest(path)
        files = sorted(p for p in path.rglob("*") if p.is_file())
        whole = "".join(f"{p.relative_to(path).as_posix()} {digest(p)}\n" for p in files)
    except OSError:
        return None
    return hashlib.sha256(whole.encode()).hexdigest()


def _row(rig: Rig, out: Path, code: str) -> dict[str, Any]:
    """Diagnose one rig into its folder; return its row, which is kept."""
    from polars.exceptions import PanicException

    from locosweep.diagnosis.pipeline import diagnose

    record, key = _record(out, rig), _key(rig, code)
    if (known := kept(record, key)) is not None and not known["again"]:
        return dict(known["row"])
    # Stays where this process ends: `_without_those_that_end` looks for it.
    marker = beside(record)
    marker.touch()
    made: list[Path] = []
    again = False
    try:
        found = diagnose(rig.runs, rig.nominal, **rig.options, threads=1)
        with staged(out, f"{RIGS}/{rig.name}") as place:
            (place / RIGS).mkdir()
            # The same command whichever process, and whatever else is in the batch.
            command = f"locosweep diagnose {rig.runs.name} --nominal {rig.nominal.name}"
            found.save(place / RIGS / rig.name, command=command)
            files = (place / RIGS / rig.name).iterdir()
            made = sorted(out / path.relative_to(place) for path in files)
        row = _said(rig, found)
    except (Exception, PanicException) as error:
        # Whatever one rig does, the others go on, and its row says what it was. What the machine
        # had not, it may have next time; a file is no other then.
        again = isinstance(error, MemoryError)
        name = "" if isinstance(error, InputError) else f"{type(error).__name__}: "
        row = _failed(rig, f"{name}{' '.join(str(error).split())}")
    finally:
        marker.unlink(missing_ok=True)
    keep(record, key, made, row=row, again=again)
    return row


def _said(rig: Rig, found: Diagnosis) -> dict[str, Any]:
    gap = found.gap
    return _files(rig) | {
        "status": found.status, "effects": " + ".join(found.effects),
        "probability": found.probability, "channel": gap["channel"], "unit": gap["unit"],
        "before": gap["before"], "after": gap["after"], "warnings": len(found.warnings),
        "error": "",
    }  # fmt: skip


def _failed(rig: Rig, error: str) -> dict[str, Any]:
    nothing = dict.fromkeys(("effects", "probability", "channel", "unit", "before", "after"))
    return _files(rig) | {"status": "error", **nothing, "warnings": 0, "error": error}


def _files(rig: Rig) -> dict[str, Any]:
    return {"name": rig.name, "runs": str(rig.runs), "nominal": str(rig.nominal)}


def _table(rows: Sequence[Mapping[str, Any]]) -> pl.DataFrame:
    import polars as pl

    kinds = {str: pl.String, float: pl.Float64, int: pl.Int64}
    return pl.DataFrame(list(rows), {name: kinds[kind] for name, kind in _COLUMNS.items()})
