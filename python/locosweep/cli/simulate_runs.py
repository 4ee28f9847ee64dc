"""Replay of measured runs through a model: the second form of ``simulate``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli.options import meter, show

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


def replay(
    model: Path,
    runs: Path,
    out: Path,
    *,
    columns: Mapping[str, str],
    units: Mapping[str, str],
    threads: int | None,
    json_: bool,
) -> None:
    """Replay the runs and write what the sensors would read."""
    from locosweep.files.atomic import check_file_name, write_frame
    from locosweep.files.robot import load_robot
    from locosweep.files.runs import load_runs
    from locosweep.simulation.replay import replay_runs

    check_file_name(out)
    robot = load_robot(model)
    # A start may be given instead of measured: x is not needed to be driven.
    measured, notices = load_runs(runs, columns, units, needs=("t", "drive"))
    for notice in notices:
        click.echo(f"locosweep: note: {notice}", err=True)
    frame = replay_runs(robot, measured, threads=threads, progress=meter("simulate"))
    write_frame(out, frame)
    effects = list(robot.effects)
    report = {"file": out, "runs": len(measured), "rows": frame.height, "effects": effects}
    show(json_, report, out)
