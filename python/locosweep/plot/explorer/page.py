"""The explorer: one page on which a sweep is looked at, without network and without a server."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jinja2
import matplotlib as mpl
import numpy as np
from matplotlib.colors import to_hex

from locosweep import _core
from locosweep.engine import whole
from locosweep.errors import InputError
from locosweep.files.atomic import write_text
from locosweep.grid import index_of
from locosweep.plot import style
from locosweep.plot.caption import better_when_larger, fixed_values, reason
from locosweep.plot.explorer.cells import NOT_COMPUTED, chosen, packed, told
from locosweep.plot.explorer.commands import IMPORTS, calls, python_axis, shell_axis
from locosweep.registry import Status, parameter, unknown
from locosweep.result import Result

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from locosweep.result import Output
    from locosweep.run_folder.run import Run

    Axes = Mapping[str, NDArray[np.float64]]

LARGEST = 8_000_000
"""Bytes of a page: what mail servers let pass, and browsers open without a pause."""
_FRAME = 60_000
"""Bytes of a page without its cells and the values of its axes, with room."""
_NUMBER = 72
"""Bytes that a value of an axis takes: 17 digits, for the page, the shell and Python."""
_HEIGHT = 900
"""Pixels of a page in a notebook: a map with two sliders and its commands."""
_HERE = Path(__file__).parent


class Explorer:
    """A page that shows a sweep: a notebook displays it, `save` writes it.

    Attributes
    ----------
    html : str
        The page.
    """

    def __init__(self, html: str) -> None:
        self.html = html

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the page to a file that ends in ``.html``; a browser opens it by a double click."""
        path = Path(path)
        if path.suffix.lower() not in (".html", ".htm"):
            ends = f"cannot end in '{path.suffix}'" if path.suffix else "needs an ending"
            raise InputError(f"{path}: a page {ends}: allowed is .html")
        write_text(path, self.html)

    def __repr__(self) -> str:
        size = len(self.html) / 1e6
        return f'Explorer: a page of {size:.1f} MB, which .save("page.html") writes'

    def _repr_html_(self) -> str:
        # A document of its own: its styles and its script cannot touch those of the notebook.
        return (
            f'<iframe srcdoc="{escape(self.html, quote=True)}" title="explorer of a sweep" '
            f'style="width:100%;height:{_HEIGHT}px;border:1px solid #8888"></iframe>'
        )


def explorer(
    shown: Result | Run,
    *,
    limit: int = LARGEST,
    command: str | None = None,
    full: Axes | None = None,
    at: Mapping[str, float] | None = None,
) -> Explorer:
    """Return the page of a result or of a run folder.

    Parameters
    ----------
    shown : Result or Run
        What is shown. Of a run, only the cells that the page holds are read.
    limit : int
        Bytes that the page may have; cells are left out, evenly, where more are there.
    command : str, optional
        How the page was made.
    full : mapping of str to ndarray, optional
        All values of the axes, where `shown` is a part of a sweep already.
    at : mapping of str to float, optional
        By name of an axis, the value near which its slider stands first.

    Raises
    ------
    InputError
        Nothing was swept, an unknown axis in `at`, or the cells of a run cannot be read.
    """
    limit = whole("limit", limit) or LARGEST
    longer = [name for name, axis in shown.axes.items() if len(axis) > 1]
    if not longer or not all(shown.shape):
        raise InputError("nothing to explore: no axis has more than one value")
    index, kind = chosen(shown.axes, len(shown.outputs), _room(full or shown.axes, limit))
    result = _part(shown, index)
    start = _start(result)
    for name, wanted in (at or {}).items():
        if name not in result.axes:
            raise unknown("axis", name, result.axes)
        start[list(result.axes).index(name)] = index_of(
            name, result.axes[name], wanted, nearest=True
        )
    return Explorer(_page(result, kind, full or shown.axes, command, start))


def shown_of(axes: Axes, outputs: int, limit: int = LARGEST) -> dict[str, NDArray[np.float64]]:
    """Return the values of each axis that a page of so many outputs holds."""
    index, _ = chosen(axes, outputs, _room(axes, limit))
    return {name: axis[index[name]] for name, axis in axes.items()}


def _room(axes: Axes, limit: int) -> int:
    """Return the bytes of a page that are left for its cells."""
    return max(0, limit - _FRAME - _NUMBER * sum(map(len, axes.values())))


def _part(shown: Result | Run, index: Mapping[str, NDArray[np.intp]]) -> Result:
    """Return the chosen cells, in the order of their axes."""
    if isinstance(shown, Result):
        grid = np.ix_(*index.values())
        values = [shown[o.name][grid] for o in shown.outputs]
        codes = {o.name: _codes(shown, o.name)[grid] for o in shown.outputs}
        over, rivals, q, how = shown.over, shown.rivals, shown.q, shown.how
    else:
        values = [shown.read(o.name, index) for o in shown.outputs]
        codes = {o.name: shown.read(f"{o.name}_status", index) for o in shown.outputs}
        cells = shown.cells
        over, rivals, q, how = cells.request.over, cells.rivals, cells.request.q, cells.how
    axes = {name: axis[index[name]] for name, axis in shown.axes.items()}
    return Result(shown.outputs, axes, shown.fixed, values, over=over, rivals=rivals, q=q,
                  statuses=codes, how=how)  # fmt: skip


