"""``locosweep sensitivity``: which unknown parameter matters most."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.options import PICTURE, QUANTITY, meter, show
from locosweep.cli.simulation_options import simulation_options
from locosweep.cli.uncertainty_options import (
    known,
    samples_option,
    save_plot,
    seed_option,
    unknown_option,
)

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.specs.simulation import Simulation


@click.command(cls=options.SweepCommand)
@click.argument("quantity", type=QUANTITY)
@unknown_option
@options.robot_option
@options.set_option
@click.option(
    "--failed", type=float, metavar="NUMBER",
    help="What a point without a value counts as, such as 0 for a robot that does not move.",
)  # fmt: skip
@samples_option
@seed_option
@simulation_options(gait=True)
@click.option("--plot", "picture", type=PICTURE, help="Both indices of each parameter.")
@options.threads_option
@options.progress_option
@options.json_option
@click.pass_context
def sensitivity(
    ctx: click.Context,
    quantity: str,
    unknown: dict[str, str],
    robot: Path | None,
    settings: tuple[tuple[str, float], ...],
    failed: float | None,
    samples: int,
    seed: int,
    simulation: Simulation,
    picture: Path | None,
    threads: int | None,
    json_: bool,
) -> None:
    """Say which unknown parameter makes how much of a quantity's variance: Sobol indices."""
    from locosweep.uncertainty.sensitivity import sensitivity as run

    given = known(robot, settings, unknown, simulation)
    found = run(
        quantity, unknown, failed=failed, samples=samples, seed=seed, threads=threads,
        progress=meter(quantity), **given,
    )  # fmt: skip
    save_plot(ctx, found, picture)
    report = {
        "quantity": quantity,
        "unit": found.output.unit,
        "unknown": unknown,
        "samples": samples,
        "seed": seed,
        "deviation": found.deviation,
        "without_value": found.without_value,
        "failed": found.failed,
        "indices": found.to_polars().to_dicts(),
        "fixed": found.fixed,
    }
    show(json_, report, repr(found), picture)
