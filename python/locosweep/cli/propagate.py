"""``locosweep propagate``: how a quantity is distributed when parameters are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from locosweep.cli import options
from locosweep.cli.options import AXIS, CURVES, PICTURE, QUANTITY, meter, show
from locosweep.cli.simulation_options import refuse_idle, simulation_options
from locosweep.cli.uncertainty_options import (
    known,
    samples_option,
    save_plot,
    seed_option,
    unknown_option,
)
from locosweep.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    import polars as pl

    from locosweep.cli.options import Axis
    from locosweep.specs.simulation import Simulation


@click.command(cls=options.SweepCommand)
@click.argument("quantity", type=QUANTITY)
@unknown_option
@click.option(
    "axes", "--axis", multiple=True, type=AXIS,
    help="Designs to compare, NAME=LO:HI:COUNT, NAME=A,B,C or, for whole numbers, NAME=LO:HI.",
)  # fmt: skip
@options.robot_option
@options.set_option
@click.option("--need", metavar="'>= NUMBER'", help="What the quantity has to meet, SI units.")
@samples_option
@seed_option
@simulation_options(gait=True)
@click.option("--out", type=CURVES, help="Table: a row a design, with quantiles and shares.")
@click.option("--plot", "picture", type=PICTURE, help="The distribution.")
@options.threads_option
@options.progress_option
@options.json_option
@click.pass_context
def propagate(
    ctx: click.Context,
    quantity: str,
    unknown: dict[str, str],
    axes: tuple[Axis, ...],
    robot: Path | None,
    settings: tuple[tuple[str, float], ...],
    need: str | None,
    samples: int,
    seed: int,
    simulation: Simulation,
    out: Path | None,
    picture: Path | None,
    threads: int | None,
    json_: bool,
) -> None:
    """Say how a quantity is distributed when parameters are known as distributions.

    In each design the same points are tried. A point where the robot does not move counts as the
    worst in quantiles, and meets no need.
    """
    from locosweep.files.atomic import write_frame
    from locosweep.specs.span import Span
    from locosweep.uncertainty.propagation import propagate as run
    from locosweep.uncertainty.propagation import too_many

    names = [name for name, _ in (*axes, *settings)]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{name} is given twice: allowed is one --axis or one --set")
    if picture is not None and len(dict(axes)) > 1:
        raise too_many(dict(axes))
    refuse_idle(dict(axes), (quantity,), simulation)
    grid: dict[str, Any] = {name: axis.values(name) if isinstance(axis, Span) else list(axis)
                            for name, axis in axes}  # fmt: skip
    given = known(robot, settings, unknown, simulation, grid)
    found = run(
        quantity, unknown, need=need, samples=samples, seed=seed, threads=threads,
        progress=meter(quantity), **grid, **given,
    )  # fmt: skip
    table = found.to_polars()
    if out is not None:
        write_frame(out, table)
    save_plot(ctx, found, picture)
    report = {
        "quantity": quantity,
        "unit": found.output.unit,
        "unknown": unknown,
        "need": need,
        "samples": samples,
        "seed": seed,
        "designs": table.to_dicts(),
        "statuses": {status.name.lower(): n for status, n in found.statuses().items()},
        "fixed": found.fixed,
    }
    show(json_, report, repr(found), _table(table) if found.axes else None, out, picture)


def _table(table: pl.DataFrame) -> str:
    import polars as pl

    from locosweep.registry import parameters

    counts = [p.name for p in parameters() if p.integer and p.name in table.columns]
    table = table.with_columns(pl.col(counts).cast(pl.Int64))
    with pl.Config(tbl_rows=-1, tbl_cols=-1, tbl_hide_dataframe_shape=True, float_precision=4,
                   tbl_hide_column_data_types=True, tbl_formatting="NOTHING",
                   tbl_width_chars=160):  # fmt: skip
        return "\n" + str(table)
