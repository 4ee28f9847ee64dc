"""Commands that draw: heatmap, plot, reproduce."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from locosweep.cli.options import (
    AXIS,
    PARAMETER,
    PICTURE,
    QUANTITY,
    SETTING,
    TABLE,
    SweepCommand,
    as_json,
    fixed,
    json_option,
    on_terminal,
    robot_option,
    set_option,
    summary,
    threads_option,
)
from locosweep.cli.simulation import chosen, gait_option, refuse_idle, simulation_options
from locosweep.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from locosweep.result import Result
    from locosweep.spec import Span

    Axis = tuple[str, Span | tuple[float, ...]]

__all__ = ["called", "heatmap", "plot", "reproduce"]


@click.command(cls=SweepCommand)
@click.argument("quantity", type=QUANTITY)
@click.option(
    "--x", required=True, type=AXIS, metavar="NAME=LO:HI:COUNT", help="Axis to the right."
)
@click.option("--y", required=True, type=AXIS, metavar="NAME=LO:HI:COUNT", help="Axis upward.")
@click.option(
    "best_over",
    "--best-over",
    type=AXIS,
    metavar="NAME=LO:HI",
    help="Sweep this parameter too; show its best value and what that reaches, side by side.",
)
@click.option(
    "--best",
    type=click.Choice(["max", "min"]),
    default="max",
    show_default=True,
    help="Which value is the best one for --best-over: min for costs, times and losses.",
)
@robot_option
@set_option
@simulation_options
@gait_option
@click.option("--out", type=PICTURE, help="Picture; default QUANTITY.png in the current folder.")
@click.option("--data", type=TABLE, help="Also write the numbers.")
@threads_option
@json_option
@click.pass_context
def heatmap(
    ctx: click.Context,
    quantity: str,
    x: Axis,
    y: Axis,
    best_over: Axis | None,
    best: str,
    robot: Path | None,
    settings: tuple[tuple[str, float], ...],
    law: str | None,
    drive: str | None,
    method: str | None,
    drive_file: Path | None,
    gait: str | None,
    out: Path | None,
    data: Path | None,
    threads: int | None,
    json_: bool,
) -> None:
    """Sweep a QUANTITY over two parameters and draw it.

    Ranges include both ends. LO:HI without COUNT means every whole number.
    """
    from locosweep.spec import Spec

    if out is None:
        out = Path(f"{quantity}.png")
        PICTURE.convert(out, None, ctx)
    axes = (y, x) if best_over is None else (y, x, best_over)
    over = None if best_over is None else best_over[0]
    reduce = () if best_over is None else (f"arg{best}", best)
    simulation = chosen(law, drive, method, drive_file, gait)
    refuse_idle(dict(axes), [quantity], simulation)
    values = fixed(robot, settings, dict(axes))
    spec = Spec((quantity,), axes, values, over, reduce, simulation=simulation)
    result = spec.run(threads=threads, progress=on_terminal())
    figure = _heatmap(result, x[0], y[0], star=best == "max")
    if data is not None:
        result.save(data)
    _save(ctx, figure, out, result)
    report = {"file": str(out), "data": None if data is None else str(data), **summary(result)}
    click.echo(as_json(report) if json_ else _paths(out, data))


def _heatmap(result: Result, x: str, y: str, *, star: bool) -> Figure:
    from matplotlib.figure import Figure

    panels = len(result.outputs)
    figure = Figure(figsize=(6.8 * panels, 5.0), layout="constrained")
    for place, output in enumerate(result.outputs):
        ax = figure.add_subplot(1, panels, place + 1)
        result.plot.heatmap(x, y, output.name, ax=ax, mark_optimum=star)
    return figure


def _save(ctx: click.Context, figure: Figure, out: Path, result: Result) -> None:
    from locosweep.plot import save_figure
    from locosweep.provenance import spec_hash

    save_figure(figure, out, command=called(ctx), spec=spec_hash(result))


def called(ctx: click.Context) -> str:
    """Return the command as it was typed, for the metadata of pictures."""
    return shlex.join(["locosweep", *ctx.obj])


def _paths(*paths: Path | None) -> str:
    return "\n".join(str(path) for path in paths if path is not None)


@click.command(cls=SweepCommand)
@click.argument("file", metavar="RESULT.parquet", type=click.Path(path_type=Path))
@click.option("--x", type=PARAMETER, metavar="NAME", help="Axis to the right; default the last.")
@click.option(
    "--y", type=PARAMETER, metavar="NAME", help="Axis upward of a heat map; default the one before."
)
@click.option("--by", type=PARAMETER, metavar="NAME", help="Draw curves, one for each value.")
@click.option("--value", metavar="NAME", help="Output; default the first.")
@click.option("--at", type=SETTING, multiple=True, help="Value of another axis; repeat as needed.")
@click.option("--out", type=PICTURE, help="Picture; default RESULT.png in the current folder.")
@json_option
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
    from locosweep.files import load

    if by is not None and y is not None:
        raise InputError("--by draws curves and --y a heat map: allowed is one of them")
    if out is None:
        out = Path(f"{file.stem}.png")
        PICTURE.convert(out, None, ctx)
    result = load(file)
    places: dict[str, Any] = dict(at)
    if len(places) < len(at):
        raise InputError("--at gives an axis twice: allowed is one value each")
    free = [name for name, axis in result.axes.items() if name not in places and len(axis) > 1]
    if by is not None or (y is None and len(free) < 2):
        rest = [name for name in free or result.axes if name != by]
        if x is None and not rest:
            raise InputError(f"{file} has no axis left to draw along")
        ax = result.plot.curves(x or rest[-1], value=value, by=by, **places)
    else:
        ax = result.plot.heatmap(x, y, value, **places)
    figure = ax.get_figure(root=True)
    if figure is None:
        raise AssertionError("axes without a figure")
    _save(ctx, figure, out, result)
    click.echo(as_json({"file": str(out)}) if json_ else str(out))


@click.command()
@click.argument("figures", default="all", metavar="[2|3|4|5|10|12|13|all|gap]")
@click.option(
    "--out",
    required=True,
    metavar="FOLDER",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder for pictures and tables; made if missing.",
)
@robot_option
@json_option
def reproduce(figures: str, out: Path, robot: Path | None, json_: bool) -> None:
    """Draw the paper's figures and check the numbers it states.

    The figures use the paper's values; a robot file is held against what the
    paper says of its robot. With `gap`, runs of the paper's robot are written whose
    reality has a weaker actuator and a lubricant that builds up: an example for
    diagnose.
    """
    if figures == "gap":
        from locosweep.blindcheck.paper_gap import paper_gap

        written = paper_gap(out)
        files = [str(path) for path in written]
        click.echo(as_json({"files": files}) if json_ else _paths(*written))
        return
    from locosweep import reproduce as paper
    from locosweep.files import load_robot
    from locosweep.progress import Meter

    number = int(figures) if figures.isascii() and figures.isdigit() else figures
    held = None if robot is None else load_robot(robot)
    meter = Meter("files") if on_terminal() else None
    report = paper.reproduce(number, out, robot=held, progress=meter)
    if json_:
        rows = [
            {"claim": r.claim, "source": r.source, "paper": r.paper, "here": r.ours,
             "verdict": r.verdict, "note": r.note}
            for r in report.rows
        ]  # fmt: skip
        click.echo(as_json({"files": [str(file) for file in report.files], "claims": rows}))
    else:
        click.echo(_paths(*report.files))
