"""The command that holds every file of a run folder against its hash."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli.options import json_option, meter, progress_option, show, threads_option
from locosweep.cli.run_options import run_argument

if TYPE_CHECKING:
    from pathlib import Path

_DAMAGED = 1
"""Exit code where files are not as they were written."""


@click.command()
@run_argument
@click.option("--repair", "mend", is_flag=True, help="Compute damaged chunks again.")
@click.option("--allow-drift", is_flag=True, help="Repair although this version gives other bits.")
@threads_option
@progress_option
@json_option
@click.pass_context
def verify(
    ctx: click.Context,
    run: Path,
    mend: bool,
    allow_drift: bool,
    threads: int | None,
    json_: bool,
) -> None:
    """Read all files of a run folder and say which were altered; the exit code is then 1."""
    from locosweep.run_folder import verify as checks

    found = checks.verify(run, meter("verify", "chunks"))
    damaged = [f"{fault.file}: {fault.what}" for fault in found.faults]
    repaired = 0
    if mend and damaged:
        repaired = checks.repair(run, found, threads, allow_drift=allow_drift)
    if repaired:
        # What is reported is what lies there now.
        found = checks.verify(run, meter("verify", "chunks"))
    lines = [
        *damaged,
        f"{found.done} of {found.chunks} chunks are written, {len(damaged)} files are damaged"
        + (f", {repaired} repaired" if mend else ""),
    ]
    record = {
        "chunks": found.chunks, "done": found.done, "damaged": damaged, "repaired": repaired,
        "torn_lines": found.dropped,
    }  # fmt: skip
    show(json_, record, *lines)
    if found.faults:
        ctx.exit(_DAMAGED)
