"""``locosweep reproduce``: the paper's figures, numbers and sim-to-real gap."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli.options import (
    json_option,
    meter,
    out_option,
    progress_option,
    robot_option,
    show,
)
from locosweep.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path


@click.command()
@click.argument("figures", default="all", metavar="[2|3|4|5|7|8|9|10|11|12|13|all|gap]")
@out_option("Folder for pictures and tables")
@robot_option
@progress_option
@json_option
def reproduce(figures: str, out: Path, robot: Path | None, json_: bool) -> None:
    """Draw the paper's figures and check the numbers it states.

    The figures use the paper's values. Figures 7, 8, 9 and 11 are illustrations: the paper prints
    no numbers of them. A robot file is held against what the
    paper says of its robot. With `gap`, runs of the paper's robot are written whose
    reality has a weaker actuator and a lubricant that builds up: an example for
    diagnose.
    """
    if figures == "gap":
        if robot is not None:
            raise InputError("--robot is given beside gap: allowed is one of them")
        from locosweep.paper.gap import paper_gap

        written = paper_gap(out)
        show(json_, {"files": written}, *written)
        return
    from locosweep.files.robot import load_robot
    from locosweep.paper import reproduce as paper

    number = int(figures) if figures.isascii() and figures.isdigit() else figures
    held = None if robot is None else load_robot(robot)
    report = paper.reproduce(number, out, robot=held, progress=meter("reproduce", "files"))
    rows = [
        {"claim": r.claim, "source": r.source, "paper": r.paper, "here": r.ours,
         "verdict": r.verdict, "note": r.note}
        for r in report.rows
    ]  # fmt: skip
    show(json_, {"files": report.files, "claims": rows}, *report.files)
