"""Grids as arrays of xarray, whose values are computed for the indices that are asked for."""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing

from locosweep import memory
from locosweep.registry import parameter
from locosweep.run_folder.plan import MOST_BYTES, cut
from locosweep.run_folder.written_spec import cells_of, cells_of_spec, spec_of
from locosweep.specs.sweep import Spec

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from locosweep.run_folder.cells import Cells

_FORMAT = b"locosweep.sweep/"
_HEAD = 4096
"""Bytes of a file in which a sweep file says what it is."""


class GridArray(BackendArray):
    """One output of a sweep, or its statuses, computed for the indices that are asked for.

    Attributes
    ----------
    shape : tuple of int
        Length of each axis.
    dtype : dtype
        Type of the values, uint8 of statuses.
    """

    def __init__(self, cells: Cells, output: int, *, status: bool) -> None:
        self._cells = cells
        self._output = output
        self._status = status
        self.shape = cells.shape
        self.dtype = np.dtype(np.uint8 if status else cells.dtype)

    def __reduce__(self) -> tuple[Any, ...]:
        # As text: a worker makes of it what it would make of a sweep file.
        return _array_of, (*spec_of(self._cells), self._output, self._status)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._at
        )

    def _at(self, key: tuple[Any, ...]) -> NDArray[Any]:
        """Return what lies where integers, slices and arrays of integers cross."""
        parts = [np.asarray([k]) if isinstance(k, int | np.integer) else k for k in key]
        counts = [
            len(range(*part.indices(n))) if isinstance(part, slice) else len(part)
            for part, n in zip(parts, self.shape, strict=True)
        ]
        size = int(np.prod(counts, dtype=object)) * self.dtype.itemsize
        memory.check(size, None, "this part of the grid", "take a smaller part (isel, sel)")
        if not size:
            values = np.empty(counts, self.dtype)
        else:
            values = self._cells.values_at(parts, self._output, status=self._status)
        dropped = [i for i, k in enumerate(key) if isinstance(k, int | np.integer)]
        return values.reshape([n for i, n in enumerate(counts) if i not in dropped])


def _array_of(text: str, drive: str | None, output: int, status: bool) -> GridArray:
    return GridArray(_shared(text, drive), output, status=status)


@lru_cache(maxsize=16)
def _shared(text: str, drive: str | None) -> Cells:
    """Return cells that all arrays of a grid share."""
    return cells_of(text, drive, "grid")


def dataset(cells: Cells) -> xr.Dataset:
    """Return a dataset of outputs, statuses and axes; nothing is computed yet."""
    dims = list(cells.axes)
    found: dict[str, Any] = {}
    plan = cut(cells.shape, MOST_BYTES // np.dtype(cells.dtype).itemsize)
    chunks = {"preferred_chunks": dict(zip(dims, plan.chunk, strict=True))}
    for i, output in enumerate(cells.outputs):
        for name, status in ((output.name, False), (f"{output.name}_status", True)):
            data = indexing.LazilyIndexedArray(GridArray(cells, i, status=status))
            about = {
                "units": "1" if status else output.unit,
                "long_name": f"status of {output.label}" if status else output.label,
            }
            found[name] = xr.Variable(dims, data, about, chunks)
    coordinates = {}
    for name, axis in cells.axes.items():
        record = parameter(name)
        about = {"units": record.unit, "long_name": record.meaning}
        coordinates[name] = xr.Variable((name,), axis, about)
    return xr.Dataset(found, coordinates, {**cells.fixed, **cells.how})


class LocosweepBackend(BackendEntrypoint):
    """What makes ``xarray.open_dataset("sweep.toml", engine="locosweep")`` work."""

    description = "Open sweep files of locosweep; values are computed where they are needed"
    open_dataset_parameters = ("filename_or_obj", "drop_variables")
    supports_groups = False

    def open_dataset(
        self, filename_or_obj: Any, *, drop_variables: str | Iterable[str] | None = None
    ) -> xr.Dataset:
        """Open a sweep file as `open_grid` does."""
        found = dataset(cells_of_spec(Spec.load(filename_or_obj)))
        return found if drop_variables is None else found.drop_vars(drop_variables)

    def guess_can_open(self, filename_or_obj: Any) -> bool:
        """Whether a file says that it is a sweep file."""
        if not isinstance(filename_or_obj, str | os.PathLike):
            return False
        path = Path(filename_or_obj)
        if path.suffix != ".toml":
            return False
        try:
            with path.open("rb") as file:
                return _FORMAT in file.read(_HEAD)
        except OSError:
            return False
