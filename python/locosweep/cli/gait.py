"""``locosweep gait``: one whole robot, from a gait file to pictures and tables."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from locosweep.cli.options import as_json, json_option
from locosweep.errors import InputError

if TYPE_CHECKING:
    import polars as pl

    from locosweep.simulation.gait import GaitRun

__all__ = ["gait", "refuse_full"]


@click.command()
@click.argument("spec", metavar="SPEC.toml", type=click.Path(path_type=Path))
@click.option(
    "--out", required=True, metavar="FOLDER", type=click.Path(file_okay=False, path_type=Path),
    help="Folder for pictures and tables; made if missing.",
)  # fmt: skip
@click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
@click.option(
    "--samples", default=1201, show_default=True, metavar="N", type=click.IntRange(min=2),
    help="Times at which the motion is kept.",
)  # fmt: skip
@json_option
@click.pass_context
def gait(ctx: click.Context, spec: Path, out: Path, force: bool, samples: int, json_: bool) -> None:
    """Simulate one whole robot through its gait.

    Writes spacetime.png (where the segments are, who is anchored and who slides),
    forces.png (propulsive force, joint forces, electrical power), summary.md,
    summary.csv and trace.parquet.
    """
    from locosweep.specs.gait import GaitSpec

    given = GaitSpec.load(spec)
    if not force:
        refuse_full(out)
    try:
        run = given.run(samples=samples)
    except InputError as error:
        raise InputError(f"{spec}: {error}") from None
    files = _write(ctx, spec, run, out)
    told = _told(run)
    if json_:
        click.echo(as_json({"files": [str(f) for f in files], "summary": told, **run.results}))
    else:
        click.echo("\n".join([*map(str, files), told]))


def refuse_full(out: Path) -> None:
    """Refuse a folder that holds something."""
    try:
        full = out.exists() and any(out.iterdir())
    except OSError as error:
        raise InputError(f"{out}: cannot read this folder: {error.strerror}") from None
    if full:
        raise InputError(f"{out} is not empty: name another folder, or give --force")


def _told(run: GaitRun) -> str:
    """Say what the robot does in one line."""
    from locosweep.plot.style import with_unit

    count = run.x.shape[1]
    results = run.results
    slip = results["slip_max"]
    back = f"up to {with_unit(1000 * slip, 'mm')} back per cycle" if slip else "nothing slides back"
    return (
        f"{run.gait}, {count} segments: {with_unit(1000 * results['velocity'], 'mm/s')}, "
        f"{with_unit(1000 * results['advance'], 'mm')} per cycle, {back}, anchors hold "
        f"{with_unit(results['anchor_safety'], '1')} times their largest load, "
        f"{with_unit(results['power_mean'], 'W')} mean power"
    )


def _write(ctx: click.Context, spec: Path, run: GaitRun, out: Path) -> list[Path]:
    from locosweep.cli.saving import called
    from locosweep.plot.gait import force_power, space_time_figure
    from locosweep.plot.save import save_figure

    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{out}: cannot make this folder: {error.strerror}") from None
    told = _told(run)
    title = told.replace(", anchors", ",\nanchors")
    pictures = {
        "spacetime.png": space_time_figure(run, title),
        "forces.png": force_power(run, title),
    }
    files = []
    for name, figure in pictures.items():
        save_figure(figure, out / name, command=called(ctx))
        files.append(out / name)
    tables = {"summary.md": _markdown(spec, run), "summary.csv": run.summary.write_csv()}
    for name, text in tables.items():
        _text(out / name, text)
        files.append(out / name)
    _frame(out / "trace.parquet", run.to_polars())
    return [*files, out / "trace.parquet"]


def _text(path: Path, text: str) -> None:
    from locosweep.files.atomic import replacing

    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def _frame(path: Path, frame: pl.DataFrame) -> None:
    import polars as pl

    from locosweep.files.atomic import replacing

    with replacing(path) as temporary:
        try:
            frame.write_parquet(temporary)
        except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
            raise InputError(f"{path}: cannot write: {error}") from None


def _markdown(spec: Path, run: GaitRun) -> str:
    from locosweep import _core
    from locosweep.simulation.gait import gait_parameters

    lines = [
        f"# Gait {run.gait}",
        "",
        f"{_told(run)}.",
        "",
        f"Computed by locosweep {_core.version()} from {spec.name}.",
        "",
        "| Result | Value | Unit | Meaning |",
        "| --- | --- | --- | --- |",
    ]
    for name, value, unit, meaning in run.summary.iter_rows():
        lines.append(f"| {name} | {value:.6g} | {unit} | {meaning} |")
    slips = ", ".join(f"{1000 * way:.4g}" for way in run.slip)
    lines += ["", f"Sliding backward per cycle, from the head, in mm: {slips}.", ""]
    lines += ["| Parameter | Value | Unit |", "| --- | --- | --- |"]
    for name, record in gait_parameters().items():
        value = run.values[name]
        several = value if isinstance(value, tuple) else (value,)
        text = ", ".join(f"{one:.6g}" for one in several)
        lines.append(f"| {name} | {text} | {record.parameter.unit} |")
    lines += ["", "![Segments over time](spacetime.png)", "", "![Forces and power](forces.png)"]
    return "\n".join(lines) + "\n"
