"""A run folder, opened: axes, statuses, parts as results, xarray and Polars."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from locosweep import memory
from locosweep.errors import InputError
from locosweep.grid import select
from locosweep.registry import Status, parameter, unknown
from locosweep.result import Output, Result
from locosweep.run_folder import arrays, manifest
from locosweep.run_folder.state import State, altered

if TYPE_CHECKING:
    from collections.abc import Mapping

    import polars as pl
    import xarray as xr
    from numpy.typing import NDArray

    from locosweep.plot.explorer.page import Explorer
    from locosweep.plot.run_folder import RunPlotter


class Run:
    """A sweep in a folder. Nothing but the manifest and the logs is read until it is asked for.

    Attributes
    ----------
    folder : Path
        The folder; it may be moved.
    axes : dict of str to ndarray
        The axes in order.
    fixed : dict of str to float
        Value of every other parameter that has one, defaults included.
    outputs : tuple of Output
        Name, quantity, reduction, unit and label of each output.
    state : State
        Which chunks are done, by whom, and which are damaged.
    """

    def __init__(
        self,
        folder: str | os.PathLike[str],
        *,
        allow_missing: bool = False,
        state: State | None = None,
    ) -> None:
        self.folder = Path(folder)
        self.allow_missing = allow_missing
        self.manifest = manifest.read(self.folder) if state is None else state.manifest
        self.cells = self.manifest.cells
        self.state = State(self.folder, self.manifest) if state is None else state
        self.axes = self.cells.axes
        self.fixed = self.cells.fixed
        self.outputs = tuple(self.cells.outputs)
        self._store: Any = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each axis."""
        return self.manifest.plan.shape

    @property
    def complete(self) -> bool:
        """Whether all chunks are done."""
        return self.state.done_count == self.manifest.plan.count

    @property
    def missing(self) -> list[int]:
        """Numbers of the chunks that are not computed, or damaged."""
        return self.state.missing

    def output(self, name: str | None = None) -> Output:
        """Return one output's record, by name; the first one without."""
        for output in self.outputs:
            if name in (None, output.name):
                return output
        raise unknown("output", str(name), [o.name for o in self.outputs])

    def status_counts(self, name: str | None = None) -> dict[Status, int]:
        """Count the cells of each status that occurs in the finished chunks; reads logs only."""
        name = self.output(name).name
        total: dict[str, int] = {}
        for known in self.state.done.values():
            for code, count in known[0].counts[name].items():
                total[code] = total.get(code, 0) + count
        return dict(sorted((Status(int(code)), count) for code, count in total.items()))

    @property
    def provenance(self) -> dict[str, Any]:
        """Return what made the run, from manifest and logs.

        ``spec_sha256``, ``numerics_version``, and ``writers``: for each log its name, the chunks
        that it has finished, and what it says of its version, SIMD level and threads.
        """
        writers = [
            {**w.about, "name": w.name, "chunks": sorted(one.chunk for one in w.done)}
            for w in self.state.writers
        ]
        return {"spec_sha256": self.manifest.spec_sha256,
                "numerics_version": self.manifest.numerics_version, "writers": writers}  # fmt: skip

    def summary(self) -> dict[str, Any]:
        """Describe outputs, axes and what is done, from manifest and logs, for JSON."""
        counts = {o.name: self.status_counts(o.name) for o in self.outputs}
        return {
            "outputs": [
                {"name": o.name, "label": o.label, "unit": o.unit,
                 "statuses": {s.name.lower(): n for s, n in counts[o.name].items()}}
                for o in self.outputs
            ],
            "axes": {
                name: {"count": len(axis), "first": float(axis[0]), "last": float(axis[-1])}
                for name, axis in self.axes.items()
            },
            "over": self.cells.request.over,
            "fixed": self.fixed,
            "chunks": {"all": self.manifest.plan.count, "done": self.state.done_count,
                       "damaged": len(self.state.damaged)},
        }  # fmt: skip

    def _check_whole(self) -> None:
        if self.state.damaged:
            chunk, what = next(iter(self.state.damaged.items()))
            raise InputError(altered(self.folder, chunk, what))
        if not (self.allow_missing or self.complete):
            count = self.manifest.plan.count
            raise InputError(
                f"{self.folder}: {len(self.missing)} of {count} chunks are not computed: the same "
                "sweep once more computes them, allow_missing=True opens the others"
            )

    @property
    def store(self) -> Any:
        """The Zarr store, which checks each chunk against its hash before it is used."""
        if self._store is None:
            self._check_whole()
            arrays.need("zarr")
            from locosweep.run_folder.verified_store import VerifiedStore

            self._store = VerifiedStore(str(self.folder), self.state)
        return self._store

    def array(self, name: str) -> Any:
        """Return a Zarr array: an output, or its statuses by the name NAME_status."""
        return arrays.need("zarr").open_array(self.store, path=name, mode="r")

    def to_xarray(self, chunks: Any = None) -> xr.Dataset:
        """Return an xarray Dataset that reads what is asked of it; `chunks` as in ``open_zarr``.

        Outputs have units; statuses are arrays ``NAME_status``, 255 where nothing was computed.
        """
        arrays.need("zarr")
        xr = arrays.need("xarray")
        found = xr.open_zarr(self.store, chunks=chunks, consolidated=True)
        # As of a result, and so that other formats take them: the store has them in one attribute.
        found.attrs = {**self.fixed, **self.cells.how}
        return found  # type: ignore[no-any-return]

    def to_result(self, **at: slice) -> Result:
        """Read the run, or the part of it between indices of its axes, as a `Result`.

        Parameters
        ----------
        **at
            By name of an axis, a slice of its indices.
        """
        for name in at:
            if name not in self.axes:
                raise unknown("axis", name, self.axes)
            if not isinstance(at[name], slice):
                raise InputError(f"{name} is {at[name]!r}: allowed is a slice of its indices")
        index = {n: np.arange(len(a))[at.get(n, slice(None))] for n, a in self.axes.items()}
        return self._result(index, {n: self.axes[n][some] for n, some in index.items()}, self.fixed)

    def sel(self, *, method: Literal["nearest"] | None = None, **at: Any) -> Result:
        """Read the part at some values of the axes, as `Result.sel` does; only its chunks are read.

        Parameters
        ----------
        method, **at
            As for `Result.sel`.

        Raises
        ------
        InputError
            An unknown axis or method, a value that does not stand in its axis, or a part that
            needs too much memory or is not computed as a whole.

        Examples
        --------
        >>> import locosweep as ls, tempfile, pathlib
        >>> folder = pathlib.Path(tempfile.mkdtemp()) / "run"
        >>> run = ls.sweep("mean_velocity", mu_static=[0.4, 0.5], mu_coulomb=0.3,
        ...                segments=range(2, 9), out=folder)
        >>> run.sel(mu_static=0.5, segments=[3, 4]).values.round(4)
        array([0.0873, 0.0858])
        """
        index, axes, fixed = select(self.axes, self.fixed, at, method)
        return self._result(dict(zip(self.axes, index, strict=True)), axes, fixed)

    def _result(
        self,
        index: Mapping[str, int | NDArray[np.intp]],
        axes: dict[str, NDArray[np.float64]],
        fixed: dict[str, float],
    ) -> Result:
        cells = int(np.prod([len(axis) for axis in axes.values()], dtype=object))
        memory.check(
            cells * self.cells.bytes_per_cell, None, "this part of the run", "read a smaller part"
        )
        values = [self.read(o.name, index) for o in self.outputs]
        codes = {o.name: self.read(f"{o.name}_status", index) for o in self.outputs}
        if any((code == arrays.NOT_COMPUTED).any() for code in codes.values()):
            raise InputError(f"{self.folder}: this part is not computed as a whole: read another")
        return Result(
            self.outputs, axes, fixed, values, over=self.cells.request.over,
            rivals=self.cells.rivals, q=self.cells.request.q, statuses=codes, how=self.cells.how,
        )  # fmt: skip

    def read(self, name: str, index: Mapping[str, int | NDArray[np.intp]]) -> NDArray[Any]:
        """Read cells of an array, as `array` names it, at indices of each axis.

        Only the chunks that hold them are read. A single index takes its axis away.
        """
        whole = [np.atleast_1d(one) for one in index.values()]
        # Zarr wants rising indices, and takes those that follow one another faster as a slice.
        rising = [_as_slice(np.sort(one)) for one in whole]
        found = np.asarray(self.array(name).oindex[tuple(rising)])
        back = [np.argsort(np.argsort(one, kind="stable"), kind="stable") for one in whole]
        if any((order[1:] < order[:-1]).any() for order in back):
            found = found[np.ix_(*back)]
        kept = tuple(slice(None) if np.ndim(one) else 0 for one in index.values())
        return np.asarray(found[kept], order="C")

    @property
    def plot(self) -> RunPlotter:
        """Pictures of this run, which read the cells that they draw."""
        from locosweep.plot.run_folder import RunPlotter

        return RunPlotter(self)

    def explore(self, *, limit: int | None = None, **at: float) -> Explorer:
        """Return a page on which the run is looked at, as `Result.explore` does.

        Only the cells that the page holds are read. With `allow_missing`, those that are not
        computed yet are hatched.
        """
        from locosweep.plot.explorer.page import LARGEST, explorer

        return explorer(self, limit=LARGEST if limit is None else limit, at=at)

    def scan(self) -> pl.LazyFrame:
        """Return a Polars LazyFrame of the long table: axis columns, outputs, statuses.

        Only the columns that a query asks for are read, chunk by chunk, in the order of the
        chunks. Cells that are not computed have no row.
        """
        from locosweep.run_folder.table import scan

        return scan(self)

    def to_polars(self) -> pl.DataFrame:
        """Return the long table, as `Result.to_polars` does, without cells not computed."""
        return self.to_result().to_polars() if self.complete else self.scan().collect()

    def __repr__(self) -> str:
        plan = self.manifest.plan
        lines = [f"Run of {', '.join(o.name for o in self.outputs)} in {self.folder}"]
        for name, axis in self.axes.items():
            span = f"{axis[0]:g} .. {axis[-1]:g}" if len(axis) > 1 else f"{axis[0]:g}"
            lines.append(f"  {name} [{parameter(name).unit}]: {len(axis)} values, {span}")
        lines.append(f"  {self.state.done_count} of {plan.count} chunks done")
        return "\n".join(lines)


