"""``locosweep init``: from a log as exported to runs in SI units and a first nominal file."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.options import number, show
from locosweep.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

_RUNS, _NOMINAL = "runs.csv", "nominal.toml"


@click.command()
@click.argument("logs", metavar="LOG...", nargs=-1, required=True, type=options.FILE)
@options.out_option(f"Folder for {_RUNS} and {_NOMINAL}")
@options.column_option
@options.unit_option
@options.csv_options
@options.pair_option(
    "settings",
    "--set",
    metavar="KEY=VALUE",
    text="A value of the nominal file in SI units, for instance mass=0.27 or mu_coulomb=0.3.",
)
@click.option(
    "--pause",
    metavar="SECONDS",
    type=click.FloatRange(min=0.0, min_open=True),
    help="Time without a sample that ends a run; default 1 s, or 100 samples if that is longer; "
    "a run that has a label only ends there if this is given.",
)
@options.force_option
@options.json_option
def init(
    logs: tuple[Path, ...],
    out: Path,
    columns: dict[str, str],
    units: dict[str, str],
    separator: str | None,
    decimal: str | None,
    settings: dict[str, str],
    pause: float | None,
    force: bool,
    json_: bool,
) -> None:
    """Read a LOG as it was exported, and write what a diagnosis takes.

    Columns, units, runs and noise are guessed from names, rows and times; each guess is
    printed with its reason, and --column, --unit and --pause come before it. Nothing is asked.

    Writes runs.csv (SI units, the names of locosweep diagnose) and nominal.toml, a commented
    template: values that only you know are "?" there until --set or an editor gives them.
    """  # fmt: skip
    from locosweep.files.atomic import write_frame, write_text
    from locosweep.files.csv_form import CsvForm
    from locosweep.files.folder import check_folder, filling
    from locosweep.intake.log import read_log
    from locosweep.intake.template import nominal_text

    check_folder(out, force=force)
    written = {(out / name).resolve() for name in (_RUNS, _NOMINAL)}
    for source in logs:
        if source.resolve() in written:
            raise InputError(f"{source} is in --out {out}: it would be overwritten")
    given = {name: number(f"--set {name}", text) for name, text in settings.items()}
    form = CsvForm(separator, decimal)
    log = read_log(options.one_or_all(logs), columns=columns, units=units, form=form, pause=pause)
    text, missing = nominal_text(log, given)
    with filling(out, (_RUNS, _NOMINAL), force=force) as folder:
        write_frame(folder / _RUNS, log.frame)
        write_text(folder / _NOMINAL, text)
    runs, nominal = out / _RUNS, out / _NOMINAL
    follow = ["locosweep", "diagnose", runs, "--nominal", nominal, "--out", out / "report"]
    fill = f"fill in {', '.join(missing)} in {nominal}, then: " if missing else "next: "
    report = {
        "files": [runs, nominal],
        "columns": log.columns,
        "units": log.units,
        "runs": log.runs,
        "rows": log.frame.height,
        "notes": log.notes,
        "missing": missing,
    }
    show(json_, report, *log.notes, runs, nominal, fill + shlex.join(map(str, follow)))
