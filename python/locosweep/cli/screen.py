"""``locosweep screen``: which effects could explain a gap, before any replay."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from locosweep.cli import options
from locosweep.cli.options import note, show

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.diagnosis.screening import Screen

_LEAST_SHARE = 1e-3
"""Share of the equation error that an effect takes away, to get a line of its own."""


@click.command()
@options.runs_argument
@options.nominal_option()
@options.count_option("--pairs", 5, "Pairs of effects to list, at most.")
@options.column_option
@options.unit_option
@options.csv_options
@options.threads_option
@options.json_option
def screen(
    runs: tuple[Path, ...],
    nominal: Path,
    pairs: int,
    json_: bool,
    **reading: Any,
) -> None:
    """Say which effects could explain a gap between measured RUNS and their model.

    RUNS are files as for locosweep diagnose. Each effect is fitted to the equation
    error: forces of the model along the measured slides, without a replay. That
    takes a moment and is no verdict; what acts at rest is not seen.
    """
    from locosweep.diagnosis.screening import screen as screen_runs

    found = screen_runs(
        options.one_or_all(runs),
        nominal,
        pairs=pairs,
        **reading,
    )
    for warning in found.warnings:
        note(warning)
    show(json_, _record(found), *_lines(found))


def _record(found: Screen) -> dict[str, object]:
    return {
        "mean_square": found.mean_square,
        "slides": found.slides,
        "runs": found.runs,
        "of_runs": found.of_runs,
        "ranks": found.ranks,
        "effects": found.table.to_dicts(),
        "unseen": found.unseen,
    }


def _lines(found: Screen) -> list[str]:
    """Return the screen for people: singles, then pairs."""
    head = (
        f"equation error of the nominal model: {found.mean_square:.4g} times the noise "
        f"(mean squares), in {_count(found.slides, 'slide')} of {found.runs} of "
        f"{_count(found.of_runs, 'run')}"
    )
    if found.unseen:
        head += f"; it does not see {', '.join(found.unseen)}, which need locosweep diagnose"
    lines = [head]
    if not found.ranks:
        lines.append("that is little more than noise: the order of the effects says little")
    rows = found.table.to_dicts()
    for title, count in (("effect", 1), ("pair", 2)):
        own = [row for row in rows if len(row["effects"]) == count]
        if own:
            lines += ["", *_part(title, own)]
    lines += ["", "a screen, no verdict: only replays can name a cause (locosweep diagnose)"]
    return lines


def _part(title: str, rows: list[dict[str, Any]]) -> list[str]:
    useful = [row for row in rows if row["share"] >= _LEAST_SHARE]
    cells = [(" + ".join(row["effects"]), row) for row in useful]
    wide = max((len(name) for name, _ in cells), default=len(title))
    lines = [f"{title:<{wide}}  {'error left':>10}  {'taken away':>10}  parameters"]
    lines += [
        f"{name:<{wide}}  {row['mean_square']:>10.4g}  {row['share']:>10.1%}  {_values(row)}"
        for name, row in cells
    ]
    idle = [" + ".join(row["effects"]) for row in rows if row["share"] < _LEAST_SHARE]
    if idle:
        lines.append(f"nothing is taken away by {', '.join(idle)}")
    return lines


def _values(row: dict[str, Any]) -> str:
    """Return the parameters, those of one effect after those of the other."""
    parts = []
    for effect in row["effects"]:
        own = [value for value in row["parameters"] if value["effect"] == effect]
        texts = [f"{value['name']} = {value['value']:.4g} {_unit(value)}".rstrip() for value in own]
        parts.append(", ".join(texts))
    return "; ".join(parts)


def _unit(value: dict[str, Any]) -> str:
    return "" if value["unit"] == "1" else str(value["unit"])


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
