"""Saving pictures, with what they show in their metadata."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure

from locosweep import _core
from locosweep.errors import InputError
from locosweep.files.atomic import replacing

if TYPE_CHECKING:
    import os

    from matplotlib.figure import Figure

_DPI = 150
_KINDS = ("png", "svg", "pdf")


def save_figure(
    figure: Figure | Axes,
    path: str | os.PathLike[str],
    *,
    command: str | None = None,
    spec: str | None = None,
) -> None:
    """Write a picture; the same picture gives the same bytes.

    Parameters
    ----------
    figure : Figure or Axes
        What to save; for axes, the whole figure they are in.
    path : path-like
        Where; ends in ``.png``, ``.svg`` or ``.pdf``. Replaced in one step.
    command : str, optional
        How the picture was made, kept in its metadata.
    spec : str, optional
        ``locosweep.provenance.spec_hash`` of what it shows, kept likewise.

    Raises
    ------
    InputError
        Another ending, or a file that cannot be written.

    Examples
    --------
    >>> import locosweep as ls, tempfile, pathlib
    >>> from locosweep.plot.save import save_figure
    >>> r = ls.sweep("mean_velocity", mu_static=0.5, mu_coulomb=0.3, segments=range(2, 9))
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "speed.png"
    >>> save_figure(r.plot.curves("segments"), file, command="my_script.py")
    >>> file.read_bytes()[1:4]
    b'PNG'
    """
    path = Path(path)
    kind = path.suffix[1:].lower()
    if kind not in _KINDS:
        allowed = ", ".join(f".{k}" for k in _KINDS)
        ends = f"cannot end in '{path.suffix}'" if path.suffix else "needs an ending"
        raise InputError(f"{path}: a picture {ends}: allowed are {allowed}")
    root = figure.figure if isinstance(figure, Axes) else figure
    while isinstance(root, SubFigure):
        root = root.figure
    with replacing(path) as temporary, mpl.rc_context({"svg.hashsalt": "locosweep"}):
        root.savefig(temporary, format=kind, dpi=_DPI, metadata=_metadata(kind, command, spec))


def lay_out(figure: Figure) -> None:
    """Lay out a figure that is saved and then thrown away.

    Where an engine does so while it is saved, matplotlib draws all of it twice.
    """
    engine = figure.get_layout_engine()
    if engine is None:
        return
    figure.set_dpi(_DPI)
    engine.execute(figure)
    with mpl.rc_context({"figure.autolayout": False, "figure.constrained_layout.use": False}):
        figure.set_layout_engine(None)


def _metadata(kind: str, command: str | None, spec: str | None) -> dict[str, str | None]:
    software = f"locosweep {_core.version()}"
    given = {"Command": command, "Spec": spec}
    known = {key: value for key, value in given.items() if value}
    if kind == "png":
        return {"Software": software, **known}
    # Other keys are refused in SVG and PDF; a date would change the bytes.
    date = {"svg": "Date", "pdf": "CreationDate"}[kind]
    words = {"svg": "Description", "pdf": "Subject"}[kind]
    text = "; ".join(f"{key}: {value}" for key, value in known.items())
    return {"Creator": software, "Keywords": software, words: text or software, date: None}
