"""Replay of measured runs through a model: the second form of ``simulate``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.cli.options import meter, note, show
from locosweep.errors import SolveError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    import polars as pl

    from locosweep.files.csv_form import CsvForm


def replay(
    model: Path,
    runs: Path,
    out: Path,
    *,
    columns: Mapping[str, str],
    units: Mapping[str, str],
    form: CsvForm,
    threads: int | None,
    json_: bool,
) -> None:
    """Replay the runs and write what the sensors would read."""
    from locosweep.files.atomic import check_file_name, write_frame
    from locosweep.files.robot import is_rotary, load_robot
    from locosweep.files.runs import load_runs
    from locosweep.simulation.replay import replay_runs

    check_file_name(out)
    robot = load_robot(model)
    # A start may be given instead of measured: x is not needed to be driven.
    measured, notices = load_runs(
        runs, columns, units, needs=("t", "drive"), form=form, rotary=is_rotary(robot)
    )
    for notice in notices:
        note(notice)
    frame = replay_runs(robot, measured, threads=threads, progress=meter("simulate"))
    write_frame(out, frame)
    effects = list(robot.effects)
    report = {"file": out, "runs": len(measured), "rows": frame.height, "effects": effects}
    show(json_, report, out)
    if lost := _lost(frame):
        raise SolveError(f"{out}: {lost}")


def _lost(frame: pl.DataFrame) -> str:
    """Return which runs have no values, and from when on since their start; nothing if all have."""
    import polars as pl

    since = pl.col("t") - pl.col("t").min().over("run")
    gone = frame.with_columns(since).filter(pl.col("x").is_nan())
    gone = gone.group_by("run", maintain_order=True).first()
    if gone.is_empty():
        return ""
    run, t = gone["run"][0], gone["t"][0]
    others = f", and {gone.height - 1} other runs" if gone.height > 1 else ""
    return f"run {run} leaves all bounds or cannot be resolved from {t:g} s on (NaN){others}"
