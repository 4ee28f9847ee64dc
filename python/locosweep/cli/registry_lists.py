"""Commands that list what the registry holds."""

from __future__ import annotations

import shutil
import textwrap
from typing import TYPE_CHECKING, Any

import click

from locosweep import registry
from locosweep.cli.options import DRIVE, PARAMETER, QUANTITY, json_option
from locosweep.files.strict_json import as_json

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence


def table(rows: Iterable[Sequence[str]], heads: Sequence[str], right: str = "") -> str:
    """Align columns; `right` has one letter per column, r for flush right."""
    cells = [list(heads), *map(list, rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(heads))]
    sides = [">" if side == "r" else "<" for side in right.ljust(len(heads))]
    lines = []
    for row in cells:
        texts = (f"{text:{s}{w}}" for text, s, w in zip(row, sides, widths, strict=True))
        lines.append("  ".join(texts).rstrip())
    return "\n".join(lines)


def as_record(record: object, names: Iterable[str]) -> dict[str, Any]:
    """Return some attributes of a record of the registry for JSON; parameters by name."""
    found = {name: getattr(record, name) for name in names}
    if "parameters" in found:
        found["parameters"] = [p.name for p in found["parameters"]]
    return found


def page(
    record: registry.Law | registry.Quantity | registry.Drive, entries: Mapping[str, str]
) -> str:
    """Return everything about one record: its name, entries and parameters."""
    width = min(shutil.get_terminal_size().columns, 100)
    lines = [f"{record.name}: {record.meaning}", ""]
    for head, text in entries.items():
        lines.append(textwrap.fill(f"{head:<10}{text}", width, subsequent_indent=" " * 10))
    return "\n".join([*lines, "", parameter_table(record.parameters)])


_QUANTITY = (
    *("name", "symbol", "unit", "meaning", "formula", "source", "limits", "integer"),
    *("simulated", "parameters"),
)
_PARAMETER = ("name", "symbol", "unit", "meaning", "default", "range", "integer", "file_key")


@click.command()
@click.argument("name", required=False, type=QUANTITY)
@json_option
def quantities(name: str | None, json_: bool) -> None:
    """List the quantities, or tell everything about one."""
    some = registry.quantities() if name is None else [registry.quantity(name)]
    if json_:
        records = [as_record(record, _QUANTITY) for record in some]
        click.echo(as_json(records if name is None else records[0]))
    elif name is None:
        rows = [(q.name, q.unit, q.meaning) for q in some]
        click.echo(table(rows, ("quantity", "unit", "meaning")))
    else:
        entries = as_record(some[0], ("unit", "symbol", "formula", "source", "limits"))
        if some[0].simulated:
            entries["law"] = "simulated: a friction law and a drive add their parameters"
        click.echo(page(some[0], entries))


def parameter_table(records: Iterable[registry.Parameter]) -> str:
    """List parameters: unit, default, what is allowed, meaning."""
    rows = [
        (p.name, p.unit, "" if p.default is None else f"{p.default:g}", p.allowed, p.meaning)
        for p in records
    ]
    return table(rows, ("parameter", "unit", "default", "allowed", "meaning"))


@click.command()
@click.argument("name", required=False, type=PARAMETER)
@json_option
def parameters(name: str | None, json_: bool) -> None:
    """List the parameters: unit, default, what is allowed, key in a robot file."""
    some = registry.parameters() if name is None else [registry.parameter(name)]
    if json_:
        records = [as_record(record, _PARAMETER) for record in some]
        for record in records:
            record["file_key"] = ".".join(record["file_key"]) if record["file_key"] else None
        click.echo(as_json(records if name is None else records[0]))
    else:
        click.echo(parameter_table(some))


@click.command()
@json_option
def reductions(json_: bool) -> None:
    """List the ways to fold an axis away."""
    known = registry.reductions()
    click.echo(as_json(known) if json_ else table(known.items(), ("reduction", "meaning")))


@click.command()
@click.argument("name", required=False, type=DRIVE)
@json_option
def drives(name: str | None, json_: bool) -> None:
    """List the drives of a simulation, or tell everything about one."""
    some = registry.drives() if name is None else [registry.drive(name)]
    if json_:
        records = [as_record(d, ("name", "meaning", "formula", "parameters")) for d in some]
        click.echo(as_json(records if name is None else records[0]))
    elif name is None:
        rows = [(d.name, d.meaning, ", ".join(p.name for p in d.parameters)) for d in some]
        click.echo(table(rows, ("drive", "meaning", "parameters")))
    else:
        click.echo(page(some[0], {"formula": some[0].formula}))


@click.command()
@json_option
def methods(json_: bool) -> None:
    """List the methods of simulation."""
    known = registry.methods()
    click.echo(as_json(known) if json_ else table(known.items(), ("method", "meaning")))


@click.command()
@json_option
def statuses(json_: bool) -> None:
    """List the reasons for which a point has no value."""
    if json_:
        records = [
            {"code": int(s), "name": s.name.lower(), "sentence": s.sentence}
            for s in registry.Status
        ]
        click.echo(as_json(records))
    else:
        rows = [(str(int(s)), s.name.lower(), s.sentence) for s in registry.Status]
        click.echo(table(rows, ("code", "status", "meaning"), "r"))
