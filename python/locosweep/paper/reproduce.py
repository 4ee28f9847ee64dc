"""Reproduce the paper's figures and check every number it states."""

from __future__ import annotations

import re
import textwrap
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from locosweep import _core
from locosweep.errors import InputError
from locosweep.files.atomic import write_text
from locosweep.files.folder import make_folder
from locosweep.files.robot import Robot
from locosweep.paper.claims import CLAIMS, Row, robot_rows
from locosweep.paper.contact import CONTACT_FIGURES
from locosweep.paper.figures import FIGURES
from locosweep.paper.heap import HEAP_FIGURES
from locosweep.paper.limits import LIMIT_CLAIMS
from locosweep.paper.surfaces import SURFACE_CLAIMS, SURFACE_FIGURES
from locosweep.plot.save import save_figure
from locosweep.progress import progress_of
from locosweep.provenance import spec_hash

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable, Sequence

    from locosweep.progress import Progress

_PAPER = (
    "Virgala, Gmiterko, Frankovsky: Experimental Analysis of Friction Effects Affecting the Snake "
    "Robot Segment during Rectilinear Locomotion, American Journal of Mechanical Engineering "
    "1(7), 2013, 412-416"
)
_OPEN = (
    "whether anchors carry their own weight on a slope (w = 1 or w = 0; both are shown)",
    "the constant in the phase time t = sqrt(2 δ/a): it scales velocities, not the best count",
    "the stroke δ of Figure 2: velocities scale with its root; 20 mm is assumed",
    "whether the viscous solution (10) keeps the Coulomb term (both are shown)",
    "friction of the three surfaces of Figures 7 to 13, the motor and the stroke",
    "equation numbers: the text cites (6) as equation of motion and (9) as propulsive force",
)
_NOT_COMPARED = (
    "Figures 7 to 9 and 11 are measurements of which the paper prints no numbers: what is drawn "
    "here illustrates them and is compared with nothing. Figures 7 to 9 show friction that was "
    "planted in the simulated sensors of a rig and fitted again, Figure 11 the lubricant of an "
    "assumed build-up. Figures 10, 12 "
    "and 13 are measurements too: here the stroke of the head is simulated with "
    "assumed oil and lubricant, and compared with what the text says of them. The sensor (range "
    "50 mm, step 5 µm) is taken as stated."
)

_FIGURES = dict(sorted({**FIGURES, **CONTACT_FIGURES, **HEAP_FIGURES, **SURFACE_FIGURES}.items()))
_CLAIMS = (CLAIMS, LIMIT_CLAIMS, SURFACE_CLAIMS)

_COLUMNS = (
    ("Claim", 46),
    ("In the paper", 17),
    ("Paper", 19),
    ("Here", 40),
    ("Verdict", 13),
    ("Note", 46),
)
"""Heading and width in letters."""

_UNIT = re.compile(r"(?<=\d) (?=(?:N|V|s|deg|mm|m/s|mm/s|m/s²|Pa s|g)\b)|(?<==) | (?==)")
_KEPT = "\N{NO-BREAK SPACE}"

_SHADES = {"agrees": "#d6e9f5", "differs": "#fbdcc4", "ambiguous in the paper": "#ececec"}
_SIGNS = {"agrees": "✓", "differs": "✗", "ambiguous in the paper": "?"}


@dataclass(frozen=True)
class Report:
    """Claims compared, and files written by `reproduce` in their order."""

    rows: tuple[Row, ...]
    files: tuple[Path, ...]

    def to_markdown(self) -> str:
        """Return the table with its conditions as Markdown."""
        count = {verdict: sum(row.verdict == verdict for row in self.rows) for verdict in _SIGNS}
        total = ", ".join(f"{number} {verdict}" for verdict, number in count.items())
        heads = [head for head, _ in _COLUMNS]
        lines = [
            "# Reproduction of the paper",
            "",
            f"{_PAPER}.",
            "",
            f"Computed by locosweep {_core.version()}: {len(self.rows)} claims, {total}.",
            "",
            _line(heads),
            _line(["---"] * len(heads)),
            *(_line(_cells(row)) for row in self.rows),
            "",
            "What the paper leaves open:",
            "",
            *(f"- {text}" for text in _OPEN),
            "",
            _NOT_COMPARED,
        ]
        pictures = [file.name for file in self.files if file.name.startswith("figure")]
        for name in pictures:
            lines += ["", f"![{name}]({name})"]
        return "\n".join(lines) + "\n"


def _cells(row: Row) -> list[str]:
    verdict = f"{_SIGNS[row.verdict]} {row.verdict}"
    return [row.claim, row.source, row.paper, row.ours, verdict, row.note]


