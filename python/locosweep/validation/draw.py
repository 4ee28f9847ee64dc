"""Drawing of many cases into a folder, over processes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.kept_work.processes import code_digest, over_processes
from locosweep.kept_work.records import keep, kept
from locosweep.kept_work.staged import staged
from locosweep.validation.case_files import case_name, files_of, seal, write_case
from locosweep.validation.cases import draw_case

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

_DRAWING = (
    "bad_readings",
    "case_files",
    "case_truth",
    "cases",
    "drives",
    "experiment",
    "laws",
    "rigs",
    "rivals",
    "sizes",
)
"""Modules that say what a case is: when others change, drawn cases stay."""


def _draw(seed: int, index: int, gap_free: bool, out: Path, code: str) -> str:
    name = case_name(index, gap_free=gap_free)
    record = out / "sealed" / name / "drawn.json"
    key = {"seed": seed, "index": index, "gap_free": gap_free, "code": code}
    if kept(record, key) is None:
        case = draw_case(seed, index, gap_free=gap_free)
        with staged(out, name, f"sealed/{name}") as place:
            write_case(case, name, place, [seed, int(gap_free), index])
        keep(record, key, files_of(out, name))
    return name


def drawing_code() -> str:
    """Return the hash of the code that says what a case is."""
    modules = [f"validation/{name}.py" for name in _DRAWING]
    files = (*modules, "diagnosis/effects", "files/channels.py", "files/toml.py")
    return code_digest(*files, engine=False)


def draw_cases(
    out: Path,
    cases: int,
    seed: int,
    *,
    gap_free: int = 0,
    processes: int = 1,
    progress: Callable[[int, int], object] | None = None,
    shard: tuple[int, int] | None = None,
) -> list[str]:
    """Draw cases into a folder and seal their truths; those that are there are kept."""
    wanted = [(i, False) for i in range(cases)] + [(i, True) for i in range(gap_free)]
    code = drawing_code()
    calls = [(seed, index, free, out, code) for index, free in wanted]
    names = over_processes(_draw, calls, processes, progress, shard)
    seal(out, names)
    return names
