"""The report for people: one page that carries its pictures and needs no network."""

from __future__ import annotations

import base64
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.diagnosis.report.curves import curves
from locosweep.diagnosis.report.figures_cause import leading
from locosweep.diagnosis.report.figures_motion import runs_small
from locosweep.diagnosis.report.figures_style import unit_text, words
from locosweep.diagnosis.report.sentences import advice, family, found_law, shortfall
from locosweep.diagnosis.report.units import WIDE, rotary_unit, rounded
from locosweep.diagnosis.report.written import HEADLINES, interval, number, percent, plain, sizes
from locosweep.files.robot import is_rotary
from locosweep.plot.explorer.page import digest_of, json_block, script_of, templates
from locosweep.plot.html import picture_of
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from collections.abc import Mapping

    import jinja2

    from locosweep.diagnosis.report.result import Diagnosis

_BESIDE = ("runs_large.png",)
"""Pictures that stand beside the page only, as its script draws the same."""
_OPTIONS = {
    "holdout": "runs kept from the fit on request",
    "labels": "runs that take part",
    "max_effects": "most effects at once",
    "columns": "columns as named in the file",
    "units": "units of the file",
}


def page(diagnosis: Diagnosis, shown: Mapping[str, bytes], command: str | None = None) -> str:
    """Return report.html with pictures (PNG) by file name; those that are missing are left out.

    `command` is what was typed. The page has one script, its own, and no links to other files.
    Text that comes from the runs and from their file is escaped.
    """
    runs, numbers = curves(diagnosis)
    script = script_of("canvas.js", "curves.js")
    template = _environment().get_template("page.html.jinja")
    pictures = {
        name.removesuffix(".png"): "data:image/png;base64," + base64.b64encode(data).decode()
        for name, data in shown.items()
        if name not in _BESIDE
    }
    return template.render(
        d=diagnosis,
        headline=HEADLINES[diagnosis.status],
        pictures=pictures,
        leading=leading(diagnosis),
        parameters=_parameters(diagnosis),
        version=_core.version(),
        samples=sum(trace.t.size for trace in diagnosis.traces),
        interval=interval(diagnosis.gap["shrink_ci"]),
        sized=sizes(diagnosis),
        settings=_settings(diagnosis, command),
        made=f" on {made}" if (made := diagnosis.details.get("made")) else "",
        todo=advice(diagnosis.report),
        shortfall=shortfall(diagnosis.report["verdict"]),
        model=[*_model(diagnosis)],
        curves=json_block(runs) if runs["runs"] else "",
        numbers=numbers,
        restarted=diagnosis.details.get("free_runs", {}).get("restarted", False),
        script=script,
        digest=digest_of(script),
    )


def short(diagnosis: Diagnosis) -> str:
    """Return a few lines of HTML and a picture of the runs, for notebooks."""
    made = runs_small(diagnosis)
    made.set_size_inches(min(7.5, made.get_figwidth()), min(4.5, made.get_figheight()))
    image = picture_of(made, diagnosis.summary)
    template = _environment().from_string(
        "<div><strong>{{ headline }}</strong>, probability {{ d.probability | number(2) }}"
        "<p>{{ d.summary }}</p>{% if d.warnings %}<ul>{% for w in d.warnings %}<li>{{ w }}</li>"
        "{% endfor %}</ul>{% endif %}{{ image | safe }}</div>"
    )
    return template.render(d=diagnosis, headline=HEADLINES[diagnosis.status], image=image)


@cache
def _environment() -> jinja2.Environment:
    made = templates("locosweep.diagnosis.report")
    made.filters |= {"number": number, "percent": percent, "words": words, "meaning": _meaning,
                     "plain": plain, "names": _names, "sure": _sure,
                     "family": family, "found_law": found_law}  # fmt: skip
    # Text from a file may hold characters that are not seen but turn text round.
    made.finalize = lambda value: plain(value) if type(value) is str else value
    return made


