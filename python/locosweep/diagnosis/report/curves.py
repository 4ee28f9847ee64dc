"""Runs as the page carries them: measured, nominal and after each cause, few enough samples."""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.report import figures_style as style
from locosweep.diagnosis.report.figures_motion import NOISE_BAND, gap_channel, residual
from locosweep.files.channels import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.report.result import Diagnosis, Trace

    Floats = NDArray[np.float64]

ROOM = 600_000
"""Letters that the samples of all runs may take in a page of 1.5 MB, beside its pictures."""
_LETTERS = 16 / 3
"""Letters of base64 that a number of 32 bits takes."""
_LEAST = 300
"""Samples of a run below which its curves would not look like it."""
_LOOKS: tuple[tuple[str, list[int]], ...] = (("after1", [2, 3]), ("after2", [7, 3]), ("after3", []))
"""Colour and dash of models with one cause more each; the last one is drawn whole."""
_HINT = (
    "Point at the curves: values stand here. Drag over a part to enlarge it, a double click shows "
    "all; keys: arrows, +, - and 0."
)


def curves(diagnosis: Diagnosis, room: int = ROOM) -> tuple[dict[str, Any], str]:
    """Return what the page's script needs to draw runs, and their numbers as base64 of float32.

    Of runs longer than fits, samples are chosen: in each of equal parts those where measured
    minus nominal is largest and smallest, so that no peak of the gap is lost. Where not even
    few samples of all runs fit, runs with small gaps are left out. Lines are what they add to the
    nominal model, which stands before them.
    """
    stages = diagnosis.details.get("stages", {})
    lines = _lines(diagnosis, stages)
    traces = [*enumerate(diagnosis.traces)]
    numbers = {k: 1 + (1 + len(lines)) * len(trace.measured) for k, trace in traces}
    per_run = room / _LETTERS / max(1, max(numbers.values(), default=1))
    most = max(1, int(per_run / _LEAST))
    if len(traces) > most:
        before = {row["run"]: row["before"] or 0.0 for row in diagnosis.where["runs"]}
        traces.sort(key=lambda one: -before.get(one[1].label, 0.0))
        traces = sorted(traces[:most], key=lambda one: one[0])
    count = max(2, int(per_run / max(1, len(traces))))
    parts: list[Floats] = []
    runs = []
    for k, trace in traces:
        picked = _picked(diagnosis, trace, count)
        named = [name for name in CHANNELS if name in trace.measured]
        parts.append(trace.t[picked] - trace.t[0])
        for name in named:
            fields = [trace.measured[name], trace.nominal.get(name)]
            fields += [own[name][k] if name in own else None for own in stages.values()]
            fields += [trace.augmented.get(name)] if diagnosis.effects else []
            base = np.zeros(picked.size) if fields[1] is None else np.nan_to_num(fields[1][picked])
            parts.append(base)
            parts += [np.full(picked.size, np.nan) if f is None else f[picked] - base
                      for f in fields]  # fmt: skip
        runs.append(_record(trace, picked.size, named))
    data = {
        "lines": lines,
        "channels": [_channel(diagnosis, name) for name in CHANNELS
                     if any(name in run["channels"] for run in runs)],
        "runs": runs,
        "first": _first(diagnosis, [trace for _, trace in traces]),
        "hint": _HINT,
    }  # fmt: skip
    if len(runs) < len(diagnosis.traces):
        for run in runs:
            run["note"] += f" The {len(runs)} runs with the largest gaps are here."
    raw = np.concatenate(parts).astype("<f4") if parts else np.empty(0, "<f4")
    return data, base64.b64encode(raw.tobytes()).decode("ascii")


def _lines(diagnosis: Diagnosis, stages: Collection[str]) -> list[dict[str, Any]]:
    """Return name, colour and dash of each line: measured, nominal, and after each cause."""
    found: list[dict[str, Any]] = [
        {"words": "measured", "ink": "measured", "dash": []},
        {"words": "nominal model", "ink": "nominal", "dash": [6, 4]},
    ]
    if not diagnosis.effects:
        return found
    causes = [style.words(name) for name in diagnosis.effects]
    for k in range(len(stages) + 1):
        last = k == len(stages)
        ink, dash = _LOOKS[-1] if last else _LOOKS[min(k, len(_LOOKS) - 2)]
        named = " and ".join(causes if last else causes[: k + 1])
        found.append({"words": f"with {named}", "ink": ink, "dash": dash})
    return found


def _picked(diagnosis: Diagnosis, trace: Trace, most: int) -> NDArray[np.intp]:
    """Return the numbers of at most so many samples, the extremes of the gap among them."""
    size = trace.t.size
    if size <= most:
        return np.arange(size)
    gap = residual(trace, trace.nominal, gap_channel(diagnosis, trace))
    found = [0, size - 1]
    for part in np.array_split(np.arange(size), max(1, (most - 2) // 2)):
        own = gap[part]
        if np.isfinite(own).any():
            found += [int(part[np.nanargmin(own)]), int(part[np.nanargmax(own)])]
        else:
            found.append(int(part[0]))
    return np.unique(found)


def _record(trace: Trace, count: int, channels: Sequence[str]) -> dict[str, Any]:
    role = "kept from the fit" if trace.held_out else "used for the fit"
    size = trace.t.size
    note = "" if count == size else (
        f"{count} of {size} samples are here, with the extremes of the gap in each part."
    )  # fmt: skip
    return {"words": f"{_shown(trace.label)}, {role}", "count": count, "samples": size,
            "channels": list(channels), "note": note}  # fmt: skip


def _shown(text: str) -> str:
    """Return a label from a file without characters that turn text round."""
    return "".join(c if c.isprintable() else "□" for c in text)


def _channel(diagnosis: Diagnosis, name: str) -> dict[str, Any]:
    """Return words of a channel, and units in which its values and its errors read well."""
    info = style.channel(name, diagnosis.nominal)
    own = [trace for trace in diagnosis.traces if name in trace.measured]
    factor, unit = info.scale(style.reach(t.measured[name] for t in own))
    noise = NOISE_BAND * (diagnosis.details.get("noise", {}).get(name) or 0.0)
    errors = style.reach(residual(t, t.nominal, name) for t in own)
    error_factor, error_unit = info.scale(max(errors, noise))
    return {"name": name, "words": info.words, "factor": factor, "unit": style.unit_text(unit),
            "noise": noise, "errorFactor": error_factor,
            "errorUnit": style.unit_text(error_unit)}  # fmt: skip


def _first(diagnosis: Diagnosis, traces: Sequence[Trace]) -> int:
    """Return the number of the run with the largest gap among those kept from the fit."""
    before = {row["run"]: row["before"] or 0.0 for row in diagnosis.where["runs"]}
    judged = [k for k, trace in enumerate(traces) if trace.held_out] or list(range(len(traces)))
    return max(judged, key=lambda k: before.get(traces[k].label, 0.0), default=0)
