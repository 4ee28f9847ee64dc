"""What commands that write pictures share: how they were called, and where the picture went."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from locosweep.result import Result

__all__ = ["called", "paths", "save_picture"]


def save_picture(ctx: click.Context, figure: Figure, out: Path, result: Result) -> None:
    """Write a picture with the command and the sweep that made it in its metadata."""
    from locosweep.plot.save import save_figure
    from locosweep.provenance import spec_hash

    save_figure(figure, out, command=called(ctx), spec=spec_hash(result))


def called(ctx: click.Context) -> str:
    """Return the command as it was typed, for the metadata of pictures."""
    return shlex.join(["locosweep", *ctx.obj])


def paths(*files: Path | None) -> str:
    """Return the paths of the files that were written, a line each."""
    return "\n".join(str(path) for path in files if path is not None)