def _sure(value: float) -> str:
    """Return a probability: what is small or nearly sure needs no digits."""
    if value < 0.001:
        return "< 0.001"
    return "> 0.999" if value > 0.999 else f"{value:.3f}".rstrip("0")


def _names(effects: list[str]) -> str:
    return " + ".join(map(words, effects)) or "nothing"


def _meaning(name: str) -> str:
    return effect(name).meaning


def _parameters(diagnosis: Diagnosis) -> list[dict[str, str]]:
    """Rows of the table of fitted parameters."""
    found = leading(diagnosis) or _nearest(diagnosis)
    rows = []
    for name, table in (found["parameters"] if found else {}).items():
        records = {p.name: p for p in effect(name).parameters}
        for key, entry in table.items():
            value, std = entry["value"], entry["std"]
            known = value is not None and std is not None
            half = WIDE * std if known else None
            ends = () if half is None else (value - half, value + half)
            between = " to ".join(_rounded(end, half) for end in ends) or "unknown"
            meaning = records[key].meaning if key in records else ""
            rows.append({"effect": name, "key": key, "value": _rounded(value, half),
                         "interval": between, "unit": unit_text(entry["unit"]),
                         "meaning": meaning})  # fmt: skip
    return rows


def _rounded(value: float | None, half: float | None) -> str:
    """Return a value with the digits that half the width of its interval lets stand."""
    if value is None or not np.isfinite(value):
        return "unknown"
    return rounded(value, half).replace("-", "−")


def _nearest(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return the candidate that comes nearest where nothing explains the gap."""
    if diagnosis.status != "unexplained":
        return None
    return next((row for row in diagnosis.candidates if row["effects"]), None)


def _settings(diagnosis: Diagnosis, command: str | None) -> dict[str, str]:
    """Return what was asked for and of which files, in words."""
    given = dict(diagnosis.provenance)
    found = {} if command is None else {"command": command}
    for name in ("runs", "nominal"):
        file, digest = given.pop(f"{name}_file", None), given.pop(f"{name}_sha256", None)
        found["nominal model" if name == "nominal" else name] = (
            f"{file or 'from memory'}, SHA-256 {_line(digest)}"
        )
    for key, value in given.pop("options", {}).items():
        if value not in (None, {}, []):
            found[_OPTIONS.get(key, words(key))] = _line(value)
    rest = given.pop("largest_rest", None)
    if rest and rest["deviations"] is not None and rest["channel"]:
        found["most unlike noise, of what is left"] = (
            f"means over {rest['samples']} samples of {rest['channel']}, "
            f"{number(rest['deviations'], 2)} standard deviations off"
        )
    labels = given.pop("start_speed_free", [])
    if labels:
        found["runs whose start speed was fitted"] = _line(labels)
    return found | {words(key): _line(value) for key, value in given.items()}


def _line(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{words(str(key))} {_line(one)}" for key, one in value.items()) or "none"
    if isinstance(value, list | tuple):
        return ", ".join(map(_line, value)) or "none"
    return "unknown" if value is None else str(value)


def _model(diagnosis: Diagnosis) -> list[tuple[str, str, str]]:
    """Nominal values: table and key of the file, value, unit."""
    records = {p.name: p for p in _core.parameters()}
    others = {f"{p.file_key[0]}.{p.file_key[1]}": p for p in _core.file_keys() if p.file_key}
    rotary = is_rotary(diagnosis.nominal)
    rows = []
    for name, value in diagnosis.nominal.parameters.items():
        key = records[name].file_key
        unit = records[name].unit
        # Gravity acts along the ground on any rig.
        unit = rotary_unit(unit) if rotary and name != "gravity" else unit
        rows.append((".".join(key) if key else name, number(value, 6), unit_text(unit)))
    for dotted, given in diagnosis.nominal.other.items():
        text = given if isinstance(given, str) else number(given, 6)
        unit = others[dotted].unit if dotted in others else ""
        rows.append((dotted, text, unit_text(rotary_unit(unit) if rotary else unit)))
    return rows
