"""``locosweep friction``: from measured velocity and friction force to a law."""

from __future__ import annotations

from pathlib import Path

import click

from locosweep.cli.options import LAW, as_json, json_option, meter, threads_option
from locosweep.cli.simulate_runs import pairs
from locosweep.errors import InputError

__all__ = ["friction"]


def _labels(option: str, given: str | None) -> list[str]:
    labels = [label.strip() for label in (given or "").split(",")] if given is not None else []
    if any(not label for label in labels):
        raise InputError(f"{option} is '{given}': allowed is RUN or RUN,RUN,...")
    return labels


@click.command()
@click.argument("data", metavar="DATA", type=click.Path(path_type=Path))
@click.option(
    "--out", required=True, metavar="FOLDER", type=click.Path(file_okay=False, path_type=Path),
    help="Folder for report and pictures; made if missing.",
)  # fmt: skip
@click.option(
    "columns", "--column", multiple=True, metavar="NAME=THEIRS",
    help="Their name of a column, for instance force=load_cell.",
)  # fmt: skip
@click.option(
    "units", "--unit", multiple=True, metavar="NAME=UNIT",
    help="Unit of a column, for instance x=mm.",
)  # fmt: skip
@click.option(
    "--runs", metavar="RUN,...", help="Runs to use; default all.",
)  # fmt: skip
@click.option(
    "--holdout", metavar="RUN,...",
    help="Runs that laws are compared on and nothing is fitted to; default each in turn.",
)  # fmt: skip
@click.option("laws", "--law", multiple=True, type=LAW, help="Law to fit; default all.")
@click.option(
    "--mass", metavar="KG", type=float,
    help="Moving mass: friction is then drive less mass times acceleration.",
)  # fmt: skip
@click.option(
    "--seed", default=0, show_default=True, metavar="N", type=click.IntRange(min=0),
    help="Of the samples that pictures show.",
)  # fmt: skip
@click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
@threads_option
@json_option
@click.pass_context
def friction(
    ctx: click.Context,
    data: Path,
    out: Path,
    columns: tuple[str, ...],
    units: tuple[str, ...],
    runs: str | None,
    holdout: str | None,
    laws: tuple[str, ...],
    mass: float | None,
    seed: int,
    force: bool,
    quiet: bool,
    threads: int | None,
    json_: bool,
) -> None:
    """Fit friction laws to measured motion and friction force, and choose one.

    DATA is CSV or Parquet, one row a sample: t [s], x [m] or v [m/s], force (the
    friction force [N], with the sign of the motion) or drive [N] with --mass, and
    optionally run and load [N].

    Writes friction.json, friction.md, characteristic.png (force over velocity, with
    the laws), residuals.png (what the law leaves over velocity, position, time and
    load), laws.png (laws on samples held out) and force.png (force over time).
    """
    from locosweep.cli.saving import called
    from locosweep.files.folder import check_folder

    named, scaled = pairs("--column", columns), pairs("--unit", units)
    wanted = None if runs is None else _labels("--runs", runs)
    held = _labels("--holdout", holdout)
    check_folder(out, force=force)
    from locosweep.friction_fit import fit_friction
    from locosweep.friction_fit.report import as_text, save

    fit = fit_friction(
        data,
        mass=mass,
        holdout=held,
        laws=laws or None,
        runs=wanted,
        columns=named,
        units=scaled,
        seed=seed,
        threads=threads,
        progress=meter("friction", "fits", quiet=quiet),
    )
    files = save(fit, out, command=called(ctx))
    if quiet:
        return
    for notice in fit.notices:
        click.echo(f"locosweep: note: {notice}", err=True)
    if json_:
        click.echo(as_json({"files": [str(f) for f in files], **fit.to_dict()}))
    else:
        click.echo("\n".join([as_text(fit), "", *map(str, files)]))
