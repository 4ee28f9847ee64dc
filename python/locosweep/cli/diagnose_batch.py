"""``locosweep diagnose --batch``: many rigs from a list."""

from __future__ import annotations

import csv
import io
import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from locosweep.cli.options import meter, show
from locosweep.errors import DataFileError, InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from locosweep.diagnosis.batch import Rig

    Options = Callable[[click.Context], dict[str, Any]]

_NEEDED, _FURTHER = ("runs", "nominal"), ("name", "options")
_NAME = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9._-]{0,99}")
_MOST_BYTES = 64 << 20
"""Of a list: half a million rigs, each with a line of 128 characters."""
_NOT_HERE = ("nominal", "out", "batch", "shard", "force", "quiet", "threads", "progress",
             "form", "json_")  # fmt: skip
"""Parameters of the command that hold for a batch as a whole, or that its list gives."""
_FAILED = 1
"""Exit code where a rig has no verdict."""


def diagnose_list(ctx: click.Context, file: Path, options_of: Options) -> None:
    """Diagnose the rigs of a list, and print a table of verdicts.

    `options_of` turns a context of the command into options of `locosweep.diagnose`.
    """
    from locosweep.diagnosis.batch import diagnose_batch

    given = ctx.params
    rigs = read_list(file, ctx, options_of)
    table = diagnose_batch(
        rigs, given["out"], processes=given["threads"], shard=given["shard"],
        force=given["force"], progress=meter("diagnose", "rigs", quiet=given["quiet"], log=True),
    )  # fmt: skip
    rows = table.to_dicts()
    failed = sum(bool(row["error"]) for row in rows)
    count = f"{len(rows) - failed} of {len(rows)} rigs have a verdict: {given['out']}/verdicts.csv"
    wide = max(len(row["name"]) for row in rows)
    lines = [f"{row['name']:<{wide}}  {_verdict(row)}" for row in rows]
    show(given["json_"], {"out": given["out"], "failed": failed, "rigs": rows}, *lines, count)
    if failed:
        ctx.exit(_FAILED)


def _verdict(row: dict[str, Any]) -> str:
    if row["error"]:
        return f"error: {row['error']}"
    effects = f": {row['effects']}" if row["effects"] else ""
    return f"{row['status']}{effects} (probability {row['probability']:.2f})"


def read_list(file: Path, ctx: click.Context, options_of: Options) -> list[Rig]:
    """Read a list of rigs: columns runs, nominal, and where given name and options.

    Paths are relative to the list. Options are those of the command, and hold over what
    it was given.
    """
    from locosweep.diagnosis.batch import Rig

    rigs: list[Rig] = []
    places: dict[str, int] = {}
    for number, row in _rows(file):
        where = f"{file}, row {number}"
        name = row.get("name") or _name_of(row["runs"])
        if not _NAME.fullmatch(name):
            raise DataFileError(
                f"{where}: name is {name!r}: allowed are up to 100 letters, digits, '_', '-' and "
                "'.', which does not come first"
            )
        # Some file systems do not tell capitals.
        if name.lower() in places:
            raise DataFileError(
                f"{where}: name {name} is that of row {places[name.lower()]}: give the list a "
                "column name with a name of its own for each"
            )
        places[name.lower()] = number
        runs, nominal = (file.parent / row[key] for key in _NEEDED)
        rigs.append(
            Rig(name, runs, nominal, _options(ctx, row.get("options") or "", where, options_of))
        )
    if not rigs:
        raise DataFileError(f"{file}: no rig: allowed is at least one row below the names")
    return rigs


def _name_of(runs: str) -> str:
    """Make a name of a path: rig1/runs.csv is rig1_runs."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", re.sub(r"\.[A-Za-z0-9]+$", "", runs))


def _rows(file: Path) -> list[tuple[int, dict[str, str]]]:
    """Return rows and their numbers in the file, the header's being 1; blank ones are left out."""
    try:
        with file.open("rb") as source:
            content = source.read(_MOST_BYTES + 1)
        if len(content) > _MOST_BYTES:
            raise DataFileError(f"{file}: more than {_MOST_BYTES >> 20} MiB: cut it into several")
        reader = csv.reader(io.StringIO(content.decode("utf-8-sig"), newline=""), strict=True)
        lines = [(reader.line_num, cells) for cells in reader]
    except OSError as error:
        raise DataFileError(f"{file}: {error.strerror or error}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise DataFileError(f"{file}: no CSV file in UTF-8: {error}") from None
    head = [cell.strip() for cell in lines[0][1]] if lines else []
    _check_head(file, head)
    found = []
    for number, cells in lines[1:]:
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) != len(head):
            raise DataFileError(
                f"{file}, row {number}: {len(cells)} cells: allowed are {len(head)}, as in row 1"
            )
        row = dict(zip(head, (cell.strip() for cell in cells), strict=True))
        for key in _NEEDED:
            if not row[key] or "\0" in row[key]:
                raise DataFileError(f"{file}, row {number}: {key} is {row[key]!r}: name a file")
        found.append((number, row))
    return found


def _check_head(file: Path, head: Sequence[str]) -> None:
    missing = [key for key in _NEEDED if key not in head]
    other = [key for key in head if key not in (*_NEEDED, *_FURTHER)]
    if missing or other or len(set(head)) < len(head):
        named = ", ".join(head) or "nothing"
        raise DataFileError(
            f"{file}: columns are {named}: needed are runs and nominal, allowed beside them name "
            "and options, once each"
        )


def _options(ctx: click.Context, text: str, where: str, options_of: Options) -> dict[str, Any]:
    """Return options of one rig: those of its row over those of the command."""
    command = ctx.command
    try:
        words = shlex.split(text)
        own = command.make_context(
            "diagnose", ["RUNS", "--nominal", "NOMINAL", "--out", "OUT", *words], parent=ctx.parent,
            obj=ctx.obj,
        )  # fmt: skip
    except ValueError as error:
        raise DataFileError(f"{where}: options: {error}") from None
    except click.ClickException as error:
        raise DataFileError(f"{where}: options: {error.format_message()}") from None
    except click.exceptions.Exit:
        raise DataFileError(f"{where}: options: no help is given here") from None
    words_out = [word.partition("=")[0] for word in words]
    for param in command.params:
        if param.name in _NOT_HERE and set(param.opts) & set(words_out):
            raise DataFileError(f"{where}: options: {param.opts[0]} is not allowed in a list")
    if own.params["runs"] != (Path("RUNS"),):
        raise DataFileError(f"{where}: options: {own.params['runs'][-1]} is no option")
    for name, value in ctx.params.items():
        if own.get_parameter_source(name) is click.core.ParameterSource.DEFAULT:
            own.params[name] = value
        elif isinstance(value, dict):
            own.params[name] = {**value, **own.params[name]}
    try:
        return options_of(own)
    except InputError as error:
        raise DataFileError(f"{where}: options: {error}") from None
