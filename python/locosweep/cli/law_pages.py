"""Friction laws as text: a page on the terminal, records for machines, Markdown."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

from locosweep import registry

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

_KINDS = {
    "dry": "Sticks truly: at rest friction takes any value up to a limit. The picture shows "
    "those values as a bar at rest.",
    "smooth": "The jump at rest is replaced by a steep rise: never holds, creeps under any load.",
    "bristle": "The contact has an inner deflection: it gives a little before it slides, with "
    "hysteresis.",
}
"""Behaviour at rest, by kind of law."""

_HEAD = """# Friction laws

Written by `locosweep laws --out DIR` from the registry of the core; do not edit.

`locosweep laws` lists them, `locosweep laws NAME` tells everything about one, and
`--out DIR` draws this overview and a picture of each law. In Python: `locosweep.laws()`.

![Friction over Coulomb level against speed, all laws in one frame](laws.png)

$`F`$ is the force of friction against a motion with the speed $`v`$, $`F_C`$ the Coulomb
level, $`F_S`$ the static one, $`F_N`$ the normal force and $`F_P`$ the force of the drive:
$`F_C = \\mu_C F_N`$, $`F_S = \\mu_S F_N`$.
"""


def markdown(laws: Sequence[registry.Law]) -> str:
    """Return docs/laws.md: every law with formula, parameters, source and limits."""
    parts = [_HEAD]
    for kind, some in groupby(laws, lambda law: law.kind):
        group = list(some)
        parts.append(f"## {kind.capitalize()} laws\n\n{_KINDS[kind]}\n")
        parts.append(_rows(("law", "meaning", "source"), (_overview(law) for law in group)))
        parts += [_section(law) for law in group]
    used = {p.name: p for law in laws for p in law.parameters}
    heads = ("parameter", "symbol", "unit", "default", "allowed", "meaning")
    parts.append("## Parameters\n\nThose without a default must be given.\n")
    parts.append(_rows(heads, map(_parameter, used.values())))
    return "\n".join(parts)


def _overview(law: registry.Law) -> tuple[str, ...]:
    return f"[`{law.name}`](#{law.name})", law.meaning, law.source


def _parameter(record: registry.Parameter) -> tuple[str, ...]:
    unit = "-" if record.unit == "1" else record.unit
    default = "" if record.default is None else f"{record.default:g}"
    low, high = record.range
    allowed = f"{low:g} to {high:g}" + (", whole" if record.integer else "")
    return f"`{record.name}`", f"$`{record.symbol}`$", unit, default, allowed, record.meaning


def _section(law: registry.Law) -> str:
    names = ", ".join(f"`{p.name}`" for p in law.parameters)
    exact = "Motion under a stepwise drive is known in closed form.\n\n" if law.exact else ""
    return (
        f"### {law.name}\n\n{law.meaning[0].upper()}{law.meaning[1:]}.\n\n"
        f"```math\n{law.formula}\n```\n\n{exact}"
        f"- Parameters: {names}\n- Source: {law.source}\n- Limits: {law.limits}\n"
    )


def _rows(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [_line(heads), _line(["---"] * len(heads))]
    lines += [_line([_bars(cell) for cell in row]) for row in rows]
    return "\n".join(lines) + "\n"


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _bars(text: str) -> str:
    # A bar ends the cell of a table, in a formula too.
    return text.replace("|", r"\vert ")
