"""``locosweep blind-check --rig``: the blind check on a measured rig."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.options import meter, show

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

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
    seed: int
    out: Path
    draw_only: bool
    force: bool
    quiet: bool
    threads: int | None
    json_: bool


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


def check_rig(asked: RigCheck, command: str) -> None:
    """Draw semi-real cases of a rig, diagnose them, and say which first causes are right."""
    from locosweep import _core
    from locosweep.errors import InputError
    from locosweep.files.atomic import write_text
    from locosweep.files.folder import check_folder
    from locosweep.files.strict_json import as_json as as_text_json
    from locosweep.validation.case_files import SEAL, digest
    from locosweep.validation.check import diagnose_cases
    from locosweep.validation.semi_check import baselines, judge_semi_real
    from locosweep.validation.semi_files import draw_semi_real
    from locosweep.validation.semi_tables import as_json, as_text

    if asked.nominal is None:
        raise InputError("--nominal is missing: --rig needs the model of the rig")
    sizes = [options.number("--sizes", text) for text in asked.sizes.split(",") if text]
    if not sizes or min(sizes) <= 1.0:
        raise InputError(f"--sizes is {asked.sizes}: allowed are numbers above 1")
    labels = [label for label in asked.labels.split(",") if label]
    check_folder(asked.out, force=asked.force)
    asked.out.mkdir(parents=True, exist_ok=True)
    nominal = _nominal(asked, asked.nominal, labels)
    processes = _core.threads_to_use(asked.threads)
    names, skipped = draw_semi_real(
        asked.runs, nominal, asked.out, chosen=labels, sizes=sizes, seed=asked.seed,
        processes=processes, progress=meter("drawing", "cases", quiet=asked.quiet),
    )  # fmt: skip
    sealed = digest(asked.out / SEAL)
    if not asked.quiet:
        click.echo(f"truths sealed: {asked.out / SEAL}, sha256 {sealed}", err=True)
    if asked.draw_only:
        record = {"cases": len(names), "skipped": skipped, "sealed": sealed}
        show(asked.json_, record, asked.out)
        return
    outcomes = diagnose_cases(
        asked.out, names, seed=asked.seed, processes=processes,
        progress=meter("diagnosing", "cases", quiet=asked.quiet),
    )  # fmt: skip
    plainly = baselines(
        asked.out, names, processes=processes,
        progress=meter("baseline", "cases", quiet=asked.quiet),
    )  # fmt: skip
    judged = judge_semi_real(asked.out, outcomes, plainly)
    about = {
        "command": command,
        "locosweep": _core.version(),
        "seed": asked.seed,
        "sealed_sha256": sealed,
    }
    found, text = as_json(judged, skipped, about), as_text(judged, skipped)
    write_text(asked.out / "metrics.json", as_text_json(found) + "\n")
    write_text(asked.out / "table.txt", text)
    show(asked.json_, found, text)


def _nominal(asked: RigCheck, given: Path, labels: list[str]) -> Path:
    """Return the file of the calibrated model; with --calibrate it is fitted and written.

    One that is there for the same runs and model is kept: other values would make other cases.
    """
    import json

    from locosweep.errors import InputError
    from locosweep.files.atomic import write_text
    from locosweep.files.robot import load_robot
    from locosweep.files.runs import load_runs
    from locosweep.validation.calibration import calibrate
    from locosweep.validation.case_files import digest
    from locosweep.validation.semi_files import rig_of

    known = [run.label for run in load_runs(asked.runs)[0]]
    for label in labels:
        if label not in known:
            raise InputError(f"--runs: no run {label}: there are {', '.join(known)}")
    robot = load_robot(given)
    path, record = asked.out / "calibrated.toml", asked.out / "calibrated.json"
    key = [digest(asked.runs), digest(given), *labels, str(asked.calibrate)]
    if path.exists() and record.exists() and json.loads(record.read_text())["key"] == key:
        found: dict[str, float] = json.loads(record.read_text())["values"]
    else:
        found = {}
        if asked.calibrate:
            robot, found = calibrate(rig_of(asked.runs, given, labels).runs, robot)
        _written(robot, path)
        write_text(record, json.dumps({"key": key, "values": found}, indent=1) + "\n")
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
