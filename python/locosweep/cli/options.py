"""Kinds of arguments and the options that several commands share."""

from __future__ import annotations

import contextlib
import re
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem

from locosweep import registry
from locosweep.errors import InputError, printable
from locosweep.files.csv_form import DECIMALS, SEPARATORS
from locosweep.files.strict_json import as_json

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from matplotlib.figure import Figure

    from locosweep.progress import JsonLines, Meter
    from locosweep.result import Result
    from locosweep.specs.span import Span

    Axis = tuple[str, Span | tuple[float, ...]]

_Command = TypeVar("_Command", bound="Callable[..., Any]")


class _Name(click.ParamType[str]):
    """A name from the registry."""

    def __init__(self, name: str, known: Callable[[], Mapping[str, str]]) -> None:
        self.name = name
        self.known = known

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Refuse unknown names, with the nearest one."""
        known = self.known()
        if value not in known:
            self.fail(str(registry.unknown(self.name, value, known)), param, ctx)
        return str(value)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Complete from the registry."""
        del ctx, param
        names = self.known().items()
        return [
            CompletionItem(name, help=text) for name, text in names if name.startswith(incomplete)
        ]


class _Setting(click.ParamType[tuple[str, float]]):
    """A parameter with one value."""

    name = "NAME=VALUE"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, float]:
        """Split and check."""
        if isinstance(value, tuple):
            return value
        name, sign, text = value.partition("=")
        if not sign:
            self.fail(f"'{value}': allowed is NAME=VALUE", param, ctx)
        try:
            return name, registry.parameter(name).check(number(name, text))
        except InputError as error:
            self.fail(str(error), param, ctx)


class _Axis(click.ParamType["Axis"]):
    """A parameter with a range or list of values."""

    name = "NAME=VALUES"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Axis:
        """Split and check."""
        if isinstance(value, tuple):
            return value
        try:
            return _axis(value)
        except InputError as error:
            self.fail(str(error), param, ctx)


def number(name: str, text: str) -> float:
    """Read a number; InputError says the name of what it is for."""
    # Python also reads 1_000 and non-Latin digits; those are typing errors here.
    if text.isascii() and "_" not in text:
        with contextlib.suppress(ValueError):
            return float(text)
    raise InputError(f"{name} is '{text}': allowed is a number")


def _axis(text: str) -> Axis:
    from locosweep.specs.span import Span

    name, sign, values = text.partition("=")
    forms = "allowed are NAME=LO:HI:COUNT, NAME=A,B,C and, for whole numbers, NAME=LO:HI"
    if not sign or not values:
        raise InputError(f"'{text}': {forms}")
    record = registry.parameter(name)
    if ":" not in values:
        return name, tuple(record.check(number(name, part)) for part in values.split(","))
    parts = values.split(":")
    if len(parts) > 3:
        raise InputError(f"'{text}': {forms}")
    count = None
    if len(parts) == 3:
        # Eighteen digits: more are refused before they cost time.
        if not (parts[2].isascii() and parts[2].isdigit() and len(parts[2]) <= 18):
            raise InputError(
                f"'{text}': the count is '{parts[2]}', allowed is a whole number from 1 upward"
            )
        count = int(parts[2])
    elif not record.integer:
        raise InputError(f"'{text}': {name} is no whole number, give a count: {name}=LO:HI:COUNT")
    span = Span(number(name, parts[0]), number(name, parts[1]), count)
    span.check(name)
    return name, span


class _Output(click.ParamType[Path]):
    """A file to write, checked before anything is computed."""

    def __init__(self, *kinds: str) -> None:
        self.kinds = kinds
        self.name = "FILE." + "|".join(kinds)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Refuse other endings and folders that do not exist."""
        from locosweep.files.atomic import check_file_name

        path = Path(value)
        if path.suffix[1:].lower() not in self.kinds:
            allowed = ", ".join(f".{kind}" for kind in self.kinds)
            ends = f"ends in '{path.suffix}'" if path.suffix else "has no ending"
            self.fail(f"'{value}' {ends}: allowed are {allowed}", param, ctx)
        try:
            check_file_name(path)
        except InputError as error:
            self.fail(str(error), param, ctx)
        return path


QUANTITY = _Name("quantity", lambda: {q.name: q.meaning for q in registry.quantities()})
PARAMETER = _Name("parameter", lambda: {p.name: p.meaning for p in registry.parameters()})
REDUCTION = _Name("reduction", registry.reductions)
LAW = _Name("friction law", lambda: {law.name: law.meaning for law in registry.laws()})
DRIVE = _Name("drive", lambda: {drive.name: drive.meaning for drive in registry.drives()})
METHOD = _Name("method", registry.methods)
EFFECT = _Name("effect", lambda: {one.name: one.meaning for one in registry.effects()})
SETTING = _Setting()
AXIS = _Axis()
PICTURE = _Output("png", "svg", "pdf")
TABLE = _Output("parquet")
CURVES = _Output("csv", "parquet")
PAGE = _Output("html")


class SweepCommand(click.Command):
    """A command whose help ends with the commands that list what its options take."""

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Name the lists of quantities, parameters, reductions, laws, drives and methods."""
        super().format_epilog(ctx, formatter)
        kinds = {param.type for param in self.params}
        settings = bool(kinds & {AXIS, SETTING})
        rows = [
            (f"locosweep {command}", text)
            for wanted, command, text in (
                (
                    any(kind.name == QUANTITY.name for kind in kinds),
                    "quantities",
                    "what can be swept; with a NAME its formula",
                ),
                (settings or PARAMETER in kinds, "parameters", "names, units, defaults, ranges"),
                (LAW in kinds, "laws", ", ".join(law.name for law in registry.laws())),
                (DRIVE in kinds, "drives", ", ".join(drive.name for drive in registry.drives())),
                (METHOD in kinds, "methods", ", ".join(registry.methods())),
                (REDUCTION in kinds, "reductions", ", ".join(registry.reductions())),
            )
            if wanted
        ]
        if rows:
            with formatter.section("Names"):
                formatter.write_dl(rows)


