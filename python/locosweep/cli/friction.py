"""``locosweep friction``: from measured velocity and friction force to a law."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.options import called, meter, note, show
from locosweep.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path


def _labels(option: str, given: str | None) -> list[str]:
    labels = [] if given is None else [label.strip() for label in given.split(",")]
    if any(not label for label in labels):
        raise InputError(f"{option} is '{given}': allowed is RUN or RUN,RUN,...")
    return labels


@click.command()
@click.argument("data", metavar="DATA", type=options.FILE)
@options.out_option("Folder for report and pictures")
@options.column_option
@options.unit_option
@options.csv_options
@click.option("--runs", metavar="RUN,...", help="Runs to use; default all.")
@click.option(
    "--holdout", metavar="RUN,...",
    help="Runs that laws are compared on and nothing is fitted to; default each in turn.",
)  # fmt: skip
@click.option("laws", "--law", multiple=True, type=options.LAW, help="Law to fit; default all.")
@click.option(
    "--mass", metavar="KG", type=float,
    help="Moving mass: friction is then drive less mass times acceleration.",
)  # fmt: skip
@options.count_option("--seed", 0, "Start of the random numbers that choose samples for pictures.")
@options.force_option
@click.option("--quiet", is_flag=True, help="Print nothing but errors.")
@options.threads_option
@options.progress_option
@options.json_option
@click.pass_context
def friction(
    ctx: click.Context,
    data: Path,
    out: Path,
    columns: dict[str, str],
    units: dict[str, str],
    separator: str | None,
    decimal: str | None,
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
    from locosweep.files.folder import check_folder

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
        columns=columns,
        units=units,
        separator=separator,
        decimal=decimal,
        seed=seed,
        threads=threads,
        progress=meter("friction", "fits", quiet=quiet),
    )
    files = save(fit, out, command=called(ctx))
    if quiet:
        return
    for notice in fit.notices:
        note(notice)
    show(json_, {"files": files, **fit.to_dict()}, as_text(fit), "", *files)
