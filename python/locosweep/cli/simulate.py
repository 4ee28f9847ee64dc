"""The command that simulates a few trajectories and keeps their motion."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from locosweep.cli.options import (
    AXIS,
    CURVES,
    PICTURE,
    SweepCommand,
    as_json,
    fixed,
    json_option,
    on_terminal,
    robot_option,
    threads_option,
)
from locosweep.cli.simulate_runs import replay
from locosweep.cli.simulation_options import chosen, refuse_idle, simulation_options
from locosweep.errors import InputError

if TYPE_CHECKING:
    from locosweep.simulation.trajectories import Trajectories
    from locosweep.specs.simulation import Simulation
    from locosweep.specs.sweep import Span

    Setting = tuple[str, Span | tuple[float, ...]]

__all__ = ["simulate"]

_ENTRY = "final_position"
"""What a trajectory is checked as: all simulated quantities share its parameters."""

_LEDGER = "energy_residual"

_OPEN = 1e-2
"""Share of the work from which an open energy ledger is worth a word."""

_ADAPTIVE = "rosenbrock"

_MOST_CURVES = 8


@click.command(cls=SweepCommand)
@simulation_options
@click.option(
    "settings",
    "--set",
    multiple=True,
    type=AXIS,
    help="Fix a parameter, NAME=VALUE, or simulate several: NAME=A,B,C or NAME=LO:HI:COUNT.",
)
@robot_option
@click.option(
    "--samples",
    metavar="N",
    type=click.IntRange(min=2),
    default=501,
    show_default=True,
    help="Evenly spread times from 0 to the duration at which motion is kept.",
)
@click.option("--out", type=CURVES, help="Where the motion goes.")
@click.option("plot_file", "--plot", type=PICTURE, help="Picture of position, speed and force.")
@click.option(
    "--model", metavar="MODEL.toml", type=click.Path(path_type=Path),
    help="Model that measured runs are replayed through.",
)  # fmt: skip
@click.option(
    "--runs", metavar="RUNS", type=click.Path(path_type=Path),
    help="Measured runs (CSV or Parquet) to replay through the model, with --model and --out.",
)  # fmt: skip
@click.option(
    "columns",
    "--column",
    multiple=True,
    metavar="NAME=THEIRS",
    help="Their name of a column of the runs, for instance drive=tau.",
)
@click.option(
    "units",
    "--unit",
    multiple=True,
    metavar="NAME=UNIT",
    help="Unit of a column of the runs, for instance x=mm.",
)
@threads_option
@json_option
@click.pass_context
def simulate(
    ctx: click.Context,
    law: str | None,
    drive: str | None,
    method: str | None,
    drive_file: Path | None,
    settings: tuple[Setting, ...],
    robot: Path | None,
    samples: int,
    out: Path | None,
    plot_file: Path | None,
    model: Path | None,
    runs: Path | None,
    columns: tuple[str, ...],
    units: tuple[str, ...],
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
    if model is not None or runs is not None:
        given = {"--law": law, "--drive": drive, "--method": method, "--drive-file": drive_file,
                 "--set": settings, "--robot": robot, "--plot": plot_file}  # fmt: skip
        for name, value in given.items():
            if value:
                raise InputError(f"{name} is given beside --model and --runs: allowed is one form")
        if model is None or runs is None or out is None:
            missing = {"--model": model, "--runs": runs, "--out": out}
            first = next(name for name, value in missing.items() if value is None)
            raise InputError(f"{first} is missing: a replay takes --model, --runs and --out")
        replay(model, runs, out, columns=columns, units=units, threads=threads, json_=json_)
        return
    if columns or units:
        raise InputError("--column and --unit are allowed with --runs only")
    if out is None and plot_file is None:
        raise InputError("--out is missing: allowed is a file that ends in .csv or .parquet, or "
                         "--plot with a picture")  # fmt: skip
    if out is not None and plot_file is not None and out.resolve() == plot_file.resolve():
        raise InputError(f"--out and --plot are both {out}: allowed are two files")
    from locosweep.grid import Grid
    from locosweep.simulation.trajectories import simulate as simulated

    simulation = chosen(law, drive, method, drive_file)
    axes, single = _split(settings)
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
        progress=on_terminal(),
    )
    open_share = _open_share(run, simulation, threads)
    figure = None if plot_file is None else _picture(run)
    if out is not None:
        _save(run, out)
    if plot_file is not None and figure is not None:
        from locosweep.cli.saving import called
        from locosweep.plot.save import save_figure

        save_figure(figure, plot_file, command=called(ctx))
    files = [str(path) for path in (out, plot_file) if path is not None]
    report = {"files": files, **_summary(run), "energy_residual": open_share}
    click.echo(as_json(report) if json_ else "\n".join(files))
    if open_share > _OPEN:
        aim = "tolerance" if run.method == _ADAPTIVE else "time_step"
        text = f"the energy ledger leaves {open_share:.2g} of the work open: with a smaller {aim}"
        now = "an axis" if aim in run.axes else f"now {run.fixed[aim]:g}"
        click.echo(f"locosweep: note: {text} ({now}) the motion may differ", err=True)


def _open_share(run: Trajectories, simulation: Simulation, threads: int | None) -> float:
    """Return the largest share of the work that the energy ledger leaves open."""
    import numpy as np

    from locosweep.engine import sweep
    from locosweep.grid import Grid

    options = simulation.options()
    values = sweep(_LEDGER, Grid(**run.axes, **run.fixed), **options, threads=threads).values
    found = np.abs(values[np.isfinite(values)])
    return float(found.max()) if found.size else 0.0


def _split(
    settings: tuple[Setting, ...],
) -> tuple[dict[str, Any], list[tuple[str, float]]]:
    """Parameters with several values, and those with one."""
    axes: dict[str, Any] = {}
    single: list[tuple[str, float]] = []
    for name, given in settings:
        values = list(given) if isinstance(given, tuple) else given.values(name).tolist()
        if name in axes or name in dict(single):
            raise InputError(f"--set gives {name} twice: allowed is once, NAME=A,B,C for several")
        if len(values) == 1:
            single.append((name, values[0]))
        else:
            axes[name] = values
    return axes, single


def _picture(run: Trajectories) -> Any:
    from locosweep.plot.trajectories import motion

    return motion(run)[0].get_figure(root=True)


def _save(run: Trajectories, out: Path) -> None:
    """Write the long table; a Parquet file also says what was simulated."""
    from locosweep.files.atomic import write_frame

    about = {key: value for key, value in _summary(run).items() if key != "curves"}
    text = json.dumps(json.loads(as_json(about)))
    write_frame(out, run.to_polars(), {"locosweep.motion": text})


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
