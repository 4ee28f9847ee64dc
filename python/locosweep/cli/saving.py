"""Pictures of results, and the paths of what was written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from locosweep.cli.options import called

if TYPE_CHECKING:
    import click
    from matplotlib.figure import Figure

    from locosweep.result import Result

__all__ = ["paths", "save_picture"]


def save_picture(ctx: click.Context, figure: Figure, out: Path, result: Result) -> None:
    """Write a picture with the command and the sweep that made it in its metadata."""
    from locosweep.plot.save import save_figure
    from locosweep.provenance import spec_hash

    save_figure(figure, out, command=called(ctx), spec=spec_hash(result))


def paths(*files: Path | None) -> str:
    """Return the paths of the files that were written, a line each."""
    return "\n".join(str(path) for path in files if path is not None)