FILE: click.ParamType[Path] = click.Path(path_type=Path)
FOLDER: click.ParamType[Path] = click.Path(file_okay=False, path_type=Path)

runs_argument = click.argument("runs", metavar="RUNS...", nargs=-1, required=True, type=FILE)


def one_or_all(paths: tuple[Path, ...]) -> Path | list[Path]:
    """Return the one path that was given, or all of them."""
    return paths[0] if len(paths) == 1 else list(paths)


robot_option = click.option(
    "--robot", metavar="FILE.toml", type=FILE,
    help="Robot file; its parameters hold where no other option gives them.",
)  # fmt: skip
set_option = click.option(
    "settings", "--set", multiple=True, type=SETTING, help="Fix a parameter; repeat as needed."
)


def _pairs(_: click.Context, param: click.Parameter, given: tuple[str, ...]) -> dict[str, str]:
    """Read a repeated option NAME=TEXT into a mapping."""
    option = param.opts[0]
    found: dict[str, str] = {}
    for text in given:
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise InputError(f"{option} {text!r}: allowed is NAME={option[2:].upper()}")
        if name in found:
            raise InputError(f"{option} gives {name} twice: allowed is once")
        found[name] = value
    return found


def pair_option(*names: str, metavar: str, text: str) -> Callable[[_Command], _Command]:
    """Return an option NAME=TEXT to repeat, which the command gets as a mapping."""
    return click.option(*names, multiple=True, callback=_pairs, metavar=metavar, help=text)


column_option = pair_option(
    "columns", "--column", metavar="NAME=THEIRS",
    text="Their name of a column of the data, for instance drive=tau.",
)  # fmt: skip
map_option = pair_option(
    "columns", "--column", "--map", metavar="NAME=THEIRS",
    text="Their name of a column of the data, for instance drive=tau; of a bag, /topic.field.",
)  # fmt: skip
unit_option = pair_option(
    "units", "--unit", metavar="NAME=UNIT",
    text="Unit of a column of the data, for instance x=mm.",
)  # fmt: skip


def csv_options(command: _Command) -> _Command:
    """Add the options that settle what the text of a CSV file leaves open."""
    decimal = click.option(
        "--decimal", type=click.Choice(list(DECIMALS)),
        help="Decimal character of a CSV file; default as its numbers show.",
    )  # fmt: skip
    separator = click.option(
        "--separator", type=click.Choice(list(SEPARATORS)),
        help="Character between columns of a CSV file; default as its rows show.",
    )  # fmt: skip
    return separator(decimal(command))


def nominal_option(*, required: bool = True) -> Callable[[Any], Any]:
    """Return the option that names the nominal model."""
    return click.option(
        "--nominal", required=required, metavar="NOMINAL.toml", type=FILE,
        help="The model that the runs are held against.",
    )  # fmt: skip


force_option = click.option("--force", is_flag=True, help="Write into a folder that is not empty.")
threads_option = click.option(
    "--threads", metavar="N", type=click.IntRange(min=1), help="Threads; default all processors."
)
_PROGRESS = "locosweep.progress"
"""What `--progress` says, in the context of the command."""


def _take_progress(ctx: click.Context, _: click.Parameter, given: str) -> None:
    # Commands that others are made of have a context of their own and share this.
    if ctx.get_parameter_source("progress") is not click.core.ParameterSource.DEFAULT:
        ctx.meta[_PROGRESS] = given


progress_option = click.option(
    "--progress", type=click.Choice(["auto", "json", "none"]), default="auto", show_default=True,
    expose_value=False, callback=_take_progress,
    help="Progress on standard error: as people see it, as lines of JSON, or none.",
)  # fmt: skip
json_option = click.option("--json", "json_", is_flag=True, help="Print JSON.")


