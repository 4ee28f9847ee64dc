"""``locosweep blind-check --rig``: the blind check on a measured rig."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from locosweep.cli import options

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from locosweep.cli.blind_check_asked import Asked
    from locosweep.files.robot import Robot

_MIXTURE = ("cases", "gap_free", "experiments", "only", "families")
"""Options of drawn rigs, which say nothing about a measured one."""


def rig_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of a measured rig to a command."""
    for option in reversed((
        click.option(
            "--rig", metavar="RUNS", type=options.FILE,
            help="Measured runs: plant each effect into their log in place of drawing rigs.",
        ),
        click.option(
            "--nominal", metavar="NOMINAL.toml", type=options.FILE,
            help="The rig's model, calibrated on these runs.",
        ),
        click.option(
            "--calibrate", is_flag=True,
            help="Fit friction, mass and gain of the model to the runs first.",
        ),
        click.option(
            "--runs", "labels", metavar="RUN,...", default="",
            help="Runs of the rig that are taken; default: all.",
        ),
        click.option(
            "--sizes", metavar="SIZE,...", default="3,10,30", show_default=True,
            help="Gaps, in what the calibrated model leaves.",
        ),
    )):  # fmt: skip
        command = option(command)
    return command


@dataclass(frozen=True)
class RigCheck:
    """What is asked of a blind check on a rig."""

    runs: Path
    nominal: Path | None
    calibrate: bool
    labels: str
    sizes: str


def refuse_mixture(ctx: click.Context) -> None:
    """Refuse options of drawn rigs beside a measured one, and the other way round."""
    from locosweep.errors import InputError

    given = [
        name
        for name in (*_MIXTURE, "nominal", "calibrate", "labels", "sizes")
        if ctx.get_parameter_source(name) is not click.core.ParameterSource.DEFAULT
    ]
    rig = ctx.params["rig"] is not None
    wrong = [name for name in given if (name in _MIXTURE) == rig]
    if wrong:
        option = {"labels": "--runs"}.get(wrong[0], f"--{wrong[0].replace('_', '-')}")
        beside = "not beside --rig" if rig else "only beside --rig"
        raise InputError(f"{option}: allowed {beside}")


def check_rig(asked: Asked, wanted: RigCheck) -> None:
    """Draw semi-real cases of a rig, diagnose them, and say which first causes are right."""
    from locosweep.diagnosis.data.inputs import nominal_model
    from locosweep.errors import InputError
    from locosweep.validation.semi_check import baselines, judge_semi_real
    from locosweep.validation.semi_files import draw_semi_real
    from locosweep.validation.semi_tables import as_json, as_text

    if wanted.nominal is None:
        raise InputError("--nominal is missing: --rig needs the model of the rig")
    nominal_model(wanted.nominal)
    sizes = [options.number("--sizes", text) for text in wanted.sizes.split(",") if text]
    if not sizes or not all(1.0 < size < math.inf for size in sizes):
        raise InputError(f"--sizes is {wanted.sizes}: allowed are numbers above 1")
    labels = [label for label in wanted.labels.split(",") if label]
    asked.make_folder(only="rig", runs=sorted(labels), sizes=sizes)
    nominal = _nominal(asked, wanted, wanted.nominal, labels)
    names, skipped = draw_semi_real(
        wanted.runs, nominal, asked.out, chosen=labels, sizes=sizes, seed=asked.seed,
        processes=asked.processes, progress=asked.meter("drawing"), shard=asked.shard,
    )  # fmt: skip
    outcomes = asked.diagnosed(names, skipped=skipped)
    if outcomes is None:
        return
    plainly = baselines(
        asked.out, names, processes=asked.processes, progress=asked.meter("baseline"),
        shard=asked.shard,
    )  # fmt: skip
    judged = judge_semi_real(asked.out, outcomes, plainly)
    asked.write(as_json(judged, skipped, asked.about), as_text(judged, skipped))


def _nominal(asked: Asked, wanted: RigCheck, given: Path, labels: list[str]) -> Path:
    """Return the file of the calibrated model; with --calibrate it is fitted and written.

    One that is there for the same runs and model is kept: other values would make other cases.
    """
    from locosweep.errors import InputError
    from locosweep.files.robot import load_robot
    from locosweep.files.runs import load_runs
    from locosweep.kept_work.records import digest, keep, kept
    from locosweep.validation.calibration import calibrate
    from locosweep.validation.semi_files import rig_of

    there = [run.label for run in load_runs(wanted.runs)[0]]
    for label in labels:
        if label not in there:
            raise InputError(f"--runs: no run {label}: there are {', '.join(there)}")
    robot = load_robot(given)
    path, record = asked.out / "calibrated.toml", asked.out / "calibrated.json"
    key = [digest(wanted.runs), digest(given), *labels, str(wanted.calibrate)]
    if (known := kept(record, key)) is not None:
        found: dict[str, float] = known["values"]
    else:
        found = {}
        if wanted.calibrate:
            robot, found = calibrate(rig_of(wanted.runs, given, labels).runs, robot)
        _written(robot, path)
        keep(record, key, [path], values=found)
    if found and not asked.quiet:
        text = ", ".join(f"{name} {value:.4g}" for name, value in found.items())
        click.echo(f"calibrated: {text}", err=True)
    return path


def _written(robot: Robot, path: Path) -> None:
    """Write a model without its uncertainties: what was calibrated is taken as exact."""
    from dataclasses import replace

    from locosweep.diagnosis.report.model_file import write_augmented

    exact = {k: v for k, v in robot.other.items() if not k.startswith("uncertainty.")}
    write_augmented(replace(robot, other=exact), path)
