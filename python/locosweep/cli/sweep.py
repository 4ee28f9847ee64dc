"""The command that sweeps into a file."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.options import fixed, on_terminal, show, summary
from locosweep.cli.simulation_options import refuse_beside, refuse_idle, simulation_options
from locosweep.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.specs.simulation import Simulation
    from locosweep.specs.span import Span


@click.command(cls=options.SweepCommand)
@click.argument("quantities", nargs=-1, type=options.QUANTITY, metavar="QUANTITY...")
@click.option(
    "axes",
    "--axis",
    multiple=True,
    type=options.AXIS,
    help="Axis NAME=LO:HI:COUNT, NAME=A,B,C or, for whole numbers, NAME=LO:HI; repeat in order.",
)
@options.robot_option
@options.set_option
@simulation_options(gait=True)
@click.option("--over", type=options.PARAMETER, metavar="NAME", help="Axis to fold away.")
@click.option(
    "--reduce", multiple=True, type=options.REDUCTION, metavar="HOW", help="How; repeatable."
)
@click.option("--q", type=float, metavar="Q", help="Which quantile, from 0 to 1.")
@click.option("--dtype", metavar="TYPE", help="float64 (default) or float32.")
@click.option(
    "spec_file", "--spec", metavar="FILE.toml", type=options.FILE,
    help="Sweep file instead of quantities, --axis, --over, --reduce and --q.",
)  # fmt: skip
@click.option(
    "--save-spec", metavar="FILE.toml", type=options.FILE,
    help="Write the sweep file; without --out nothing is computed.",
)  # fmt: skip
@click.option("--out", type=options.TABLE, help="Where the numbers go.")
@options.threads_option
@options.json_option
def sweep(
    quantities: tuple[str, ...],
    axes: tuple[tuple[str, Span | tuple[float, ...]], ...],
    robot: Path | None,
    settings: tuple[tuple[str, float], ...],
    simulation: Simulation,
    over: str | None,
    reduce: tuple[str, ...],
    q: float | None,
    dtype: str | None,
    spec_file: Path | None,
    save_spec: Path | None,
    out: Path | None,
    threads: int | None,
    json_: bool,
) -> None:
    """Evaluate quantities on a grid and write a Parquet file."""
    from locosweep.files.atomic import check_file_name
    from locosweep.specs.sweep import Spec

    if spec_file is not None:
        given: dict[str, object] = {"QUANTITY": quantities, "--axis": axes, "--over": over}
        given |= {"--reduce": reduce, "--q": q, "--dtype": dtype}
        refuse_beside("--spec", given, simulation)
        read = Spec.load(spec_file)
        spec = replace(read, fixed=fixed(robot, settings, dict(read.axes), read.fixed))
    elif not quantities:
        raise InputError("QUANTITY is missing: name at least one, or give --spec FILE.toml")
    else:
        refuse_idle(dict(axes), quantities, simulation)
        values = fixed(robot, settings, dict(axes))
        spec = Spec(quantities, axes, values, over, reduce, q, dtype or "float64", simulation)
    if out is None and save_spec is None:
        raise InputError("--out is missing: allowed is a file that ends in .parquet")
    report: dict[str, object] = {"file": None, "spec": None}
    if save_spec is not None:
        check_file_name(save_spec)
        # Refused now rather than when the file is run.
        spec.grid()
    if out is not None:
        result = spec.run(threads=threads, progress=on_terminal())
        result.save(out)
        report |= {"file": out, **summary(result)}
    if save_spec is not None:
        spec.save(save_spec)
        report["spec"] = save_spec
    show(json_, report, out, save_spec)
