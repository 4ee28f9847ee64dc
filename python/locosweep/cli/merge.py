"""The command that merges run folders of one sweep."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli.options import FILE, json_option, meter, progress_option, show

if TYPE_CHECKING:
    from pathlib import Path


@click.command()
@click.argument("runs", metavar="RUN/...", type=FILE, nargs=-1, required=True)
@click.option(
    "--out", required=True, metavar="FOLDER/", type=str,
    help="A new folder, or one of the same sweep, which gets what it lacks.",
)  # fmt: skip
@progress_option
@json_option
def merge(runs: tuple[Path, ...], out: str, json_: bool) -> None:
    """Copy the finished chunks of run folders of one sweep into one.

    For shards on machines that share no folder. A chunk that was altered is not copied.
    """
    from locosweep.run_folder.merge import merge as merged

    run = merged(runs, out, meter("merge", "chunks"))
    chunks = run.manifest.plan.count
    line = f"{run.state.done_count} of {chunks} chunks, {len(run.missing)} missing"
    show(json_, {"out": run.folder, "chunks": run.summary()["chunks"]}, line)
