"""The command that writes a run folder as Parquet."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli.options import FILE, json_option, meter, progress_option, show
from locosweep.cli.run_options import run_argument

if TYPE_CHECKING:
    from pathlib import Path


@click.command()
@run_argument
@click.option(
    "--out", required=True, metavar="FILE.parquet|FOLDER", type=FILE,
    help="One file, or a folder of files, which appears as a whole.",
)  # fmt: skip
@click.option("--allow-missing", is_flag=True, help="Leave out cells that are not computed.")
@progress_option
@json_option
def export(run: Path, out: Path, allow_missing: bool, json_: bool) -> None:
    """Write the long table of a run folder: axes, outputs and statuses, a row for each cell."""
    from locosweep.run_folder.run import open_run
    from locosweep.run_folder.table import export as write

    count = write(open_run(run, allow_missing=allow_missing), out, meter("export", "chunks"))
    show(json_, {"out": out, "files": count}, out)
