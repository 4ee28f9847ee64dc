"""Pictures of causes: candidates, parameters, error over the horizon."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.report import figures_style as style
from locosweep.diagnosis.report.figures_motion import gap_channel
from locosweep.diagnosis.report.units import WIDE, rounded, scale
from locosweep.diagnosis.report.written import rest_of
from locosweep.plot.numbers import log_axis, plain_axis
from locosweep.plot.style import LINES, figure
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from locosweep.diagnosis.report.result import Diagnosis

_MOST = 12
_AFTER: tuple[dict[str, Any], ...] = (
    {"color": LINES[2][0], "linestyle": LINES[2][1], "linewidth": 1.3},
    {"color": LINES[3][0], "linestyle": LINES[3][1], "linewidth": 1.3},
)
"""Looks of models with some of the causes; that of all is the augmented model."""
_NARROW = 1e-3
"""Width of an axis relative to its value below which four digits of a tick tell nothing."""


def candidates(diagnosis: Diagnosis) -> Figure | None:
    """Show the weight and the validation error reduction of the leading candidates."""
    rows = diagnosis.candidates[:_MOST]
    if not rows:
        return None
    named = leading(diagnosis)
    made = figure(9.0, 1.1 + 0.36 * len(rows))
    left, right = made.subplots(1, 2, sharey=True)
    names = [" +\n".join(map(style.words, row["effects"])) or "nothing" for row in rows]
    for y, row in enumerate(rows):
        chosen = row is named
        left.barh(y, row["probability"], height=0.62, edgecolor="black", linewidth=0.6,
                  color=style.AUGMENTED["color"] if chosen else "0.75")  # fmt: skip
        sure = row["probability"]
        left.annotate(_sure(sure), (sure, y), xytext=(3, 0),
                      textcoords="offset points", va="center", fontsize=8)  # fmt: skip
        if row["shrink"] is None:
            right.annotate("unknown", (0.0, y), va="center", fontsize=8)
            continue
        low, high = _interval(diagnosis, row)
        if low is not None and high is not None:
            right.plot([low, high], [y, y], color="0.4", linewidth=2.2)
        right.plot(row["shrink"], y, "o", color="black", markersize=5)
    left.set_yticks(range(len(rows)), names, fontsize=8)
    left.set_ylim(len(rows) - 0.4, -0.6)
    partial = diagnosis.status == "partial"
    given = "beside what nobody has explained" if partial else "if one of these leaves only noise"
    left.set(xlim=(0, 1.15), xlabel=f"weight, {given} [1]", ylabel="cause")
    right.set_xlabel("error reduction on runs kept from the fit [1]")
    low, high = right.get_xlim()
    right.set_xlim(max(min(low, -0.02), -1.0), max(high, 1.02))
    for ax in (left, right):
        style.finish(ax)
    return made


def _sure(value: float) -> str:
    """Return a probability of two digits, of which none claims to be certain."""
    if value > 0.995:
        return "> 0.99"
    return f"{value:.2f}" if value >= 0.005 else "< 0.01"


def contributions(diagnosis: Diagnosis) -> Figure | None:
    """Show what each cause takes away of the gap on unseen data, and what is left."""
    rows = diagnosis.contributions
    if not rows:
        return None
    names = [" or\n".join(map(style.words, row["effects"])) for row in rows]
    left = diagnosis.remaining["share"]
    made = figure(7.5, 1.3 + 0.62 * (len(rows) + 1))
    ax = made.subplots()
    for y, row in enumerate(rows):
        ax.barh(y, row["share"], height=0.6, color=style.AUGMENTED["color"], edgecolor="black",
                linewidth=0.6)  # fmt: skip
        end = row["share"]
        if row["share_ci"] is not None:
            low, high = row["share_ci"]
            ax.plot([low, high], [y, y], color="black", linewidth=1.6, marker="|", markersize=9)
            end = max(end, high)
        alone = "" if row["alone"] is None or len(rows) == 1 else f"; alone {row['alone']:.0%}"
        ax.annotate(f"{row['share']:.0%}{alone}", (max(end, 0.0), y), xytext=(5, 0),
                    textcoords="offset points", va="center", fontsize=9)  # fmt: skip
    if left is not None:
        names.append(rest_of(diagnosis).replace(" ", "\n", 1))
        ax.barh(len(rows), left, height=0.6, color="white", edgecolor="black", hatch="////",
                linewidth=0.6)  # fmt: skip
        ax.annotate(f"{left:.0%}", (left, len(rows)), xytext=(5, 0), textcoords="offset points",
                    va="center", fontsize=9)  # fmt: skip
    ax.set_yticks(range(len(names)), names, fontsize=9)
    ax.set_ylim(len(names) - 0.4, -0.6)
    low, high = ax.get_xlim()
    # Room for the words behind the longest line.
    ax.set_xlim(min(low, 0.0), max(high, 1.0) + (0.16 if len(rows) == 1 else 0.28))
    ax.axvline(0.0, color="black", linewidth=0.8)
    ax.set_xlabel(f"share of the error in {diagnosis.gap['channel'] or 'x'} on unseen data [1]; "
                  "line: 90 % interval")  # fmt: skip
    style.finish(ax)
    return made


def _interval(diagnosis: Diagnosis, row: dict[str, Any]) -> tuple[float | None, float | None]:
    """Interval of a candidate's error reduction; the verdict's is in the gap."""
    found = row.get("shrink_ci")
    if found is None and row is leading(diagnosis):
        found = diagnosis.gap.get("shrink_ci")
    return (None, None) if found is None else (found[0], found[1])


def leading(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return the candidate that the verdict names, whatever the order of its effects."""
    named = set(diagnosis.effects)
    return next(
        (row for row in diagnosis.candidates if named and set(row["effects"]) == named), None
    )


