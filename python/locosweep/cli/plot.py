"""``locosweep plot``: a saved result as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from locosweep.cli import options
from locosweep.cli.options import save_picture, show
from locosweep.errors import InputError


@click.command(cls=options.SweepCommand)
@click.argument("file", metavar="RESULT.parquet", type=options.FILE)
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
@click.option(
    "--out", type=options.PICTURE, help="Picture; default RESULT.png in the current folder."
)
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
    """Draw a result that was saved.

    A heat map where two axes are left, curves where it is one or --by is given.
    """
    from locosweep.files.results import load
    from locosweep.plot import style

    if by is not None and y is not None:
        raise InputError("--by draws curves and --y a heat map: allowed is one of them")
    if out is None:
        out = Path(f"{file.stem}.png")
        options.PICTURE.convert(out, None, ctx)
    result = load(file)
    # A figure of its own: pyplot would look for a display.
    figure = style.figure(6.8, 5.0)
    ax = figure.subplots()
    fixed_at: dict[str, Any] = dict(at)
    if len(fixed_at) < len(at):
        raise InputError("--at gives an axis twice: allowed is one value each")
    free = [name for name, axis in result.axes.items() if name not in fixed_at and len(axis) > 1]
    if by is not None or (y is None and len(free) < 2):
        rest = [name for name in free or result.axes if name != by]
        if x is None and not rest:
            raise InputError(f"{file} has no axis left to draw along")
        result.plot.curves(x or rest[-1], value=value, by=by, ax=ax, **fixed_at)
    else:
        result.plot.heatmap(x, y, value, ax=ax, **fixed_at)
    save_picture(ctx, figure, out, result)
    show(json_, {"file": out}, out)
