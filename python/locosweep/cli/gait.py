"""``locosweep gait``: one whole robot, from a gait file to pictures and tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from locosweep.cli import options
from locosweep.cli.options import called, meter, show
from locosweep.errors import InputError, SolveError

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.simulation.gait import GaitRun


_SPEED = "mean_velocity"
"""Quantity whose closed form a run is held against."""


@click.command()
@click.argument("spec", metavar="SPEC.toml", type=options.FILE)
@options.out_option("Folder for pictures and tables")
@options.force_option
@options.count_option("--samples", 1201, "Times at which the motion is kept.", least=2)
@options.progress_option
@options.json_option
@click.pass_context
def gait(ctx: click.Context, spec: Path, out: Path, force: bool, samples: int, json_: bool) -> None:
    """Simulate one whole robot through its gait.

    Writes spacetime.png (where the segments are, who is anchored and who slides, what
    lubricant they push along),
    forces.png (propulsive force, joint forces, electrical power), summary.md,
    summary.csv and trace.parquet.
    """
    from locosweep.files.folder import check_folder
    from locosweep.progress import Steps
    from locosweep.specs.gait import GaitSpec

    given = GaitSpec.load(spec)
    check_folder(out, force=force)
    bar = meter("gait", "steps")
    step = Steps(bar, ["simulating", "drawing"])
    step("simulating")
    try:
        run = given.run(samples=samples)
    except (InputError, SolveError) as error:
        raise type(error)(f"{spec}: {error}") from None
    step("drawing")
    files = _write(ctx, spec, run, out)
    step.end()
    summary = _summary(run)
    beside = _closed_form(run)
    record = {"files": files, "summary": summary, **run.results}
    show(json_, record, *files, summary, beside or None)


def _closed_form(run: GaitRun) -> str:
    """Say what the closed form gives for the same robot, and why it differs; nothing without one.

    There is one where one segment moves after another and all have the same values.
    """
    import numpy as np

    from locosweep import registry
    from locosweep.engine import sweep
    from locosweep.plot.style import with_unit

    known = {parameter.name for parameter in registry.quantity(_SPEED).parameters}
    values: dict[str, Any] = {name: v for name, v in run.values.items() if name in known}
    if run.gait != "single" or any(isinstance(value, tuple) for value in values.values()):
        return ""
    speed = float(sweep(_SPEED, **values).values)
    if not np.isfinite(speed):
        return ""
    reasons = []
    if np.isfinite(np.max(run.values["drive_limit"])):
        reasons.append("one actuator drives each moving segment, here an inner one has two")
    if np.max(run.values["dwell"]) > 0:
        reasons.append(f"no segment rests, here {run.values['dwell']:g} s after each phase")
    there = f"; there {', and '.join(reasons)}" if reasons else ""
    said = "closed form of the same robot (mean_velocity, as in locosweep optimum)"
    return f"{said}: {with_unit(1000 * speed, 'mm/s')}{there}"


def _summary(run: GaitRun) -> str:
    """Return speed, slip, anchor reserve and power in one line."""
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
    from locosweep.files.atomic import write_frame, write_text
    from locosweep.files.folder import make_folder
    from locosweep.plot.gait import force_power, space_time_figure
    from locosweep.plot.save import save_figure

    make_folder(out)
    title = _summary(run).replace(", anchors", ",\nanchors")
    pictures = {
        "spacetime.png": space_time_figure(run, title),
        "forces.png": force_power(run, title),
    }
    files = []
    for name, figure in pictures.items():
        files.append(out / name)
        save_figure(figure, files[-1], command=called(ctx))
    write_text(out / "summary.md", _markdown(spec, run))
    write_frame(out / "summary.csv", run.summary)
    write_frame(out / "trace.parquet", run.to_polars())
    return [*files, *(out / name for name in ("summary.md", "summary.csv", "trace.parquet"))]


def _markdown(spec: Path, run: GaitRun) -> str:
    from locosweep import _core
    from locosweep.simulation.gait import gait_parameters

    lines = [
        f"# Gait {run.gait}",
        "",
        f"{_summary(run)}.",
        "",
        *((f"{beside}.", "") if (beside := _closed_form(run)) else ()),
        f"Computed by locosweep {_core.version()} from {spec.name}.",
        "",
        "| Result | Value | Unit | Meaning |",
        "| --- | --- | --- | --- |",
    ]
    for name, value, unit, meaning in run.summary.iter_rows():
        lines.append(f"| {name} | {value:.6g} | {unit} | {meaning} |")
    slips = ", ".join(f"{1000 * slip:.4g}" for slip in run.slip)
    lines += ["", f"Sliding backward per cycle, from the head, in mm: {slips}.", ""]
    lines += ["| Parameter | Value | Unit |", "| --- | --- | --- |"]
    for name, record in gait_parameters().items():
        value = run.values[name]
        several = value if isinstance(value, tuple) else (value,)
        text = ", ".join(f"{one:.6g}" for one in several)
        lines.append(f"| {name} | {text} | {record.parameter.unit} |")
    lines += ["", "![Segments over time](spacetime.png)", "", "![Forces and power](forces.png)"]
    return "\n".join(lines) + "\n"