def _as_slice(rising: NDArray[np.intp]) -> slice | NDArray[np.intp]:
    if rising.size and (np.diff(rising) == 1).all():
        return slice(int(rising[0]), int(rising[-1]) + 1)
    return rising


def open_run(folder: str | os.PathLike[str], *, allow_missing: bool = False) -> Run:
    """Open a run folder that ``sweep(..., out=FOLDER)`` fills or has filled.

    Parameters
    ----------
    folder : path-like
        The folder; it may have been moved.
    allow_missing : bool
        Also read a run that is not complete: NaN, and status 255, where nothing was computed.

    Returns
    -------
    Run

    Raises
    ------
    DataFileError
        No run folder, a manifest of another format, or altered; on reading, a chunk that was
        altered or is damaged.
    InputError
        On reading, chunks that are not computed without `allow_missing`.

    Examples
    --------
    >>> import locosweep as ls, tempfile, pathlib
    >>> folder = pathlib.Path(tempfile.mkdtemp()) / "run"
    >>> _ = ls.sweep("mean_velocity", mu_static=[0.4, 0.5], mu_coulomb=0.3,
    ...              segments=range(2, 9), out=folder)
    >>> run = ls.open_run(folder)
    >>> run.to_xarray()["mean_velocity"].sel(mu_static=0.5, segments=4).item() > 0
    True
    >>> {status.name: count for status, count in run.status_counts().items()}
    {'OK': 14}
    """
    return Run(folder, allow_missing=allow_missing)
