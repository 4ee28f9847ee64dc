"""What a diagnosis is given: measured runs, in a file or in columns, and a nominal model."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import polars as pl

from locosweep.diagnosis.data.clocks import Finding, in_words, on_their_clocks, packets_spread
from locosweep.errors import InputError
from locosweep.files.raw import stored
from locosweep.files.robot import Robot, is_rotary, load_robot
from locosweep.files.runs import Run, load_runs
from locosweep.files.sources import files_of, frame_of, is_frame

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

    from locosweep.files.columns import MendStamps
    from locosweep.files.csv_form import CsvForm


def nominal_model(nominal: str | os.PathLike[str] | Robot) -> Robot:
    """Return the model that runs are held against, which has no effects."""
    robot = nominal if isinstance(nominal, Robot) else load_robot(nominal)
    if robot.effects:
        given = ", ".join(robot.effects)
        raise InputError(f"the nominal model has effects ({given}): allowed is a model without")
    return robot


def read_runs(
    runs: Any,
    columns: Mapping[str, str],
    units: Mapping[str, str],
    robot: Robot | None = None,
    form: CsvForm | None = None,
) -> tuple[list[Run], list[str], str]:
    """Return runs from a file or columns, notices about them, and the digest of the data.

    Units have to be those of the robot, if one is given: a rotary bench or another rig. Runs are
    at the ticks of their clocks (`data/clocks.py`), counted from the start of each run; notices
    say what that took.
    """
    packets: list[Finding] = []
    records, notices, digest = _read(runs, columns, units, robot, form, packets_spread(packets))
    mended, findings = on_their_clocks(records)
    # Stamps of a clock on the wall are long numbers, in which the times of a run cannot be read.
    mended = [replace(run, t=run.since_start) for run in mended]
    return mended, [*notices, *in_words([*packets, *findings])], digest


def _read(
    runs: Any,
    columns: Mapping[str, str],
    units: Mapping[str, str],
    robot: Robot | None,
    form: CsvForm | None,
    stamps: MendStamps,
) -> tuple[list[Run], list[str], str]:
    if is_frame(runs):
        # Taken once: a stream of Arrow, or a lazy frame, is used up or computed by reading.
        runs = frame_of(runs, "runs")
    records, notices = load_runs(
        runs,
        columns,
        units,
        stamps=stamps,
        form=form,
        rotary=None if robot is None else is_rotary(robot),
    )
    return records, notices, _digest(runs)


def _digest(runs: Any) -> str:
    """Return the digest of a frame as CSV, or of all files, those in the folder of a bag too."""
    if isinstance(runs, pl.DataFrame):
        plain = [name for name, kind in runs.schema.items() if not _is_nested(kind)]
        return hashlib.sha256(runs.select(plain).write_csv().encode()).hexdigest()
    found = hashlib.sha256()
    for path in files_of(runs):
        for part in sorted(path.iterdir()) if path.is_dir() else [path]:
            found.update(stored(part))
    return found.hexdigest()


def _is_nested(kind: pl.DataType) -> bool:
    """Return whether CSV has no form for a type."""
    return kind.is_nested() or kind in (pl.Binary, pl.Object)
