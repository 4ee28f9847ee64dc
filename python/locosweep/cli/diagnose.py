"""``locosweep diagnose``: from measured runs and a nominal model to a report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from locosweep.cli import options
from locosweep.cli.options import called, meter, note, show
from locosweep.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.diagnosis.report.result import Diagnosis


@click.command()
@options.runs_argument
@options.nominal_option
@options.out_option("Folder for the report")
@click.option(
    "--holdout", multiple=True, metavar="RUN,...",
    help="Runs kept from the fit, for the check; default: chosen by the program.",
)  # fmt: skip
@click.option(
    "labels", "--runs", multiple=True, metavar="RUN,...",
    help="Runs that take part, by label; default all.",
)  # fmt: skip
@options.count_option("--max-effects", 3, "Most effects that act at once.", least=1)
@options.count_option("--seed", 0, "Start of the random numbers.")
@options.force_option
@click.option("--quiet", is_flag=True, help="Print the verdict only, and no steps.")
@click.option(
    "form", "--format", type=click.Choice(["text", "md"]), default="text", show_default=True,
    help="What is printed: a few lines, or the report in short as Markdown, for a pull request.",
)  # fmt: skip
@options.map_option
@options.unit_option
@options.csv_options
@options.threads_option
@options.progress_option
@options.json_option
@click.pass_context
def diagnose(
    ctx: click.Context,
    /,
    runs: tuple[Path, ...],
    nominal: Path,
    out: Path,
    holdout: tuple[str, ...],
    labels: tuple[str, ...],
    max_effects: int,
    seed: int,
    force: bool,
    quiet: bool,
    form: str,
    json_: bool,
    **reading: Any,
) -> None:
    """Say where measured RUNS leave their model, which effect causes it, how far it shrinks.

    RUNS are CSV or Parquet files with a row for each sample: run, t [s], drive,
    x [m], and where measured x_rear [m], force [N], v [m/s], power [W]. Several files, or
    those of a folder, are a run each where they have no column run; - is standard input.
    Or a ROS 2 bag (.mcap, .db3 or its folder), with --map drive=/cmd.effort[0] --map
    x=/joint_states.position[0].

    Writes report.html (for people), report.md (the same in short), report.json, augmented.toml
    (the model with the effects that were found, for locosweep simulate) and the pictures.
    """
    if form == "md" and json_:
        raise InputError("--json is given beside --format md: allowed is one of them")
    from locosweep.files.folder import check_folder

    check_folder(out, force=force)
    from locosweep.diagnosis.pipeline import diagnose as diagnose_runs
    from locosweep.diagnosis.report.sentences import advice

    bar = meter("locosweep: diagnose", "steps", quiet=quiet, log=True)
    found = diagnose_runs(
        options.one_or_all(runs),
        nominal,
        holdout=_split(holdout),
        labels=_split(labels),
        max_effects=max_effects,
        seed=seed,
        **reading,
        progress=bar,
    )
    if bar is not None:
        bar.say("writing the report")
    found.save(out, force=force, command=called(ctx))
    if bar is not None:
        bar.close()
    if not quiet:
        for warning in found.warnings:
            note(warning)
    if form == "md":
        click.echo(found.to_markdown(), nl=False)
        return
    more = () if quiet else (advice(found.report) or None, out / "report.html")
    show(json_, {"verdict": found.report["verdict"], "out": out}, *_verdict(found), *more)


def _split(given: tuple[str, ...]) -> list[str] | None:
    """Return the labels of a repeated option with commas; None without any."""
    return [label.strip() for text in given for label in text.split(",") if label.strip()] or None


def _verdict(found: Diagnosis) -> tuple[str, str]:
    """Return the verdict in a line, and its summary."""
    effects = " + ".join(found.effects)
    head = f"{found.status}{': ' if effects else ''}{effects}"
    return f"{head} (probability {found.probability:.2f})", " ".join(found.summary.split())
