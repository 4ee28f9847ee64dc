"""The command that tells how far a run folder is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli.options import json_option, show
from locosweep.cli.run_options import run_argument
from locosweep.errors import printable

if TYPE_CHECKING:
    from pathlib import Path


@click.command()
@run_argument
@json_option
def status(run: Path, json_: bool) -> None:
    """Tell what of a run folder is done, by whom, and with which statuses.

    Reads manifest, logs and sizes of files; `verify` reads the files themselves.
    """
    from locosweep.run_folder.overview import overview

    found = overview(run)
    lines = [
        f"{found.done} of {found.chunks} chunks done ({found.done / found.chunks:.1%}), "
        f"{found.missing} missing, {len(found.damaged)} damaged"
    ]
    lines += [f"chunk {chunk} is damaged: {what}" for chunk, what in found.damaged.items()]
    for name, counts in found.statuses.items():
        cells = sum(counts.values())
        shares = [f"{status} {count / cells:.1%}" for status, count in counts.items()]
        lines.append(f"{name}: {', '.join(shares) or 'no cell yet'}")
    for writer in found.writers:
        rate = "" if writer.rate is None else f", {writer.rate:.3g} cells/s"
        torn = f", {writer.dropped} torn lines" if writer.dropped else ""
        by = f", by {printable(writer.made_by)}" if writer.made_by else ""
        lines.append(
            f"{writer.name}: {writer.chunks} chunks{rate}, last at {writer.last}{by}{torn}"
        )
    show(json_, found.record(), *lines)
