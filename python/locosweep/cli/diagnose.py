"""``locosweep diagnose``: from measured runs and a nominal model to a report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from locosweep.cli import options
from locosweep.cli.diagnose_batch import diagnose_list
from locosweep.cli.options import called, meter, note, show
from locosweep.cli.run_options import SHARD
from locosweep.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.diagnosis.report.result import Diagnosis


@click.command()
@click.argument("runs", metavar="RUNS...", nargs=-1, type=options.FILE)
@options.nominal_option(required=False)
@click.option(
    "--batch", metavar="LIST.csv", type=options.FILE,
    help="Many rigs in place of RUNS and --nominal: a row each, with columns runs, nominal and, "
    "where needed, name and options. The same command goes on where it ended.",
)  # fmt: skip
@click.option(
    "--shard", type=SHARD,
    help="Of a batch, take every N-th rig first, from the I-th on, then what others have not done.",
)  # fmt: skip
@options.out_option("Folder for the report")
@click.option(
    "--holdout", multiple=True, metavar="RUN,...",
    help="Runs kept from the fit, for the check; default: chosen by the program.",
)  # fmt: skip
@click.option(
    "labels", "--runs", multiple=True, metavar="RUN,...",
    help="Runs that take part, by label; default all.",
)  # fmt: skip
@options.count_option("--max-effects", 2, "Most effects that act at once.", least=1, most=3)
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
    nominal: Path | None,
    batch: Path | None,
    shard: tuple[int, int] | None,
    out: Path,
    force: bool,
    quiet: bool,
    form: str,
    threads: int | None,
    json_: bool,
    **_: Any,
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
    if batch is not None:
        if runs or nominal is not None:
            raise InputError("--batch is given beside RUNS or --nominal: allowed is either")
        if form == "md":
            raise InputError("--format md is given beside --batch: each rig's folder has report.md")
        diagnose_list(ctx, batch, _options_of)
        return
    if shard is not None:
        raise InputError("--shard: allowed only with --batch")
    if not runs:
        raise click.UsageError("Missing argument 'RUNS...'.", ctx)
    if nominal is None:
        raise click.UsageError("Missing option '--nominal'.", ctx)
    from locosweep.files.folder import check_folder

    check_folder(out, force=force)
    from locosweep.diagnosis.pipeline import diagnose as diagnose_runs
    from locosweep.diagnosis.report.sentences import advice

    bar = meter("locosweep: diagnose", "steps", quiet=quiet, log=True)
    found = diagnose_runs(
        options.one_or_all(runs), nominal, **_options_of(ctx), threads=threads, progress=bar
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


def _options_of(ctx: click.Context) -> dict[str, Any]:
    """Return the options of `locosweep.diagnose` that a command was given."""
    same = ("max_effects", "seed", "columns", "units", "separator", "decimal")
    return {
        "holdout": _split("--holdout", ctx.params["holdout"]),
        "labels": _split("--runs", ctx.params["labels"]),
        **{name: ctx.params[name] for name in same},
    }


def _split(option: str, given: tuple[str, ...]) -> list[str] | None:
    """Return the labels of a repeated option with commas; None without any."""
    labels = [label.strip() for text in given for label in text.split(",")]
    if not all(labels):
        raise InputError(f"{option} is '{','.join(given)}': allowed is RUN or RUN,RUN,...")
    return labels or None


def _verdict(found: Diagnosis) -> tuple[str, str]:
    """Return the verdict in a line, and its summary."""
    effects = " + ".join(found.effects)
    head = f"{found.status}{': ' if effects else ''}{effects}"
    return f"{head} (probability {found.probability:.2f})", " ".join(found.summary.split())
