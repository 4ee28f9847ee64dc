"""The command that sweeps into a file or a run folder."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.options import fixed, on_terminal, show, summary
from locosweep.cli.run_options import QUANTITY_OR_SPEC, SHARD, TABLE_OR_RUN
from locosweep.cli.simulation_options import refuse_beside, refuse_idle, simulation_options
from locosweep.errors import InputError

if TYPE_CHECKING:
    from locosweep.specs.simulation import Simulation
    from locosweep.specs.span import Span


@click.command(cls=options.SweepCommand)
@click.argument("quantities", nargs=-1, type=QUANTITY_OR_SPEC, metavar="QUANTITY...|SPEC.toml")
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
@click.option(
    "--out", type=TABLE_OR_RUN,
    help="Where the numbers go: a file, or a folder that is filled chunk by chunk, and resumed "
    "by the same command.",
)  # fmt: skip
@click.option(
    "--shard", type=SHARD,
    help="Of a folder, compute every N-th chunk from the I-th on, then what others miss.",
)  # fmt: skip
@click.option(
    "--dask", metavar="SCHEDULER",
    help="Of a folder, let workers of a Dask cluster compute: address of its scheduler.",
)  # fmt: skip
@click.option("--chunk", type=click.IntRange(min=1), metavar="CELLS", help="Cells of a chunk.")
@click.option(
    "--allow-drift", is_flag=True,
    help="Resume a folder although this version computes other bits.",
)  # fmt: skip
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
    out: Path | str | None,
    shard: tuple[int, int] | None,
    dask: str | None,
    chunk: int | None,
    allow_drift: bool,
    threads: int | None,
    json_: bool,
) -> None:
    """Evaluate quantities on a grid and write a Parquet file or a run folder."""
    from locosweep.cli.dask_cluster import cluster
    from locosweep.files.atomic import check_file_name
    from locosweep.specs.sweep import Spec

    files = [name for name in quantities if name.endswith(".toml")]
    if files:
        if len(quantities) > 1 or spec_file is not None:
            raise InputError(f"{files[0]} is given beside QUANTITY or --spec: allowed is either")
        quantities, spec_file = (), Path(files[0])
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
        raise InputError("--out is missing: allowed is a file that ends in .parquet, or a folder")
    stored = {"shard": shard, "dask": dask, "chunk": chunk, "allow": allow_drift or None}
    if not isinstance(out, str) and any(value is not None for value in stored.values()):
        raise InputError(
            "--shard, --dask, --chunk and --allow-drift are allowed with --out FOLDER/ only"
        )
    report: dict[str, object] = {"file": None, "spec": None}
    if save_spec is not None:
        check_file_name(save_spec)
        # Refused now rather than when the file is run.
        spec.grid()
    if isinstance(out, str):
        with cluster(dask) as client:
            run = spec.run(
                out=out, threads=threads, progress=on_terminal(), shard=shard, chunk=chunk,
                allow_drift=allow_drift, client=client,
            )  # fmt: skip
        report |= {"file": run.folder, **run.summary()}
    elif out is not None:
        result = spec.run(threads=threads, progress=on_terminal())
        result.save(out)
        report |= {"file": out, **summary(result)}
    if save_spec is not None:
        spec.save(save_spec)
        report["spec"] = save_spec
    show(json_, report, out, save_spec)
