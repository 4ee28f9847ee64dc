"""``locosweep heatmap``: a sweep over two parameters as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.options import fixed, meter, save_picture, show, summary
from locosweep.cli.simulation_options import refuse_idle, simulation_options

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from locosweep.result import Result
    from locosweep.specs.simulation import Simulation
    from locosweep.specs.span import Span

    Axis = tuple[str, Span | tuple[float, ...]]


@click.command(cls=options.SweepCommand)
@click.argument("quantity", type=options.QUANTITY)
@click.option(
    "--x", required=True, type=options.AXIS, metavar="NAME=LO:HI:COUNT", help="Axis to the right."
)
@click.option(
    "--y", required=True, type=options.AXIS, metavar="NAME=LO:HI:COUNT", help="Axis upward."
)
@click.option(
    "best_over",
    "--best-over",
    type=options.AXIS,
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
@options.robot_option
@options.set_option
@simulation_options(gait=True)
@click.option(
    "--out",
    type=options.PICTURE,
    help="Picture; default QUANTITY.png in the current folder.",
)
@click.option("--data", type=options.TABLE, help="Also write the numbers.")
@options.threads_option
@options.progress_option
@options.json_option
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
    simulation: Simulation,
    out: Path | None,
    data: Path | None,
    threads: int | None,
    json_: bool,
) -> None:
    """Sweep a QUANTITY over two parameters and draw it.

    Ranges include both ends. LO:HI without COUNT means every whole number.
    """
    from locosweep.specs.sweep import Spec

    if out is None:
        out = Path(f"{quantity}.png")
        options.PICTURE.convert(out, None, ctx)
    axes = (y, x) if best_over is None else (y, x, best_over)
    over = None if best_over is None else best_over[0]
    reduce = () if best_over is None else (f"arg{best}", best)
    refuse_idle(dict(axes), [quantity], simulation)
    values = fixed(robot, settings, dict(axes))
    spec = Spec((quantity,), axes, values, over, reduce, simulation=simulation)
    result = spec.run(threads=threads, progress=meter(quantity))
    figure = _heatmap(result, x[0], y[0], robot, best)
    if data is not None:
        result.save(data)
    save_picture(ctx, figure, out, result)
    show(json_, {"file": out, "data": data, **summary(result)}, out, data)


def _heatmap(result: Result, x: str, y: str, robot: Path | None, best: str) -> Figure:
    from locosweep.plot import style

    # Where the lowest is looked for, the highest is no optimum.
    mark = None if best == "max" else False
    note = "" if robot is None else f"robot: {style.escaped(robot.name)}"
    panels = len(result.outputs)
    figure = style.figure(6.8 * panels, 5.0)
    for i, output in enumerate(result.outputs):
        ax = figure.add_subplot(1, panels, i + 1)
        result.plot.heatmap(x, y, output.name, ax=ax, mark_optimum=mark, note=note)
    return figure
