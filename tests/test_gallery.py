"""The scripts of the gallery: each runs in seconds and ends in a legible picture."""

from __future__ import annotations

import ast
import runpy
import time
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

mpl.use("Agg")
from matplotlib import pyplot as plt

GALLERY = Path(__file__).parents[1] / "examples" / "gallery"
SCRIPTS = sorted(GALLERY.glob("*/*.py"))
SECONDS = 30
"""Processor time that a reader who runs a script should not have to wait longer for."""


def names_of(script: Path) -> str:
    return f"{script.parent.name}/{script.stem}"


def unlabelled(figure: Figure) -> list[str]:
    """Return what is missing on a picture: labels of axes, and anything drawn."""
    faults = []
    shown = [ax for ax in figure.axes if ax.axison]
    if not any(ax.get_xlabel() or figure.get_supxlabel() for ax in shown):
        faults.append("no axis says what is drawn to the right")
    faults += [f"axes {i} have no label at their side" for i, ax in enumerate(shown)
               if not (ax.get_ylabel() or figure.get_supylabel())]  # fmt: skip
    faults += [f"axes {i} are empty" for i, ax in enumerate(shown) if not ax.has_data()]
    return faults


def clipped(figure: Figure) -> list[str]:
    """Return texts of axes that lie outside the picture."""
    figure.canvas.draw()
    width, height = figure.get_size_inches() * figure.dpi
    texts = [t for ax in figure.axes for t in (ax.xaxis.label, ax.yaxis.label, ax.title)]
    found = []
    for text in texts:
        box = text.get_window_extent()
        inside = box.x0 > -1 and box.y0 > -1 and box.x1 < width + 1 and box.y1 < height + 1
        found += [] if inside or not text.get_text() else [text.get_text()]
    return found


def run(script: Path) -> list[Figure]:
    """Run a script as a reader would, and return its pictures."""
    plt.close("all")
    runpy.run_path(str(script), run_name="__main__")
    return [plt.figure(number) for number in plt.get_fignums()]


def test_every_door_has_scripts_and_a_header() -> None:
    doors = {"size", "sweep", "diagnose", "decide"}
    assert {script.parent.name for script in SCRIPTS} == doors
    assert all((GALLERY / door / "GALLERY_HEADER.rst").is_file() for door in doors)
    assert len(SCRIPTS) >= 12


@pytest.mark.parametrize("script", SCRIPTS, ids=names_of)
def test_a_script_says_what_it_shows(script: Path) -> None:
    text = script.read_text("utf-8")
    title, underline, blank, *words = (ast.get_docstring(ast.parse(text)) or "").splitlines()
    assert underline == "=" * len(title)
    assert blank == ""
    assert words
    assert text.rstrip().endswith("plt.show()")


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:FigureCanvasAgg is non-interactive")
@pytest.mark.parametrize("script", SCRIPTS, ids=names_of)
def test_a_script_ends_in_a_picture(script: Path) -> None:
    begun = time.process_time()
    figures = run(script)
    assert time.process_time() - begun < SECONDS
    assert figures
    for figure in figures:
        assert unlabelled(figure) == []
        assert clipped(figure) == []
        figure.canvas.draw()
        # A picture of one colour shows nothing.
        assert len(np.unique(np.asarray(figure.canvas.buffer_rgba())[..., :3])) > 2
    plt.close("all")


def test_planted_faults_of_pictures_are_found() -> None:
    figure, (above, below) = plt.subplots(2)
    above.plot([1, 2])
    above.set_ylabel("y")
    assert unlabelled(figure) == [
        "no axis says what is drawn to the right",
        "axes 1 have no label at their side",
        "axes 1 are empty",
    ]
    below.set_xlabel("x")
    below.xaxis.set_label_coords(0.5, -3.0)
    assert clipped(figure) == ["x"]
    plt.close(figure)
