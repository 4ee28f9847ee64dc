"""Pages of the documentation that come from the registry: effects, quantities, parameters."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import locosweep as ls
from common.table import rows
from locosweep import _core

# Fields that a section shows in a form of its own, or that only programs need.
_OF_EFFECT = {
    "name", "site", "meaning", "formula", "parameters", "first", "fits", "magnitude", "least",
    "shapes", "keep", "lowers_level", "drawn", "one_sided", "over", "spanned", "refined",
}  # fmt: skip
_OF_PARAMETER = {
    "name", "symbol", "unit", "meaning", "range", "allowed", "integer", "default", "file_key",
}  # fmt: skip


def effects() -> str:
    """Return every effect with its formula, its parameters and all else that its record says."""
    known = _core.effects()
    overview = [[f"[`{e.name}`](#{e.name})", e.site, e.meaning] for e in known]
    parts = [rows([["effect", "site", "meaning"], *overview])]
    for effect in known:
        said = [f"- {_words(key)}: {value}" for key, value in _others(effect, _OF_EFFECT)]
        parts += [
            f"## {effect.name}\n\n{_sentence(effect.meaning)} (site: {effect.site}).\n",
            f"```math\n{effect.formula}\n```\n",
            _parameters(effect.parameters),
        ]
        parts += ["\n".join(said) + "\n"] if said else []
    return "\n".join(parts)


def quantities() -> str:
    """Return every quantity with its formula, source and limits."""
    known = ls.quantities()
    parts = []
    for title, simulated in (("Closed forms", False), ("Simulated", True)):
        group = [q for q in known if q.simulated is simulated]
        parts.append(f"## {title}\n")
        overview = [[f"[`{q.name}`](#{q.name})", _unit(q.unit), q.meaning] for q in group]
        parts.append(rows([["quantity", "unit", "meaning"], *overview]))
        for q in group:
            names = ", ".join(f"`{p.name}`" for p in q.parameters)
            parts.append(
                f"### {q.name}\n\n{_sentence(q.meaning)}.\n\n"
                f"```math\n{q.formula}\n```\n\n"
                f"- Parameters: {names}\n- Source: {q.source}\n- Limits: {q.limits}\n"
            )
    return "\n".join(parts)


def parameters() -> str:
    """Return every parameter, and the names that a parameter may stand for."""
    lines = [["parameter", "symbol", "unit", "default", "allowed", "meaning"]]
    for p in ls.parameters():
        default = "-" if p.default is None else f"{p.default:g}"
        low, high = p.range
        allowed = f"{low:g} to {high:g}{', whole' if p.integer else ''}"
        lines.append([f"`{p.name}`", f"$`{p.symbol}`$", _unit(p.unit), default, allowed, p.meaning])
    drives = [["drive", "parameters", "meaning"]]
    for d in ls.drives():
        drives.append([f"`{d.name}`", ", ".join(f"`{p.name}`" for p in d.parameters), d.meaning])
    gaits = [["gait", "meaning"], *([f"`{g.name}`", g.meaning] for g in ls.gaits())]
    parts = [rows(lines), f"## Drives\n\n{rows(drives)}", f"## Gaits\n\n{rows(gaits)}"]
    for title, known in (("Methods", ls.methods()), ("Reductions", ls.reductions())):
        head = [title.lower().removesuffix("s"), "meaning"]
        named = [[f"`{name}`", meaning] for name, meaning in known.items()]
        parts.append(f"## {title}\n\n{rows([head, *named])}")
    statuses = [["status", "name", "meaning"]]
    statuses += [[str(int(s)), f"`{s.name.lower()}`", s.sentence] for s in ls.Status]
    said = "In Python, names are in capitals: `ls.Status.DIVERGED`."
    parts.append(f"## Statuses\n\n{said}\n\n{rows(statuses)}")
    return "\n".join([*parts, f"## Robot files\n\n{_robot_files()}"])


def _robot_files() -> str:
    """Return the keys of a robot file by their table."""
    known = [p for p in (*_core.parameters(), *_core.file_keys()) if p.file_key]
    found = [(*p.file_key, _unit(p.unit), p.meaning) for p in known]
    choices = _core.file_choices()
    found += [(table, key, "-", " or ".join(map(repr, names))) for table, key, names in choices]
    lines = [[f"`[{table}]`", f"`{key}`", *rest] for table, key, *rest in found]
    lines = [["table", "key", "unit", "meaning"], *sorted(lines, key=lambda line: line[0])]
    return (
        "TOML, in SI units; `locosweep init` writes one with comments. A model that a diagnosis "
        "found has tables `[effects.NAME]`, too, with the parameters of the [effect](effects.md)."
        "\n\n"
    ) + rows(lines)


def _parameters(records: Iterable[Any]) -> str:
    known = list(records)
    # What later records add, such as the value at which an effect does nothing, gets a column.
    more = sorted({key for p in known for key, _ in _others(p, _OF_PARAMETER)})
    lines = [["parameter", "symbol", "unit", "allowed", *map(_words, more), "meaning"]]
    for p in known:
        low, high = p.range
        extra = [_said(getattr(p, key, "")) for key in more]
        allowed = f"{low:g} to {high:g}"
        lines.append([f"`{p.name}`", f"$`{p.symbol}`$", _unit(p.unit), allowed, *extra, p.meaning])
    return rows(lines)


def _others(record: Any, shown: set[str]) -> list[tuple[str, str]]:
    """Return the other public fields that hold something, as text."""
    keys = [key for key in dir(record) if not key.startswith("_") and key not in shown]
    found = [(key, getattr(record, key)) for key in keys]
    nothing = (None, "", [], (), False)
    return [(k, _said(v)) for k, v in found if not callable(v) and v not in nothing]


def _said(value: Any) -> str:
    if value is True:
        return "yes"
    if isinstance(value, str | int | float):
        return f"{value:g}" if isinstance(value, float) else str(value)
    return ", ".join(map(_said, value)) if isinstance(value, list | tuple) else str(value)


_WORDS = {
    "contains": "contains as a limit",
    "continuous": "never jumps, whatever its functional form",
    "error_of": "error of the value",
    "excludes": "stands in the place of",
    "further": "further variable of another functional form",
    "monotone": "rises or falls all along, whatever its functional form",
    "shown": "motion of the head that shows it",
    "steady": "stays near its mean, whatever its functional form",
    "variable": "variable of another functional form",
}


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}"


def _words(key: str) -> str:
    return _WORDS.get(key, key).replace("_", " ")


def _unit(unit: str) -> str:
    return "-" if unit == "1" else unit
