"""``locosweep plot``: a saved result or a run folder as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from locosweep.cli import options
from locosweep.cli.options import show
from locosweep.errors import InputError

if TYPE_CHECKING:
    from locosweep.result import Result
    from locosweep.run_folder.run import Run


@click.command(cls=options.SweepCommand)
@click.argument("file", metavar="RESULT.parquet|RUN", type=options.FILE)
@click.option(
    "--x", type=options.PARAMETER, metavar="NAME", help="Axis to the right; default the last."
)
@click.option(
    "--y",
    type=options.PARAMETER,
    metavar="NAME",
    help="Axis upward of a heat map; default the one before.",
)
@click.option(
    "--by", type=options.PARAMETER, metavar="NAME", help="Draw curves, one for each value."
)
@click.option("--value", metavar="NAME", help="Output; default the first.")
@click.option(
    "--at", type=options.SETTING, multiple=True, help="Value of another axis; repeat as needed."
)
@click.option("--out", type=options.PICTURE, help="Picture; default RESULT.png or RUN.png here.")
@options.json_option
@click.pass_context
def plot(
    ctx: click.Context,
    file: Path,
    x: str | None,
    y: str | None,
    by: str | None,
    value: str | None,
    at: tuple[tuple[str, float], ...],
    out: Path | None,
    json_: bool,
) -> None:
    """Draw a result that was saved, or a run folder.

    A heat map where two axes are left, curves where it is one or --by is given. Of a run only
    the cells that are drawn are read.
    """
    from locosweep.files.results import load
    from locosweep.plot import style
    from locosweep.plot.save import save_figure
    from locosweep.provenance import spec_hash

    if by is not None and y is not None:
        raise InputError("--by draws curves and --y a heat map: allowed is one of them")
    if out is None:
        out = Path(f"{file.stem or file.resolve().stem}.png")
        options.PICTURE.convert(out, None, ctx)
    shown: Result | Run
    if file.is_dir():
        from locosweep.run_folder.run import open_run

        shown = open_run(file)
        spec = shown.manifest.spec_sha256
    else:
        shown = load(file)
        spec = spec_hash(shown)
    # A figure of its own: pyplot would look for a display.
    figure = style.figure(6.8, 5.0)
    ax = figure.subplots()
    fixed_at: dict[str, Any] = dict(at)
    if len(fixed_at) < len(at):
        raise InputError("--at gives an axis twice: allowed is one value each")
    free = [name for name, axis in shown.axes.items() if name not in fixed_at and len(axis) > 1]
    if by is not None or (y is None and len(free) < 2):
        rest = [name for name in free or shown.axes if name != by]
        if x is None and not rest:
            raise InputError(f"{file} has no axis left to draw along")
        shown.plot.curves(x or rest[-1], value=value, by=by, ax=ax, **fixed_at)
    else:
        shown.plot.heatmap(x, y, value, ax=ax, **fixed_at)
    save_figure(figure, out, command=options.called(ctx), spec=spec)
    show(json_, {"file": out}, out)