def _line(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def reproduce(
    figures: str | int | Iterable[int],
    out_dir: str | os.PathLike[str],
    *,
    robot: Robot | None = None,
    progress: bool | Progress | None = None,
) -> Report:
    """Draw the paper's figures and compare the numbers of its text.

    Parameters
    ----------
    figures : "all", int or sequence of int
        Of 2 to 5 and 7 to 13. Claims of the text that belong to no figure are always compared;
        7, 8, 9 and 11 are illustrations without a claim.
    out_dir : path-like
        Folder for ``figure2.png`` and so on, ``reproduction.md`` and
        ``reproduction.png``; made if missing.
    robot : Robot, optional
        A robot file to compare with the paper's statements on its robot.
    progress : bool or callable, optional
        As in `sweep`; it counts files.

    Examples
    --------
    >>> import tempfile
    >>> from locosweep.paper.reproduce import reproduce
    >>> report = reproduce(3, tempfile.mkdtemp())
    >>> [file.name for file in report.files]
    ['figure3.png', 'reproduction.png', 'reproduction.md']
    >>> {row.verdict for row in report.rows if row.source == "Figure 3"}
    {'agrees'}
    """
    chosen = _chosen(figures)
    folder = make_folder(out_dir)
    rows = tuple(
        row
        for number in (0, *chosen)
        for claims in _CLAIMS
        if number in claims
        for row in claims[number]()
    )
    if robot is not None:
        rows += tuple(robot_rows(robot))
    files: list[Path] = []
    start = time.perf_counter()
    meter = progress_of(progress, "reproduce", "files")

    def done(file: Path) -> None:
        files.append(file)
        if meter is not None:
            rate = len(files) / max(time.perf_counter() - start, 1e-9)
            meter(len(files), len(chosen) + 2, rate)

    command = f"locosweep.reproduce({list(chosen)})"
    for number in chosen:
        figure, results = _FIGURES[number]()
        path = folder / f"figure{number}.png"
        save_figure(figure, path, command=command, spec=spec_hash(*results) if results else None)
        done(path)
    table = folder / "reproduction.png"
    save_figure(_table(rows), table, command=command)
    done(table)
    words = folder / "reproduction.md"
    write_text(words, Report(rows, tuple(files)).to_markdown())
    done(words)
    return Report(rows, tuple(files))


def _chosen(figures: str | int | Iterable[int]) -> tuple[int, ...]:
    allowed = f"allowed are {', '.join(map(str, _FIGURES))} or 'all'"
    if isinstance(figures, str):
        if figures != "all":
            raise InputError(f"figures is {figures!r}: {allowed}")
        return tuple(_FIGURES)
    wanted = [figures] if isinstance(figures, int) else list(figures)
    for number in wanted:
        if isinstance(number, bool) or number not in _FIGURES:
            raise InputError(
                f"figure {number!r} is not among those of the paper that are reproduced: {allowed}"
            )
    if not wanted:
        raise InputError(f"figures is empty: {allowed}")
    return tuple(number for number in _FIGURES if number in wanted)


def _table(rows: Sequence[Row]) -> Figure:
    """Draw the table as a picture; all lengths in inches."""
    letter, line, gap, margin = 0.072, 0.165, 0.12, 0.25
    widths = [letter * width + gap for _, width in _COLUMNS]
    blocks = [
        [
            textwrap.wrap(_UNIT.sub(_KEPT, cell), width)
            for cell, (_, width) in zip(_cells(row), _COLUMNS, strict=True)
        ]
        for row in rows
    ]
    heights = [line * max(map(len, cells)) + gap for cells in blocks]
    width = sum(widths) + 2 * margin
    height = sum(heights) + 4 * line + 2 * margin
    figure = Figure(figsize=(width, height))
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set(xlim=(0, width), ylim=(height, 0))
    ax.axis("off")
    lefts = [margin + sum(widths[:i]) for i in range(len(widths))]
    title = f"What the paper states and what locosweep {_core.version()} computes"
    ax.text(margin, margin, title, fontsize=13, weight="bold", va="top")
    y = margin + 2.4 * line
    for (head, _), x in zip(_COLUMNS, lefts, strict=True):
        ax.text(x + gap / 2, y, head, fontsize=10, weight="bold", va="top")
    y += 1.4 * line
    for row, cells, tall in zip(rows, blocks, heights, strict=True):
        ax.fill_between(
            [margin, width - margin], y, y + tall, color=_SHADES[row.verdict], edgecolor="white"
        )
        for texts, x in zip(cells, lefts, strict=True):
            ax.text(x + gap / 2, y + gap / 2, "\n".join(texts), fontsize=9, va="top")
        y += tall
    return figure
