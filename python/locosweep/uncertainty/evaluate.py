"""A quantity at points that were drawn, in every cell of a grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core, memory
from locosweep.engine import whole
from locosweep.errors import InputError
from locosweep.grid import Grid
from locosweep.progress import progress_of
from locosweep.request import Request, how

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from locosweep._core import CancelToken
    from locosweep.progress import Progress

    Floats = NDArray[np.float64]

CHOICE = ("law", "drive", "gait", "method", "table")
"""Options of a sweep that say how a quantity is simulated."""


@dataclass(frozen=True)
class Running:
    """How a computation runs, as in `locosweep.sweep`."""

    threads: int | None = None
    memory_limit: int | None = None
    progress: bool | Progress | None = None
    token: CancelToken | None = None


@dataclass(frozen=True, eq=False)
class Evaluated:
    """Values and status codes, shape (axes of the grid, points), and what the rest was."""

    values: Floats
    status: NDArray[np.uint8]
    fixed: dict[str, float]
    how: dict[str, str]


def split(known: Mapping[str, Any], names: set[str]) -> tuple[Grid, dict[str, Any]]:
    """Part the grid from the choice of a simulation; refuse what is given twice."""
    choice = {name: value for name, value in known.items() if name in CHOICE}
    given = {name: value for name, value in known.items() if name not in CHOICE}
    for name in names & set(given):
        raise InputError(f"{name} is given twice: as unknown and beside it")
    own = getattr(given.get("robot"), "parameters", None)
    if isinstance(own, dict):
        # What is unknown of a robot goes before its file.
        del given["robot"]
        given = {name: value for name, value in own.items() if name not in names} | given
    return Grid(**given), choice


def evaluate(
    quantity: str,
    grid: Grid,
    sample: Mapping[str, Floats],
    choice: Mapping[str, Any],
    running: Running,
) -> Evaluated:
    """Return a quantity in all cells of a grid, at all points of a sample."""
    if not isinstance(quantity, str):
        raise InputError(f"quantity is {quantity!r}: allowed is one name")
    request = Request.of(quantity, **choice)
    job = request.job(grid.axes, grid.fixed, sample=sample)
    count = _core.threads_to_use(whole("threads", running.threads))
    shape = tuple(job.shape)
    cells = int(np.prod(shape, dtype=object))
    memory.check(9 * cells + job.working_bytes(count), running.memory_limit, "the sample")
    values, codes = np.empty(shape), np.empty(shape, np.uint8)
    meter = progress_of(running.progress, quantity)
    job.run([(0, values), (0, codes)], count, None, meter, running.token, None, fresh=True)
    return Evaluated(values, codes, dict(job.fixed), how(job, request.table))
