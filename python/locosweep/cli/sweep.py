"""The command that sweeps into a file or a run folder."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.options import meter, refuse_same, show, summary
from locosweep.cli.run_options import QUANTITY_OR_SPEC, SHARD, TABLE_OR_RUN
from locosweep.cli.sweep_options import sweep_options
from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from locosweep.specs.sweep import Spec


@click.command(cls=options.SweepCommand)
@click.argument("quantities", nargs=-1, type=QUANTITY_OR_SPEC, metavar="QUANTITY...|SPEC.toml")
@sweep_options
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
@options.progress_option
@options.json_option
def sweep(
    quantities: tuple[str, ...],
    save_spec: Path | None,
    out: Path | str | None,
    shard: tuple[int, int] | None,
    dask: str | None,
    chunk: int | None,
    allow_drift: bool,
    threads: int | None,
    json_: bool,
    asked: Callable[[tuple[str, ...]], Spec],
) -> None:
    """Evaluate quantities on a grid and write a Parquet file or a run folder."""
    from locosweep.cli.dask_cluster import cluster
    from locosweep.files.atomic import check_file_name

    spec = asked(quantities)
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
        refuse_same(None if isinstance(out, str) else out, save_spec=save_spec)
        # Refused now rather than when the file is run.
        spec.grid()
    bar = meter(", ".join(spec.quantities))
    if isinstance(out, str):
        with cluster(dask) as client:
            run = spec.run(
                out=out, threads=threads, progress=bar, shard=shard, chunk=chunk,
                allow_drift=allow_drift, client=client,
            )  # fmt: skip
        report |= {"file": run.folder, **run.summary()}
    elif out is not None:
        result = spec.run(threads=threads, progress=bar)
        result.save(out)
        report |= {"file": out, **summary(result)}
    if save_spec is not None:
        spec.save(save_spec)
        report["spec"] = save_spec
    show(json_, report, out, save_spec)
