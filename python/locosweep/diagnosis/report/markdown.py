"""The report in short, as Markdown: for a pull request, an issue or a message."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from locosweep.diagnosis.report.figures_style import unit_text, words
from locosweep.diagnosis.report.sentences import advice, family, found_law, shortfall
from locosweep.diagnosis.report.units import WIDE, rounded
from locosweep.diagnosis.report.written import (
    HEADLINES,
    interval,
    number,
    percent,
    plain,
    rest_of,
    sizes,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from locosweep.diagnosis.report.result import Diagnosis

_MARKS = re.compile(r"([\\`*_\[\]|#~])")


def markdown(diagnosis: Diagnosis) -> str:
    """Return the verdict, what to do, contributions, the gap and where all comes from.

    The same diagnosis gives the same text. Names that come from files are escaped: they make no
    link, no mark and no mention of anybody.
    """
    d = diagnosis
    named = f": {' + '.join(map(words, d.effects))}" if d.effects else ""
    parts = [f"## {HEADLINES[d.status]}{named}", _text(d.summary)]
    if todo := advice(d.report):
        parts.append(f"**{_text(todo)}**")
    parts += [*_gap(d), *_causes(d)]
    if d.status == "unexplained":
        short = shortfall(d.report["verdict"])
        parts.append(f"No effect is named: what comes nearest {short}, and is no cause.")
    if d.unlisted:
        said = "In these runs the same would come from" if d.effects else "The gap looks most like"
        if d.unlisted["outdoes"]:
            said = "A cause that is in no list does better than any known effect:"
        force = f"{family(d.unlisted)}, as of {d.unlisted['like']}"
        parts.append(_text(f"{said} {force}{found_law(d.unlisted)}."))
    if d.law_mismatch:
        parts.append("The cause acts through the variable of this effect, but by another law than "
                     "its formula: the values are those of the nearest formula.")  # fmt: skip
        parts += [_text(f"The law of {words(law['effect'])} by {law['variable']}, as found"
                        f"{text}.") for law in d.laws if (text := found_law(law))]  # fmt: skip
    if suggestion := d.next_experiment.get("suggestion"):
        parts += ["### Next experiment", _text(suggestion)]
    if d.warnings:
        parts += ["### Warnings", "\n".join(f"- {_text(one)}" for one in d.warnings)]
    parts += ["### Where this comes from", _provenance(d)]
    return "\n\n".join(parts) + "\n"


def _gap(d: Diagnosis) -> list[str]:
    sized = sizes(d)
    if d.gap["before"] is None:
        return ["How large the gap is on unseen runs is not known."]
    rows = [["nominal model", sized(d.gap["before"]), ""]]
    if d.effects:
        ends = interval(d.gap["shrink_ci"])
        fall = f"{percent(d.gap['shrink'])} less" + (f" (90 % interval {ends})" if ends else "")
        rows.append(["with the causes" if len(d.effects) > 1 else "with the cause",
                     sized(d.gap["after"]), fall])  # fmt: skip
    rows.append(["noise of the sensors alone", sized(d.gap["noise_floor"]), ""])
    kept = ", ".join(map(_text, d.gap["held_out"]))
    runs = "run" if len(d.gap["held_out"]) == 1 else "runs"
    of = f"the {runs} kept from the fit ({kept})" if kept else "data kept from the fit"
    return [
        "### How large the gap is",
        _table([f"model, error in {_text(d.gap['channel'] or 'x')}", "error", "change"], rows),
        f"Error: root mean square of measured minus simulated, over {of}; the model runs free from "
        f"a start as measured{_over(d.gap['metric'])}.",
    ]  # fmt: skip


def _over(metric: str) -> str:
    """Return what a metric adds: the length of windows."""
    found = re.search(r"over ([0-9.e-]+) s", metric)
    return f", anew every {found[1]} s" if found else ""


def _causes(d: Diagnosis) -> list[str]:
    if not d.effects:
        return []
    row = next((c for c in d.candidates if set(c["effects"]) == set(d.effects)), None)
    rows = []
    for one in d.contributions:
        name, *alike = one["effects"]
        cause = f"**{words(name)}**" + "".join(f" or {words(other)}" for other in alike)
        table = {} if row is None else row["parameters"].get(name, {})
        values = ", ".join(_value(key, entry) for key, entry in table.items())
        rows.append([cause, percent(one["share"]), interval(one["share_ci"]) or "unknown",
                     percent(one["alone"]), values])  # fmt: skip
    left = d.remaining
    if left.get("share") is not None:
        size = f"{sizes(d)(left['rmse'])}, {number(left['noise_floors'])} times the noise"
        rows.append([rest_of(d), percent(left["share"]), "", "", size])
    found = ["### What makes it", _table(
        ["cause", "takes away of the error", "90 % interval", "alone", "values (95 % interval)"],
        rows,
    )]  # fmt: skip
    if any(len(one["effects"]) > 1 for one in d.contributions):
        found.append("Causes with an *or* between them cannot be told apart by these runs; values "
                     "are those of the first.")  # fmt: skip
    return found


def _value(key: str, entry: dict[str, Any]) -> str:
    value, std = entry["value"], entry["std"]
    unit = "" if entry["unit"] == "1" else f" {unit_text(entry['unit'])}"
    if value is None:
        return f"`{key}` unknown"
    half = None if std is None else WIDE * std
    spread = "" if not half else f" ± {half:.2g}"
    return f"`{key}` = {rounded(value, half)}{spread}{unit}".replace("-", "−")


def _provenance(d: Diagnosis) -> str:
    given = d.provenance
    rows = [["locosweep", _text(given["locosweep"])]]
    for name, key in (("runs", "runs"), ("nominal model", "nominal")):
        file = _text(given.get(f"{key}_file") or "from memory")
        rows.append([name, f"{file}, SHA-256 `{str(given.get(f'{key}_sha256'))[:16]}…`"])
    rows.append(["seed", str(given.get("seed"))])
    samples = sum(trace.t.size for trace in d.traces)
    rows.append(["size", f"{len(d.traces)} runs, {samples} samples"])
    return _table(["", ""], rows)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    line: Callable[[Sequence[str]], str] = lambda cells: f"| {' | '.join(cells)} |"  # noqa: E731
    return "\n".join([line(head), line(["---"] * len(head)), *map(line, rows)])


def _text(text: object) -> str:
    """Return text of one line that Markdown shows as it is."""
    shown = _MARKS.sub(r"\\\1", " ".join(plain(text).split()))
    return shown.replace("&", "&amp;").replace("<", "&lt;").replace("@", "&#64;")
