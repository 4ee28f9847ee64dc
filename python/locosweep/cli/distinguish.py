"""``locosweep distinguish``: what a planned experiment could tell apart."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from locosweep import registry
from locosweep.cli import options
from locosweep.cli.options import called, meter, number, refuse_same, show, values_of
from locosweep.cli.simulation_options import chosen
from locosweep.errors import InputError

if TYPE_CHECKING:
    from locosweep.diagnosis.design.distinguish import Distinction
    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run
    from locosweep.specs.span import Span

    Setting = tuple[str, Span | tuple[float, ...]]

_TIME = "duration"
_MOST_RUNS = 64
_MOST_RIVALS = 4


@click.command(cls=options.SweepCommand)
@click.argument("nominal", metavar="NOMINAL.toml", type=options.FILE)
@click.option("--drive", type=options.DRIVE, metavar="NAME", help="Drive of the planned runs.")
@click.option(
    "--drive-file", type=options.FILE, metavar="FILE.csv",
    help="Samples for --drive table: columns t [s] and drive; each holds until the next.",
)  # fmt: skip
@click.option(
    "settings", "--set", multiple=True, type=options.AXIS,
    help="A parameter of the drive or the duration, NAME=VALUE; a run for each of NAME=A,B,C.",
)  # fmt: skip
@options.count_option("--samples", 1001, "Samples of each run, evenly spread.", least=20)
@click.option(
    "--runs", metavar="RUNS", type=options.FILE,
    help="Instead of --drive: a file of runs (t, drive, and slope_deg where it differs).",
)  # fmt: skip
@click.option(
    "channels", "--channel", multiple=True, metavar="NAME",
    help="What will be measured, of x, v, x_rear, force; repeat as needed; default x.",
)  # fmt: skip
@options.pair_option(
    "--noise", metavar="NAME=SD", text="Noise of a channel; default from the file's [sensor] table."
)
@click.option(
    "--size", default=10.0, show_default=True, metavar="SIGMAS", type=float,
    help="Length of each effect's signal in the matrix.",
)  # fmt: skip
@click.option("--out", type=options.CURVES, help="Where the table of distances goes.")
@click.option("plot_file", "--plot", type=options.PICTURE, help="Picture of the matrix.")
@click.option("--quiet", is_flag=True, help="Show no progress.")
@options.threads_option
@options.progress_option
@options.json_option
@click.pass_context
def distinguish(
    ctx: click.Context,
    nominal: Path,
    drive: str | None,
    drive_file: Path | None,
    settings: tuple[Setting, ...],
    samples: int,
    runs: Path | None,
    channels: tuple[str, ...],
    noise: dict[str, str],
    size: float,
    out: Path | None,
    plot_file: Path | None,
    quiet: bool,
    threads: int | None,
    json_: bool,
) -> None:
    """Say before anything is measured which effects an experiment could tell apart.

    For each effect: how large it must be to be seen (a signal of 6 sigmas), its
    nearest rival, and all rivals that the experiment could not tell from it (less
    than 3 sigmas are left of its signal after the rival is refitted).
    """
    from locosweep.diagnosis.design.distinguish import distinguish as distinguished
    from locosweep.files.robot import load_robot

    refuse_same(out, runs=runs, drive_file=drive_file, plot=plot_file)
    if (runs is None) == (drive is None and drive_file is None):
        raise InputError("allowed is one of --drive (or --drive-file) and --runs")
    robot = load_robot(nominal)
    planned: Any = runs
    if runs is None:
        planned = _planned(robot, drive, drive_file, settings, samples)
    elif settings:
        raise InputError("--set is given beside --runs: allowed is --set with --drive")
    found = distinguished(
        robot,
        planned,
        channels=channels or None,
        noise={name: number(f"--noise {name}", text) for name, text in noise.items()},
        size=size,
        threads=threads,
        progress=meter("distinguish", "effects", quiet=quiet),
    )
    files = []
    if out is not None:
        _save(found, out)
        files.append(out)
    if plot_file is not None:
        from locosweep.diagnosis.design.figures_matrix import matrix_figure
        from locosweep.plot.save import save_figure

        save_figure(matrix_figure(found), plot_file, command=called(ctx))
        files.append(plot_file)
    show(json_, _report(found, files), *_lines(found), *files)


def _planned(
    robot: Robot,
    drive: str | None,
    drive_file: Path | None,
    settings: tuple[Setting, ...],
    samples: int,
) -> list[Run]:
    """Return a run for each combination of the drive's parameters."""
    from locosweep.files.runs import Run
    from locosweep.grid import Grid
    from locosweep.simulation.trajectories import simulate

    simulation = chosen(None, drive, None, drive_file)
    own = {p.name for p in registry.drive(simulation.drive or "").parameters} | {_TIME}
    given = values_of(settings)
    for name in given:
        if name not in own or name == "gain":
            allowed = ", ".join(sorted(own - {"gain"}))
            raise InputError(f"--set {name}: allowed for drive {simulation.drive} are {allowed}")
    count = math.prod(map(len, given.values()))
    if count > _MOST_RUNS:
        raise InputError(f"--set makes {count} runs: allowed are 1 to {_MOST_RUNS}")
    gain = robot.parameters.get("gain", 1.0)
    if gain == 0.0:
        raise InputError("[drive] gain is 0: allowed is another number, as no drive moves the head")
    # The force of a drive is the same whatever it moves.
    fixed = {"mu_coulomb": 0.5, "gain": gain, "drive_limit": math.inf}
    chosen_options = {**simulation.options(), "law": "coulomb"}
    several = {name: values for name, values in given.items() if len(values) > 1}
    found = []
    for point in itertools.product(*given.values()):
        chosen_values = dict(zip(given, point, strict=True))
        run = simulate(Grid(**fixed, **chosen_values), **chosen_options, samples=samples)
        label = ", ".join(f"{name}={chosen_values[name]:g}" for name in several) or str(
            simulation.drive
        )
        found.append(Run(label, run.t, run.force / gain))
    return found


def _save(found: Distinction, out: Path) -> None:
    """Write the long table of pairs."""
    import polars as pl

    from locosweep.files.atomic import write_frame

    count = len(found.names)
    frame = pl.DataFrame(
        {
            "effect": [name for name in found.names for _ in range(count)],
            "rival": list(found.names) * count,
            "distance": found.distances.ravel(),
        }
    )
    write_frame(out, frame)


def _report(found: Distinction, files: list[Path]) -> dict[str, object]:
    return {
        "files": files,
        "size": found.size,
        "noise": found.noise,
        "effects": found.to_polars().to_dicts(),
        "names": found.names,
        "distances": found.distances,
    }


def _lines(found: Distinction) -> list[str]:
    """Return the table for people: a line an effect."""
    rows = found.to_polars().to_dicts()
    wide = max(len(row["effect"]) for row in rows)
    room = max((len(row["seen_from"]) for row in rows if row["seen_from"]), default=9)
    lines = [f"{'effect':<{wide}}  {'seen from':<{room}}  not told from"]
    for row in rows:
        if row["unseen_because"]:
            lines.append(f"{row['effect']:<{wide}}  not seen: {row['unseen_because']}")
        else:
            near = found.rivals(row["effect"])
            more = f" and {len(near) - _MOST_RIVALS} more" if len(near) > _MOST_RIVALS else ""
            rivals = ", ".join(near[:_MOST_RIVALS]) + more or "-"
            lines.append(f"{row['effect']:<{wide}}  {row['seen_from']:<{room}}  {rivals}")
    return lines
