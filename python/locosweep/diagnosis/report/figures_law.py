"""Picture of a law that the listed formulas lack: a force over its variable, and a formula."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.report import figures_style as style
from locosweep.diagnosis.report.units import WIDE, scale
from locosweep.plot.style import figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from locosweep.diagnosis.report.result import Diagnosis

_LONGEST = 80
"""Letters of a line of a title: as wide as the axes are."""
_NAMES = {
    "N": "force",
    "N m": "torque",
    "m": "error of the reading",
    "rad": "error of the reading",
    "1": "change of the drive, as a share",
}
"""What a law is, by its unit, where it does not turn round with the motion."""


def law(diagnosis: Diagnosis) -> Figure | None:
    """Show each law that was found: the curve with its 95 % band, and the formula if one holds."""
    rows = [(f"law of {style.words(row['effect'])}, as found", row) for row in diagnosis.laws]
    if diagnosis.unlisted and diagnosis.unlisted["curve"]:
        rows.append((f"not in the list: {diagnosis.unlisted['family']}", diagnosis.unlisted))
    if not rows:
        return None
    made = figure(7.0, 3.4 * len(rows))
    for ax, (title, row) in zip(made.subplots(len(rows), 1, squeeze=False).ravel(), rows,
                                strict=True):  # fmt: skip
        _draw(ax, title, row)
    return made


def _draw(ax: Axes, title: str, row: dict[str, Any]) -> None:
    curve = row["curve"]
    at, value, std = (np.array(curve[key]) for key in ("at", "value", "std"))
    along, at_unit = scale(float(np.abs(at).max()), curve["at_unit"])
    factor, unit = scale(style.reach([value]), curve["unit"])
    half = WIDE * std
    ax.fill_between(along * at, factor * (value - half), factor * (value + half), color="0.85",
                    label="95 % interval")  # fmt: skip
    ax.plot(along * at, factor * value, label="any smooth law", **style.AUGMENTED)
    if curve["by_formula"] is not None:
        by = factor * np.array(curve["by_formula"])
        ax.plot(along * at, by, label="formula", **style.NOMINAL)
    ax.axhline(0.0, color="black", linewidth=0.8)
    name = "resistance" if row["parity"] == "odd" else _NAMES[curve["unit"]]
    ax.set(
        xlabel=f"{row['variable']} [{style.unit_text(at_unit)}]",
        ylabel=f"{name} [{style.unit_text(unit)}]",
    )
    if row["formula"]:
        title += "\n" + fill(row["formula"], _LONGEST)
    ax.set_title(title, fontsize=9, loc="left")
    ax.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    style.finish(ax)
