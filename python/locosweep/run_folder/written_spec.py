"""The sweep file of a run: the same text for the same bits of axes and values, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.errors import InputError
from locosweep.request import Request
from locosweep.run_folder.cells import Cells
from locosweep.specs.simulation import Simulation
from locosweep.specs.span import Span
from locosweep.specs.sweep import Spec

if TYPE_CHECKING:
    from numpy.typing import NDArray

DRIVE = "drive.csv"
"""What a sweep file calls the samples of a drive, which the manifest holds beside it."""


def spec_of(cells: Cells) -> tuple[str, str | None]:
    """Return the sweep file of a request on a grid, the same for the same bits; and its drive."""
    request, grid = cells.request, cells.grid
    table = request.table
    spec = Spec(
        request.quantities,
        tuple((name, _axis(name, axis)) for name, axis in grid.axes.items()),
        tuple(sorted(grid.fixed.items())),
        request.over,
        request.reduce,
        request.q,
        cells.dtype,
        Simulation(
            request.law, request.drive, request.method, None if table is None else DRIVE,
            request.gait,
        ),
    )  # fmt: skip
    if table is None:
        return spec.to_toml(), None
    rows = zip(table[0].tolist(), table[1].tolist(), strict=True)
    return spec.to_toml(), "t,drive\n" + "".join(f"{t!r},{v!r}\n" for t, v in rows)


def _axis(name: str, axis: NDArray[np.float64]) -> Span | tuple[float, ...]:
    """Return the range that gives these bits, else the values."""
    span = Span(float(axis[0]), float(axis[-1]), len(axis))
    if len(axis) > 1 and np.isfinite(axis[[0, -1]]).all():
        try:
            if span.values(name).tobytes() == axis.tobytes():
                return span
        except InputError:
            pass
    return tuple(axis.tolist())


def cells_of(text: str, drive: str | None, source: str) -> Cells:
    """Return what a sweep file, and the samples of its drive as CSV, describe."""
    spec = Spec.from_toml(text, source=source)
    table = None
    if drive is not None:
        rows = [line.split(",") for line in drive.splitlines()[1:]]
        table = ([float(row[0]) for row in rows], [float(row[1]) for row in rows])
    return cells_of_spec(spec, table)


def cells_of_spec(spec: Spec, table: Any = None) -> Cells:
    """Return what a sweep file describes; without a table the drive file that it names is read."""
    chosen = spec.simulation
    if table is None:
        table = chosen.options()["table"]
    request = Request.of(
        spec.quantities, spec.reduce or None, q=spec.q, table=table, over=spec.over,
        law=chosen.law, drive=chosen.drive, gait=chosen.gait, method=chosen.method,
    )  # fmt: skip
    return Cells(request, spec.grid(), spec.dtype)
