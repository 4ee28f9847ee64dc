"""Pictures of friction laws: an overview, and one page for each law."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from matplotlib.lines import Line2D
from matplotlib.mathtext import MathTextParser

from locosweep.plot import style
from locosweep.plot.laws import KIND_COLOURS, behaviour, characteristic

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure

    from locosweep.registry import Law
    from locosweep.simulation.law_data import Behaviour, Characteristic

_AT_REST = {"dry": "holds at rest", "smooth": "creeps at rest", "bristle": "yields, then slides"}
_BESIDE = {
    "load_friction": "level rises with\nthe drive force",
    "viscous_load": "slope rises with\nthe normal force",
    "skin_ratio": "level differs\nbackward",
    "ripple_length": "level varies\nalong the track",
    "patch_length": "level differs\non a patch",
    "track_length": "level varies\nalong the track",
    "buildup": "grows with the\ndistance swept",
    "dwell_time": "peak grows with\nthe time at rest",
}
"""By a parameter that only such a law has: what force over speed cannot show."""

_PLAINER = (
    (r"\\left\\{\\begin\{array\}\{ll\}", r"\\{\\,"),
    (r"\\end\{array\}\\right\\}", r"\\,\\}\\,"),
    (r" & ", r"\\ \\mathrm{for}\\ "),
    (r" \\\\ ", r";\\quad "),
    (r"\\le\b", r"\\leq"),
    (r"\\tfrac(\d)(\d)", r"\\frac{\1}{\2}"),
    (r"\\sqrt (\w)", r"\\sqrt{\1}"),
    (r"(?<=[\w}]) ?\\(sin|min|tanh)", r"\\,\\\1"),
)
"""From LaTeX to the part of it that matplotlib sets."""

_COLUMNS = 5
_WIDTH = 105
"""Characters of TeX that fit on a line of a page, about."""


def overview(
    laws: Sequence[Law], seen: Sequence[Characteristic], frame: tuple[float, float]
) -> Figure:
    """Draw all laws as small multiples in one frame."""
    rows = -(-(len(seen) + 1) // _COLUMNS)
    figure = style.figure(2.9 * _COLUMNS, 2.35 * rows)
    grid = figure.subplots(rows, _COLUMNS, sharex=True, sharey=True, squeeze=False)
    for i, ax in enumerate(grid.flat):
        if i >= len(seen):
            ax.set_axis_off()
            continue
        law = laws[i]
        characteristic(seen[i], ax=ax, frame=frame, legend=False)
        ax.set_title(law.name, fontsize=11, color=KIND_COLOURS[law.kind], fontweight="bold")
        notes = [_BESIDE[p.name] for p in law.parameters if p.name in _BESIDE]
        ax.text(0.97, 0.05, "".join(notes[:1]), transform=ax.transAxes, ha="right", va="bottom",
                fontsize=9, color="0.25")  # fmt: skip
        ax.set(xlabel="", ylabel="")
        below = i + _COLUMNS
        ax.tick_params(labelbottom=below >= len(seen), labelleft=i % _COLUMNS == 0)
    handles = [
        Line2D([], [], color=colour, linewidth=2.5, label=f"{kind}: {_AT_REST[kind]}")
        for kind, colour in KIND_COLOURS.items()
    ]
    grid.flat[len(seen)].legend(handles=handles, loc="center left", fontsize=10, frameon=False,
                                borderaxespad=0.0, handlelength=1.4)  # fmt: skip
    figure.supxlabel("speed $v$ [m/s]")
    figure.supylabel("friction over Coulomb level")
    return figure


def page(
    law: Law,
    seen: Characteristic,
    more: Behaviour,
    frame: tuple[float, float],
    values: Mapping[str, float],
) -> Figure:
    """Draw one law: its formula, characteristic and behaviour, and the values used."""
    formula = _lines(law.formula)
    figure = style.figure(11.5, 5.4 + 0.38 * len(formula))
    left, right = figure.subplots(1, 2)
    characteristic(seen, ax=left, frame=frame)
    left.set_title("steady sliding", fontsize=10)
    behaviour(more, ax=right)
    head = f"{law.name}: {law.meaning}"
    figure.suptitle("\n".join([head, *formula]), fontsize=12)
    words = [style.setting(p.name, values[p.name]) for p in law.parameters if p.name in values]
    figure.supxlabel(_wrapped(words), fontsize=8.5, color="0.3")
    return figure


def _wrapped(words: Sequence[str], most: int = 7) -> str:
    lines = [", ".join(words[i : i + most]) for i in range(0, len(words), most)]
    return "\n".join(lines)


def _lines(formula: str) -> list[str]:
    """Break a formula where its parts are separate; empty where it cannot be set."""
    for pattern, words in _PLAINER:
        formula = re.sub(pattern, words, formula)
    lines = [""]
    for part in re.split(r"(?<=[,;])\\quad ", formula):
        if lines[-1] and len(lines[-1]) + len(part) > _WIDTH:
            lines.append(part)
        else:
            lines[-1] = rf"{lines[-1]}\quad {part}" if lines[-1] else part
    texts = [f"${line}$" for line in lines]
    parser = MathTextParser("agg")
    try:
        for text in texts:
            parser.parse(text)
    except ValueError:
        return []
    return texts