def out_option(text: str) -> Callable[[_Command], _Command]:
    """Return the option ``--out`` of a command that fills a folder."""
    return click.option(
        "--out", required=True, metavar="FOLDER", type=FOLDER, help=f"{text}; made if missing."
    )


def count_option(
    name: str, default: int, text: str, *, least: int = 0, most: int | None = None
) -> Callable[[_Command], _Command]:
    """Return an option for a whole number that has a default."""
    return click.option(
        name, default=default, show_default=True, metavar="N", type=click.IntRange(least, most),
        help=text,
    )  # fmt: skip


def values_of(settings: Iterable[Axis]) -> dict[str, list[float]]:
    """Return the values of each ``--set NAME=VALUES``."""
    found: dict[str, list[float]] = {}
    for name, given in settings:
        if name in found:
            raise InputError(f"--set gives {name} twice: allowed is once, NAME=A,B,C for several")
        found[name] = list(given) if isinstance(given, tuple) else given.values(name).tolist()
    return found


def save_picture(ctx: click.Context, figure: Figure, out: Path, result: Result) -> None:
    """Write a picture with the command and the sweep that made it in its metadata."""
    from locosweep.plot.save import save_figure
    from locosweep.provenance import spec_hash

    save_figure(figure, out, command=called(ctx), spec=spec_hash(result))


def show(json_: bool, record: object, *lines: object) -> None:
    """Print a record as JSON, or the lines that are not None."""
    if json_:
        # JSON escapes control characters, but not those that only some terminals obey.
        text = re.sub("[\x7f-\x9f]", lambda found: f"\\u{ord(found[0]):04x}", as_json(record))
    else:
        given = "\n".join(str(line) for line in lines if line is not None)
        text = "\n".join(printable(line) for line in given.split("\n"))
    click.echo(text)


def note(text: str) -> None:
    """Say on standard error, in one line, what a user should know."""
    click.echo(f"locosweep: note: {printable(' '.join(text.split()))}", err=True)


def called(ctx: click.Context) -> str:
    """Return the command as it was typed, for the metadata of pictures."""
    return shlex.join(["locosweep", *ctx.obj])


def fixed(
    robot: Path | None,
    settings: Iterable[tuple[str, float]],
    axes: Iterable[str],
    spec: Iterable[tuple[str, float]] = (),
) -> tuple[tuple[str, float], ...]:
    """Return the fixed values: the robot's, then the sweep file's, then ``--set``."""
    given: dict[str, float] = {}
    for name, value in settings:
        if name in given:
            raise InputError(f"--set gives {name} twice: allowed is one value")
        given[name] = value
    values: dict[str, float] = {}
    if robot is not None:
        from locosweep.files.robot import load_robot

        swept = set(axes)
        found = load_robot(robot)
        if found.effects:
            note(
                f"{robot}: effects are left out ({', '.join(found.effects)}): "
                "simulate --model FILE --runs RUNS takes them"
            )
        values = {name: value for name, value in found.parameters.items() if name not in swept}
    return tuple((values | dict(spec) | given).items())


def refuse_same(out: Path | None, **others: Path | None) -> None:
    """Refuse an output that is a file which the command reads or writes as well."""
    for option, path in others.items():
        if out is not None and path is not None and out.resolve() == path.resolve():
            name = option.replace("_", "-")
            raise InputError(f"--out and --{name} are both {out}: allowed are two files")


def meter(
    label: str, unit: str = "evaluations", *, quiet: bool = False, log: bool = False
) -> Meter | JsonLines | None:
    """Return a bar for a terminal, None where nobody looks at one; what `--progress` says counts.

    With `log`, lines stand in for it elsewhere: for commands that take minutes.
    """
    from locosweep.progress import JsonLines, Meter

    context = click.get_current_context(silent=True)
    wanted = "auto" if context is None else context.meta.get(_PROGRESS, "auto")
    if wanted == "json":
        return JsonLines(label, unit)
    shown = (log or sys.stderr.isatty()) and not quiet and wanted != "none"
    return Meter(label, unit) if shown else None


def summary(result: Result) -> dict[str, object]:
    """Describe a result for JSON."""
    import numpy as np

    outputs = []
    for output in result.outputs:
        values = result[output.name]
        works = np.isfinite(values)
        some = bool(works.any())
        outputs.append(
            {
                "name": output.name,
                "label": output.label,
                "unit": output.unit,
                "cells": values.size,
                "cells_with_value": int(np.count_nonzero(works)),
                "lowest": float(np.min(values, where=works, initial=np.inf)) if some else None,
                "highest": float(np.max(values, where=works, initial=-np.inf)) if some else None,
            }
        )
    axes = {
        name: {"count": len(axis), "first": float(axis[0]), "last": float(axis[-1])}
        for name, axis in result.axes.items()
    }
    return {"outputs": outputs, "axes": axes, "over": result.over, "fixed": dict(result.fixed)}
