"""Options of the commands about what is unknown."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from locosweep.cli.options import called, fixed, pair_option

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from locosweep.specs.simulation import Simulation
    from locosweep.uncertainty.propagation import Propagation
    from locosweep.uncertainty.sensitivity import Sensitivity

unknown_option = pair_option(
    "unknown", "--unknown", metavar="NAME=DISTRIBUTION",
    text="Parameter, or ratio A/B, that is not known: LOW:HIGH, normal:MEAN:DEVIATION, "
    "lognormal:MEDIAN:FACTOR or triangular:LOW:MODE:HIGH; repeat.",
)  # fmt: skip
samples_option = click.option(
    "--samples", type=click.IntRange(min=2), default=2**14, show_default=True, metavar="N",
    help="Points, a power of two.",
)  # fmt: skip
seed_option = click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, metavar="S",
    help="Of the points.",
)  # fmt: skip


def known(
    robot: Path | None,
    settings: Iterable[tuple[str, float]],
    unknown: Mapping[str, str],
    simulation: Simulation,
    axes: Iterable[str] = (),
) -> dict[str, Any]:
    """Return what is known: parameters of the robot file and of --set, and the simulation."""
    names = {key.partition("/")[0] for key in unknown}
    given = dict(fixed(robot, settings, [*axes, *names]))
    return {**given, **simulation.options()}


def save_plot(ctx: click.Context, found: Propagation | Sensitivity, picture: Path | None) -> None:
    """Write the picture of what was found, if one is asked for."""
    if picture is None:
        return
    from locosweep.plot.save import save_figure
    from locosweep.uncertainty.picture import drawn

    save_figure(drawn(found), picture, command=called(ctx))