def parameters(diagnosis: Diagnosis) -> Figure | None:
    """Show each fitted parameter of the verdict with its 95 % interval."""
    row = leading(diagnosis)
    fitted = [] if row is None else [
        (name, key, entry) for name, table in row["parameters"].items()
        for key, entry in table.items() if entry["value"] is not None
    ]  # fmt: skip
    if not fitted:
        return None
    made = figure(7.0, 0.85 * len(fitted) + 0.2)
    axes = made.subplots(len(fitted), 1, squeeze=False).ravel()
    for ax, (name, key, entry) in zip(axes, fitted, strict=True):
        value, std = entry["value"], entry["std"]
        half = WIDE * std if std else 0.0
        symbol = {p.name: p.symbol for p in effect(name).parameters}.get(key, key)
        room = 2.5 * half or 0.1 * abs(value) or 1.0
        unit = style.unit_text(entry["unit"])
        label, at, factor = f"${symbol}$ [{unit}]", value, 1.0
        if room < _NARROW * abs(value):
            near = float(f"{value:.5g}")
            factor, small = scale(room, unit)
            label = f"${symbol}$ − {near:.5g} {unit} [{small}]".replace(" 1 [", " [")
            at = factor * (value - near)
            room, half = factor * room, factor * half
        ax.errorbar(at, 0.0, xerr=half or None, fmt="o", color=style.AUGMENTED["color"],
                    markersize=6, linewidth=1.8, capsize=4)  # fmt: skip
        ax.set_xlim(at - room, at + room)
        plain_axis(ax.xaxis)
        ax.set_yticks([])
        ax.set_xlabel(label, fontsize=9, labelpad=1)
        ax.set_ylabel(style.words(name).replace(" ", "\n"), rotation=0, ha="right", va="center",
                      fontsize=8)  # fmt: skip
        wide = half / factor
        spread = f" ± {wide:.2g}" if half else ", interval unknown"
        text = f"{rounded(value, wide, 5)}{spread} {unit}".removesuffix(" 1")
        ax.set_title(text, fontsize=8, loc="right", pad=2)
        ax.tick_params(labelsize=8)
        for side in ("left", "right", "top"):
            ax.spines[side].set_visible(False)
    return made


def horizons(diagnosis: Diagnosis) -> Figure | None:
    """Show the error over the length of free runs: before, after each cause, and noise."""
    seconds, lines, restarted = _free_runs(diagnosis)
    if not seconds or not any(lines[0][1]):
        return None
    made = figure(7.0, 3.6)
    ax = made.subplots()
    info = style.channel(gap_channel(diagnosis), diagnosis.nominal)
    factor, unit = info.scale(float(np.nanmax([error or 0.0 for error in lines[0][1]])))
    for rank, (name, errors) in enumerate(lines):
        look = style.NOMINAL if rank == 0 else _AFTER[(rank - 1) % len(_AFTER)]
        if rank == len(lines) - 1 and rank > 0:
            look = style.AUGMENTED
        shown = [(t, factor * e) for t, e in zip(seconds, errors, strict=True) if e]
        if shown:
            ax.plot(*zip(*shown, strict=True), marker="oD^sv"[rank % 5], markersize=4,
                    markevery=1 if restarted else 4, label=name, **look)  # fmt: skip
    floor = diagnosis.gap.get("noise_floor")
    if floor:
        ax.axhline(factor * floor, color="0.3", linestyle=":", linewidth=1.2, label="noise floor")
    what = ", restarted from the measured state" if restarted else ""
    ax.set(yscale="log", xlabel=f"length of the free run{what} [s]",
           ylabel=f"rmse of ${info.symbol}$ [{unit}]")  # fmt: skip
    log_axis(ax.yaxis)
    if restarted:
        ax.set_xscale("log")
        ax.set_xticks(seconds, [f"{one:g}" for one in seconds])
        ax.xaxis.minorticks_off()
    ax.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    style.finish(ax)
    return made


def _free_runs(
    diagnosis: Diagnosis,
) -> tuple[list[float], list[tuple[str, list[float | None]]], bool]:
    """Return lengths of free runs, errors by the name of a model, and whether runs start anew."""
    found = diagnosis.details.get("free_runs")
    if found and found["seconds"]:
        lines, before = [], list(diagnosis.effects)
        for name, errors in found["errors"].items():
            words = name
            if name in before:
                rank = before.index(name)
                words = f"{'with ' if rank == 0 else '… and '}{style.words(name)}"
            lines.append((words, errors))
        return found["seconds"], lines, found["restarted"]
    rows = [row for row in diagnosis.gap["horizons"] if row["before"]]
    lines = [("nominal model", [row["before"] for row in rows])]
    if diagnosis.effects:
        lines.append(("augmented model", [row["after"] for row in rows]))
    return [row["seconds"] for row in rows], lines, True