def _codes(result: Result, name: str) -> NDArray[np.uint8]:
    values = result[name]
    if np.isfinite(values).all():
        # Statuses are computed when they are asked for.
        return np.zeros(values.shape, np.uint8)
    return result.status_of(name)


def _page(result: Result, kind: str, full: Axes, command: str | None, start: list[int]) -> str:
    drawn = min(2, sum(len(axis) > 1 for axis in result.axes.values()))
    cells = {o.name: packed(result[o.name], result.status_of(o.name), kind) for o in result.outputs}
    outputs = [_output(result, o, drawn) | {"kind": kind, "lo": cells[o.name].low,
               "hi": cells[o.name].high,
               "both": style.both_signs(cells[o.name].low, cells[o.name].high)}
               for o in result.outputs]  # fmt: skip
    steps = [f"{(one.high - one.low) / 65503:.2g} {style.unit_text(o.unit)}".rstrip()
             for o, one in zip(result.outputs, cells.values(), strict=True)]  # fmt: skip
    statuses = {int(s): reason(result, s) for s in Status if s is not Status.OK}
    data = {
        "axes": [_axis(name, axis, full[name]) for name, axis in result.axes.items()],
        "outputs": outputs,
        "statuses": statuses | {NOT_COMPUTED: "not computed yet"},
        "colours": {"one": _colours(style.SEQUENTIAL), "both": _colours(style.DIVERGING)},
        "start": start,
        "imports": IMPORTS,
        "hint": "Point at a cell, or move over the map with the arrow keys: its value stands here. "
                "A click or Enter keeps a cell.",
    }  # fmt: skip
    fixed = {k: v for o in result.outputs for k, v in fixed_values(result, o, result.axes)}
    words = [f"{k} {style.with_unit(v, parameter(k).unit)}" for k, v in fixed.items()]
    words += [
        f"{name} {result.how[name]}" for name in ("law", "drive", "gait") if name in result.how
    ]
    if result.over is not None and result.rivals is not None and result.rivals.size:
        ends = (float(result.rivals.min()), float(result.rivals.max()))
        words.append(f"{result.over} from {ends[0]:g} to "
                     f"{style.with_unit(ends[1], parameter(result.over).unit)}")  # fmt: skip
    if result.q is not None:
        words.append(f"q {result.q:g}")
    script = script_of("canvas.js", "heat.js", "controls.js")
    return _template().render(
        title=_capital(", ".join(o.label for o in result.outputs)),
        fixed=f"Fixed: {', '.join(words)}." if words else "",
        outputs=outputs,
        flat=drawn < 2,
        notes=told(full, result.axes, kind, steps),
        version=_core.version(),
        command=command,
        style=(_HERE / "page.css").read_text(encoding="utf-8"),
        data=json_block(data),
        arrays=[one.text for one in cells.values()],
        script=script,
        digest=digest_of(script),
    )


def _start(result: Result) -> list[int]:
    """Return where sliders stand first: at the highest value if that is the best, else mid-way."""
    if better_when_larger(result.outputs[0]) and np.isfinite(result.values).any():
        best = np.unravel_index(np.nanargmax(result.values), result.shape)
        return [int(one) for one in best]
    return [length // 2 for length in result.shape]


def _axis(name: str, values: NDArray[np.float64], full: NDArray[np.float64]) -> dict[str, Any]:
    record = parameter(name)
    unit = style.unit_text(record.unit)
    words = style.words_of(name)
    # JSON has no infinity; JavaScript reads this text as one.
    shown = [repr(float(v)) if np.isfinite(v) else _infinity(v) for v in values]
    ordered = np.sort(full)
    return {
        "name": name, "words": words, "unit": unit, "integer": record.integer, "values": shown,
        "label": f"{words} [{unit}]" if unit else words,
        "shell": shell_axis(name, ordered), "python": python_axis(name, ordered),
    }  # fmt: skip


def _output(result: Result, output: Output, drawn: int) -> dict[str, Any]:
    unit = style.unit_text(output.unit)
    return {
        "words": output.label, "unit": unit, "integer": output.integer,
        "label": f"{output.label} [{unit}]" if unit else output.label,
        "best": better_when_larger(output), **calls(result, output, drawn),
    }  # fmt: skip


def _infinity(value: float) -> str:
    return "Infinity" if value > 0.0 else "-Infinity"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


@cache
def _colours(name: str) -> str:
    """Return 256 colours of a map as hexadecimal digits, without marks between."""
    return "".join(to_hex(c)[1:] for c in mpl.colormaps[name](np.linspace(0.0, 1.0, 256)))


def templates(package: str) -> jinja2.Environment:
    """Return the templates that stand beside the modules of a package; texts are escaped."""
    return jinja2.Environment(
        loader=jinja2.PackageLoader(package, "."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


@cache
def _template() -> jinja2.Template:
    return templates("locosweep.plot.explorer").get_template("page.html.jinja")


@cache
def script_of(*names: str) -> str:
    """Return scripts of this folder as one, whose names are its own."""
    parts = [(_HERE / name).read_text(encoding="utf-8") for name in names]
    return "(() => {\n" + "".join(parts) + "})();"


def digest_of(script: str) -> str:
    """Return the hash by which a page's policy allows its own script and no other."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")


def json_block(data: object) -> str:
    """Return JSON that cannot end the element of a page that it stands in."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")
