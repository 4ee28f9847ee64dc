"""Cells of a sweep: values and statuses on any part of its grid, bits as in one call."""

from __future__ import annotations

import hashlib
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.registry import quantity
from locosweep.request import how
from locosweep.result import Output

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep._core import CancelToken
    from locosweep.grid import Grid
    from locosweep.request import Request

    Block = tuple[NDArray[Any], NDArray[np.uint8]]

NUMERICS_VERSION = 1
"""Raised with every change of a kernel that changes bits of a result."""
_PROBE_CELLS = 64
"""Cells whose bits a run remembers: ends and middles of the axes."""
_TIMED = 0.02
"""Seconds of evaluations that tell how long a cell takes."""


class Cells:
    """A request on a grid, of which any part can be evaluated.

    Attributes
    ----------
    request : Request
        What is computed.
    grid : Grid
        Axes and fixed values, the folded axis among them.
    dtype : str
        Type of the values.
    axes : dict of str to ndarray
        The axes of the result, in order.
    fixed : dict of str to float
        Every other parameter that has a value, defaults included.
    how : dict of str to str
        Law, drive, method and gait of what is simulated.

    Examples
    --------
    >>> import locosweep as ls
    >>> from locosweep.request import Request
    >>> from locosweep.run_folder.cells import Cells
    >>> grid = ls.Grid(mu_static=0.5, mu_coulomb=0.3, segments=range(2, 9))
    >>> cells = Cells(Request.of("mean_velocity"), grid, "float64")
    >>> (values, codes), = cells.block((slice(2, 4),), 1)
    >>> values.round(4), codes
    (array([0.0858, 0.0817]), array([0, 0], dtype=uint8))
    """

    def __init__(self, request: Request, grid: Grid, dtype: str) -> None:
        self.request = request
        self.grid = grid
        self.dtype = dtype
        job = request.job(grid.axes, grid.fixed)
        self.axes = {name: grid.axes[name] for name in job.axes}
        self.fixed = dict(job.fixed)
        self.how = how(job, request.table)

    @property
    def shape(self) -> tuple[int, ...]:
        """Cells along each axis of the result."""
        return tuple(len(axis) for axis in self.axes.values())

    @property
    def outputs(self) -> list[Output]:
        """Record of each output."""
        over = self.request.over
        return [Output.of(name, r, over) for name, r, _ in self.request.outputs]

    @property
    def bytes_per_cell(self) -> int:
        """Bytes of values and statuses of all outputs."""
        return (np.dtype(self.dtype).itemsize + 1) * len(self.request.outputs)

    @property
    def rivals(self) -> NDArray[np.float64] | None:
        """Values of the axis that is folded away."""
        return None if self.request.over is None else self.grid.axes[self.request.over]

    @property
    def points_per_cell(self) -> int:
        """Evaluations that a cell takes: of each output, along the folded axis."""
        return self._per_output * len(self.request.outputs)

    @property
    def _per_output(self) -> int:
        """Evaluations that one output of a cell takes."""
        return 1 if self.rivals is None else len(self.rivals)

    def values_at(
        self, key: Sequence[slice | NDArray[Any]], output: int, *, status: bool
    ) -> NDArray[Any]:
        """Return one output, or its statuses, where the indices of the axes cross."""
        shape = self._shape_of(key)
        array = np.empty(shape, np.uint8 if status else self.dtype)
        if array.size:
            self._run(key, [output], [(0, array)], _core.threads_to_use(), fresh=True)
        return array

    def block(
        self,
        key: Sequence[slice],
        threads: int,
        progress: Callable[[int, int, float], object] | None = None,
        token: CancelToken | None = None,
    ) -> list[Block]:
        """Return values and statuses of every output on one part of the grid."""
        kinds = [self._is_plain(i) for i in range(len(self.request.outputs))]
        plain = [i for i, is_plain in enumerate(kinds) if is_plain]
        other = [i for i, is_plain in enumerate(kinds) if not is_plain]
        shape = self._shape_of(key)
        blocks = [(np.empty(shape, self.dtype), np.empty(shape, np.uint8)) for _ in kinds]
        options: Any = {"progress": progress, "token": token}
        if plain:
            arrays = [(k, blocks[i][0]) for k, i in enumerate(plain)]
            self._run(key, plain, arrays, threads, fresh=True, **options)
        for i in plain:
            self._codes(key, i, *blocks[i], threads, token)
        if other:
            both = [(k, array) for k, i in enumerate(other) for array in blocks[i]]
            self._run(key, other, both, threads, **options)
        return blocks

    def _is_plain(self, output: int) -> bool:
        """Whether an output is a closed form, whose values cost less than its statuses."""
        return self.request.over is None and not quantity(self.request.outputs[output][0]).simulated

    def _codes(
        self,
        key: Sequence[slice],
        output: int,
        values: NDArray[Any],
        codes: NDArray[np.uint8],
        threads: int,
        token: CancelToken | None,
    ) -> None:
        """Fill in the statuses of a closed form."""
        # A value is NaN exactly where its status is not ok; where none is, all is said.
        if np.isnan(np.min(values)):
            self._run(key, [output], [(0, codes)], threads, token=token)
        else:
            codes.fill(0)

    def _shape_of(self, key: Sequence[slice | NDArray[Any]]) -> tuple[int, ...]:
        return tuple(len(axis[part]) for axis, part in zip(self.axes.values(), key, strict=True))

    def _run(
        self,
        key: Sequence[slice | NDArray[Any]],
        outputs: Sequence[int],
        arrays: Sequence[tuple[int, NDArray[Any]]],
        threads: int,
        **options: Any,
    ) -> None:
        """Fill arrays of some outputs on a part of the grid."""
        chosen = dict(zip(self.axes, key, strict=True))
        axes, fixed = {}, dict(self.grid.fixed)
        for name, axis in self.grid.axes.items():
            part = np.ascontiguousarray(axis[chosen[name]]) if name in chosen else axis
            # Kernels run along the last axis: one of a single value would leave their lanes idle.
            if len(part) == 1 and name in chosen:
                fixed[name] = float(part[0])
            else:
                axes[name] = part
        job = self.request.job(axes, fixed, outputs)
        job.run([(i, array.reshape(job.shape)) for i, array in arrays], threads, **options)

    def probe(self) -> str:
        """Hash the bits at some cells: another version that computes others is told by it."""
        digest = hashlib.sha256()
        axes = _spread(self.grid.axes, _PROBE_CELLS)
        job = self.request.job(axes, self.grid.fixed)
        for i in range(len(self.request.outputs)):
            values, codes = np.empty(tuple(job.shape)), np.empty(tuple(job.shape), np.uint8)
            job.run([(i, values), (i, codes)], 1)
            # A NaN has many bit patterns and one meaning.
            digest.update(np.where(np.isnan(values), np.nan, values).astype("<f8").tobytes())
            digest.update(codes.tobytes())
        return digest.hexdigest()

    def seconds_per_cell(self, threads: int) -> float:
        """Measure how long a cell takes, its folded axis included."""
        count = _PROBE_CELLS
        while True:
            axes = _spread(self.grid.axes, count)
            job = self.request.job(axes, self.grid.fixed)
            arrays = [(i, np.empty(tuple(job.shape))) for i in range(len(self.request.outputs))]
            begin = time.perf_counter()
            job.run(arrays, threads)
            taken = time.perf_counter() - begin
            done = int(np.prod([len(axis) for axis in axes.values()], dtype=object))
            if taken > _TIMED or count > 1 << 20 or done < count // 8:
                return taken / done * self._per_output
            count *= 8


def _spread(axes: Mapping[str, NDArray[np.float64]], most: int) -> dict[str, NDArray[np.float64]]:
    """Return ends and evenly spread values of the axes that give at most so many points."""
    counts = dict.fromkeys(axes, 1)
    grown = True
    while grown:
        grown = False
        for name, axis in axes.items():
            product = int(np.prod(list(counts.values()), dtype=object))
            if counts[name] < len(axis) and product // counts[name] * (counts[name] + 1) <= most:
                counts[name] += 1
                grown = True
    return {
        name: axis[np.linspace(0, len(axis) - 1, counts[name]).round().astype(np.intp)]
        for name, axis in axes.items()
    }
