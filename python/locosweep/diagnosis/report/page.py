"""The report for people: one page that carries its pictures and needs no network."""

from __future__ import annotations

import base64
from functools import cache
from typing import TYPE_CHECKING, Any

import jinja2
import numpy as np

from locosweep import _core
from locosweep.diagnosis.report.figures_cause import leading
from locosweep.diagnosis.report.figures_motion import gap_channel
from locosweep.diagnosis.report.figures_style import channel, unit_text, words
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from locosweep.diagnosis.report.result import Diagnosis

_WIDE = 1.96

HEADLINES = {
    "explained": "Cause found",
    "ambiguous": "Cause narrowed down, not settled",
    "partial": "Main cause found, a rest is left",
    "none": "No gap beyond the noise",
    "unexplained": "A gap that no known effect explains",
}


def page(diagnosis: Diagnosis, shown: Mapping[str, bytes]) -> str:
    """Return report.html with pictures (PNG) by file name; those that are missing are left out.

    The page has no scripts and no links to other files. Text that comes from the runs and
    from their file is escaped.
    """
    template = _environment().get_template("page.html.jinja")
    pictures = {
        name.removesuffix(".png"): "data:image/png;base64," + base64.b64encode(data).decode()
        for name, data in shown.items()
    }
    return template.render(
        d=diagnosis,
        headline=HEADLINES[diagnosis.status],
        pictures=pictures,
        leading=leading(diagnosis),
        parameters=_parameters(diagnosis),
        version=_core.version(),
        samples=sum(trace.t.size for trace in diagnosis.traces),
        interval=_interval(diagnosis),
        sized=_sized(diagnosis),
        settings={key: _line(value) for key, value in diagnosis.provenance.items()},
        model=[*_model(diagnosis)],
    )


def short(diagnosis: Diagnosis) -> str:
    """Return a few lines of HTML, for notebooks."""
    template = _environment().from_string(
        "<div><strong>{{ headline }}</strong>, probability {{ d.probability | number(2) }}"
        "<p>{{ d.summary }}</p>{% if d.warnings %}<ul>{% for w in d.warnings %}<li>{{ w }}</li>"
        "{% endfor %}</ul>{% endif %}</div>"
    )
    return template.render(d=diagnosis, headline=HEADLINES[diagnosis.status])


@cache
def _environment() -> jinja2.Environment:
    made = jinja2.Environment(
        loader=jinja2.PackageLoader("locosweep.diagnosis.report", "."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {"number": _number, "percent": _percent, "words": words, "meaning": _meaning,
                     "plain": _plain, "names": _names, "sure": _sure}  # fmt: skip
    # Text from a file may hold characters that are not seen but turn text round.
    made.finalize = lambda value: _plain(value) if type(value) is str else value
    return made


def _plain(text: object) -> str:
    shown = str(text)
    if shown.isprintable():
        return shown
    return "".join(c if c.isprintable() or c in "\n\t" else "□" for c in shown)


def _number(value: float | None, digits: int = 3) -> str:
    if value is None or not np.isfinite(value):
        return "unknown"
    return f"{value:.{digits}g}".replace("-", "−")


def _percent(value: float | None) -> str:
    if value is None or not np.isfinite(value):
        return "unknown"
    # 99.95 % is not 100 %.
    digits = 1 if 0.99 < abs(value) < 1.0 or 0.0 < abs(value) < 0.01 else 0
    return f"{100 * value:.{digits}f} %".replace("-", "−")


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
    found = leading(diagnosis)
    rows = []
    for name, table in (found["parameters"] if found else {}).items():
        records = {p.name: p for p in effect(name).parameters}
        for key, entry in table.items():
            value, std = entry["value"], entry["std"]
            known = value is not None and std is not None
            # As many digits as tell the ends of the interval apart.
            size = abs(value) / std if known and std > 0.0 and value else 100.0
            digits = int(np.clip(np.ceil(np.log10(max(size, 1.0))) + 2, 3, 12))
            ends = (value - _WIDE * std, value + _WIDE * std) if known else ()
            interval = " to ".join(_number(end, digits) for end in ends) or "unknown"
            meaning = records[key].meaning if key in records else ""
            rows.append({"effect": name, "key": key, "value": _number(value, digits),
                         "interval": interval, "unit": unit_text(entry["unit"]),
                         "meaning": meaning})  # fmt: skip
    return rows


def _interval(diagnosis: Diagnosis) -> str:
    low, high = diagnosis.gap["shrink_ci"] or (None, None)
    return "" if low is None or high is None else f"{_percent(low)} to {_percent(high)}"


def _sized(diagnosis: Diagnosis) -> Callable[..., str]:
    """Return what writes an error of a channel in a unit that reads well."""

    def written(value: float | None, name: str | None = None) -> str:
        if value is None or not np.isfinite(value):
            return "unknown"
        of = channel(name or gap_channel(diagnosis), diagnosis.nominal)
        factor, unit = of.scale(abs(value))
        return f"{_number(factor * value)} {unit}"

    return written


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
    rows = []
    for name, value in diagnosis.nominal.parameters.items():
        key = records[name].file_key
        rows.append((".".join(key) if key else name, _number(value, 6),
                     unit_text(records[name].unit)))  # fmt: skip
    for dotted, given in diagnosis.nominal.other.items():
        text = given if isinstance(given, str) else _number(given, 6)
        rows.append((dotted, text, unit_text(others[dotted].unit) if dotted in others else ""))
    return rows
