"""Commands that list what the registry holds."""

from __future__ import annotations

import shutil
import textwrap
from typing import TYPE_CHECKING, Any

import click

from locosweep import registry
from locosweep.cli.options import DRIVE, EFFECT, PARAMETER, QUANTITY, json_option, show

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


def names_of(records: Iterable[registry.Parameter]) -> str:
    """Return the names of parameters as one text."""
    return ", ".join(record.name for record in records)


def page(
    record: registry.Law | registry.Quantity | registry.Drive, entries: Mapping[str, str]
) -> str:
    """Return everything about one record: its name, entries and parameters."""
    lines = heading(record.name, record.meaning, entries)
    return "\n".join([*lines, "", parameter_table(record.parameters)])


def heading(name: str, meaning: str, entries: Mapping[str, str]) -> list[str]:
    """Return the lines that name a record, with its entries below."""
    width = min(shutil.get_terminal_size().columns, 100)
    lines = [f"{name}: {meaning}", ""]
    for head, text in entries.items():
        lines.append(textwrap.fill(f"{head:<10}{text}", width, subsequent_indent=" " * 10))
    return lines


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
    if name is None:
        some = registry.quantities()
        rows = [(q.name, q.unit, q.meaning) for q in some]
        show(json_, [as_record(q, _QUANTITY) for q in some],
             table(rows, ("quantity", "unit", "meaning")))  # fmt: skip
        return
    one = registry.quantity(name)
    entries = as_record(one, ("unit", "symbol", "formula", "source", "limits"))
    if one.simulated:
        entries["law"] = "simulated: a friction law and a drive add their parameters"
    show(json_, as_record(one, _QUANTITY), page(one, entries))


def parameter_table(records: Iterable[registry.Parameter]) -> str:
    """List parameters: unit, default, what is allowed, key in a robot file, meaning."""
    rows = [
        (
            p.name,
            p.unit,
            "" if p.default is None else f"{p.default:g}",
            p.allowed,
            ".".join(p.file_key) if p.file_key else "",
            p.meaning,
        )
        for p in records
    ]
    return table(rows, ("parameter", "unit", "default", "allowed", "in a robot file", "meaning"))


@click.command()
@click.argument("name", required=False, type=PARAMETER)
@json_option
def parameters(name: str | None, json_: bool) -> None:
    """List the parameters: unit, default, what is allowed, key in a robot file."""
    some = registry.parameters() if name is None else [registry.parameter(name)]
    records = [as_record(record, _PARAMETER) for record in some]
    for record in records:
        record["file_key"] = ".".join(record["file_key"]) if record["file_key"] else None
    show(json_, records if name is None else records[0], parameter_table(some))


@click.command()
@json_option
def reductions(json_: bool) -> None:
    """List the ways to fold an axis away."""
    known = registry.reductions()
    show(json_, known, table(known.items(), ("reduction", "meaning")))


_DRIVE = ("name", "meaning", "formula", "parameters")


@click.command()
@click.argument("name", required=False, type=DRIVE)
@json_option
def drives(name: str | None, json_: bool) -> None:
    """List the drives of a simulation, or tell everything about one."""
    if name is None:
        some = registry.drives()
        rows = [(d.name, d.meaning, names_of(d.parameters)) for d in some]
        show(json_, [as_record(d, _DRIVE) for d in some],
             table(rows, ("drive", "meaning", "parameters")))  # fmt: skip
    else:
        one = registry.drive(name)
        show(json_, as_record(one, _DRIVE), page(one, {"formula": one.formula}))


_EFFECT = ("name", "site", "meaning", "formula", "shown", "needs")
_EFFECT_PARAMETER = ("name", "symbol", "unit", "meaning")


@click.command()
@click.argument("name", required=False, type=EFFECT)
@json_option
def effects(name: str | None, json_: bool) -> None:
    """List the effects that a diagnosis may name, or tell everything about one."""
    records = [
        as_record(one, _EFFECT)
        | {"parameters": [as_record(p, _EFFECT_PARAMETER) for p in one.parameters]}
        for one in registry.effects()
        if name in (None, one.name)
    ]
    if name is None:
        rows = [(one["name"], one["site"], one["meaning"]) for one in records]
        more = "\nlocosweep effects NAME shows formula, parameters and what must be measured."
        show(json_, records, table(rows, ("effect", "site", "meaning")), more)
        return
    one = records[0]
    own = table([(p["name"], p["unit"], p["meaning"]) for p in one["parameters"]],
                ("parameter", "unit", "meaning"))  # fmt: skip
    seen = {"site": one["site"], "formula": one["formula"]}
    if one["needs"]:
        seen["needs"] = ", ".join(one["needs"])
    show(json_, one, *heading(one["name"], one["meaning"], seen), "", own)


@click.command()
@json_option
def gaits(json_: bool) -> None:
    """List the gaits that a whole robot can be simulated with."""
    known = registry.gaits()
    rows = [(gait.name, gait.meaning) for gait in known]
    more = "\nlocosweep gait FILE.toml simulates one; examples/gait_*.toml are files of all."
    show(json_, [as_record(gait, ("name", "meaning")) for gait in known],
         table(rows, ("gait", "meaning")), more)  # fmt: skip


@click.command()
@json_option
def methods(json_: bool) -> None:
    """List the methods of simulation."""
    known = registry.methods()
    show(json_, known, table(known.items(), ("method", "meaning")))


@click.command()
@json_option
def reasons(json_: bool) -> None:
    """List the reasons for which a point has no value."""
    rows = [(str(int(s)), s.name.lower(), s.sentence) for s in registry.Status]
    records = [{"code": int(code), "name": name, "sentence": text} for code, name, text in rows]
    show(json_, records, table(rows, ("code", "status", "meaning"), "r"))
