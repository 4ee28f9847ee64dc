"""The command that simulates a few trajectories and keeps their motion."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.options import called, fixed, meter, refuse_same, show, values_of
from locosweep.cli.simulate_runs import replay
from locosweep.cli.simulation_options import refuse_beside, refuse_idle, simulation_options
from locosweep.errors import InputError, SolveError
from locosweep.files.strict_json import plain

if TYPE_CHECKING:
    from locosweep.simulation.trajectories import Trajectories
    from locosweep.specs.simulation import Simulation
    from locosweep.specs.span import Span

    Setting = tuple[str, Span | tuple[float, ...]]

_ENTRY = "final_position"
"""Quantity that a trajectory is checked as: all simulated ones share its parameters."""

_LEDGER = "energy_residual"

_OPEN = 1e-2
"""Share of the work from which an open energy ledger is worth a word."""

_ADAPTIVE = ("rosenbrock", "dormand_prince")

_MOST_CURVES = 8


@click.command(cls=options.SweepCommand)
@simulation_options()
@click.option(
    "settings", "--set", multiple=True, type=options.AXIS,
    help="Fix a parameter, NAME=VALUE, or simulate several: NAME=A,B,C or NAME=LO:HI:COUNT.",
)  # fmt: skip
@options.robot_option
@options.count_option(
    "--samples", 501, "Evenly spread times from 0 to the duration at which motion is kept.", least=2
)
@click.option("--out", type=options.CURVES, help="Where the motion goes.")
@click.option(
    "plot_file", "--plot", type=options.PICTURE, help="Picture of position, speed and force."
)
@click.option(
    "--model", metavar="MODEL.toml", type=options.FILE,
    help="Model that measured runs are replayed through.",
)  # fmt: skip
@click.option(
    "--runs", metavar="RUNS", type=options.FILE,
    help="Measured runs (CSV or Parquet) to replay through the model, with --model and --out.",
)  # fmt: skip
@options.map_option
@options.unit_option
@options.csv_options
@options.threads_option
@options.progress_option
@options.json_option
@click.pass_context
def simulate(
    ctx: click.Context,
    simulation: Simulation,
    settings: tuple[Setting, ...],
    robot: Path | None,
    samples: int,
    out: Path | None,
    plot_file: Path | None,
    model: Path | None,
    runs: Path | None,
    columns: dict[str, str],
    units: dict[str, str],
    separator: str | None,
    decimal: str | None,
    threads: int | None,
    json_: bool,
) -> None:
    """Simulate one segment under a friction law and a drive.

    The file has a row for each sample: the parameters with several values, t [s],
    position x [m], speed v [m/s], force of the drive [N], and way: the direction
    of sliding, 0 while dry friction holds the segment.

    With --model and --runs the drive of measured runs is replayed through a
    nominal or an augmented model instead; the file then has the columns run, t, x,
    v, x_rear and force: what the sensors would read, without noise.
    """
    drive_file = None if simulation.drive_file is None else Path(simulation.drive_file)
    refuse_same(out, runs=runs, model=model, drive_file=drive_file, plot=plot_file)
    if model is not None or runs is not None:
        chosen = ctx.get_parameter_source("samples") is click.core.ParameterSource.COMMANDLINE
        given = {
            "--set": settings, "--robot": robot, "--plot": plot_file, "--samples": chosen,
        }  # fmt: skip
        refuse_beside("--model and --runs", given, simulation)
        if model is None or runs is None or out is None:
            missing = {"--model": model, "--runs": runs, "--out": out}
            first = next(name for name, value in missing.items() if value is None)
            raise InputError(f"{first} is missing: a replay takes --model, --runs and --out")
        from locosweep.files.csv_form import CsvForm

        form = CsvForm(separator, decimal)
        replay(
            model, runs, out, columns=columns, units=units, form=form, threads=threads, json_=json_
        )
        return
    if columns or units or separator or decimal:
        raise InputError(
            "--column and --unit, --separator and --decimal are allowed with --runs only"
        )
    if out is None and plot_file is None:
        raise InputError("--out is missing: allowed is a file that ends in .csv or .parquet, or "
                         "--plot with a picture")  # fmt: skip
    from locosweep.grid import Grid
    from locosweep.simulation.trajectories import simulate as simulated

    given_values = values_of(settings)
    axes = {name: values for name, values in given_values.items() if len(values) > 1}
    single = [(name, values[0]) for name, values in given_values.items() if name not in axes]
    refuse_idle(axes, [_ENTRY], simulation)
    values = dict(fixed(robot, single, axes))
    curves = math.prod(map(len, axes.values()))
    if plot_file is not None and curves > _MOST_CURVES:
        raise InputError(f"--plot would show {curves} curves: allowed are 1 to {_MOST_CURVES}")
    run = simulated(
        Grid(**axes, **values),
        **simulation.options(),
        samples=samples,
        threads=threads,
        progress=meter("simulate", "trajectories"),
    )
    open_share = _open_share(run, simulation, threads)
    about = _summary(run)
    if out is not None:
        from locosweep.files.atomic import write_frame

        header = plain({key: value for key, value in about.items() if key != "curves"})
        write_frame(out, run.to_polars(), {"locosweep.motion": json.dumps(header)})
    if plot_file is not None:
        from locosweep.plot import style
        from locosweep.plot.save import save_figure
        from locosweep.plot.trajectories import motion

        # A figure of its own: pyplot would look for a display.
        figure = style.figure(8.0, 7.0)
        motion(run, axes=figure.subplots(3, 1, sharex=True))
        save_figure(figure, plot_file, command=called(ctx))
    files = [path for path in (out, plot_file) if path is not None]
    show(json_, {"files": files, **about, "energy_residual": open_share}, *files)
    if open_share > _OPEN:
        aim = "tolerance" if run.method in _ADAPTIVE else "time_step"
        text = f"the energy ledger leaves {open_share:.2g} of the work open: with a smaller {aim}"
        now = "an axis" if aim in run.axes else f"now {run.fixed[aim]:g}"
        click.echo(f"locosweep: note: {text} ({now}) the motion may differ", err=True)
    if lost := _lost(run):
        raise SolveError(lost)


def _lost(run: Trajectories) -> str:
    """Return which curves fail, why and from when on; nothing if none does."""
    import numpy as np

    failed = np.argwhere(run.status)
    if not len(failed):
        return ""
    at = tuple(failed[0].tolist())
    status, since = run.failure(at)
    gone = "" if since is None else f"no values from {since:g} s on: "
    place = ", ".join(
        f"{name}={values[i]:g}" for (name, values), i in zip(run.axes.items(), at, strict=True)
    )
    others = f"; {len(failed) - 1} other curves fail too" if len(failed) > 1 else ""
    curve = f"{place}: " if place else ""
    return f"{curve}{gone}{status.sentence} ({status.name.lower()}){others}"


def _open_share(run: Trajectories, simulation: Simulation, threads: int | None) -> float:
    """Return the largest share of the work that the energy ledger leaves open, NaN without one."""
    import numpy as np

    from locosweep.engine import sweep
    from locosweep.grid import Grid

    options = {**simulation.options(), "method": run.method}
    values = sweep(_LEDGER, Grid(**run.axes, **run.fixed), **options, threads=threads).values
    found = np.abs(values[np.isfinite(values)])
    return float(found.max()) if found.size else math.nan


def _summary(run: Trajectories) -> dict[str, object]:
    """Describe trajectories for JSON."""
    import numpy as np

    ends = run.x[..., -1].ravel()
    return {
        "law": run.law,
        "drive": run.drive,
        "method": run.method,
        "axes": {name: axis.tolist() for name, axis in run.axes.items()},
        "curves": int(ends.size),
        "curves_with_values": int(np.isfinite(ends).sum()),
        "final_position": ends.tolist(),
        "fixed": run.fixed,
    }
