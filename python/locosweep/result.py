"""Result of a sweep: values with their axes, statuses, frames, files, plots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from locosweep import _core, memory
from locosweep.errors import InputError
from locosweep.grid import select
from locosweep.registry import Status, parameter, quantity, unknown, words_of_name

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping, Sequence

    import pandas as pd
    import polars as pl
    import xarray as xr
    from numpy.typing import NDArray

    from locosweep.plot.explorer.page import Explorer
    from locosweep.plot.heatmap import Plotter


OF_AXIS = ("argmax", "argmin", "last_feasible")
"""Reductions that give a value of the axis that they fold away."""


@dataclass(frozen=True)
class Output:
    """One output of a sweep: a quantity, or a reduction of it."""

    name: str
    quantity: str
    reduce: str | None
    unit: str
    symbol: str
    label: str
    integer: bool

    @classmethod
    def of(cls, name: str, reduce: str | None, over: str | None) -> Output:
        """Name, unit and label from the registry."""
        info = quantity(name)
        words = words_of_name(name)
        if reduce is None or over is None:
            return cls(name, name, None, info.unit, info.symbol, words, info.integer)
        axis = parameter(over)
        full = f"{name}_{reduce}"
        along = words_of_name(over)
        if reduce in OF_AXIS:
            which = {"argmax": "highest", "argmin": "lowest"}.get(reduce, "last feasible")
            label = f"{along} of {which} {words}"
            return cls(full, name, reduce, axis.unit, axis.symbol, label, axis.integer)
        if reduce == "count":
            return cls(full, name, reduce, "1", "n", f"feasible {along}", True)
        label = f"{reduce} {words} over {along}"
        # The highest of whole numbers is one; their mean is none.
        whole = info.integer and reduce in ("max", "min")
        return cls(full, name, reduce, info.unit, info.symbol, label, whole)


def for_pandas(table: pl.DataFrame) -> pd.DataFrame:
    """Return a table of Polars for pandas, words of a fixed list as categories."""
    try:
        import pandas as pd
    except ModuleNotFoundError:
        raise InputError("to_pandas needs pandas: pip install '.[pandas]' in a clone") from None
    import polars as pl

    columns: dict[str, Any] = {}
    for series in table:
        if series.dtype == pl.Enum:
            words = series.dtype.categories.to_list()  # type: ignore[attr-defined]
            codes = series.to_physical().to_numpy()
            columns[series.name] = pd.Categorical.from_codes(codes, categories=words)
        else:
            columns[series.name] = series.to_numpy()
    return pd.DataFrame(columns)


class Result:
    """Values of a sweep, one axis per swept parameter, in order.

    Attributes
    ----------
    values : ndarray
        Values of the first output; NaN exactly where `status` is not 0.
    status : ndarray of uint8
        Status codes of the first output (see ``locosweep.Status``), computed
        when first asked for.
    axes : dict of str to ndarray
        The axes in order.
    fixed : dict of str to float
        Value of every other parameter that has one, defaults included.
    over, rivals, q : str, ndarray, float or None
        The reduced axis, its values, and which quantile.
    outputs : tuple of Output
        Name, quantity, reduction, unit and label of each output.

    Examples
    --------
    >>> import locosweep as ls
    >>> r = ls.sweep("mean_velocity", mu_static=0.5, mu_coulomb=0.3, segments=4,
    ...              slope_deg=[0, 10, 30])
    >>> r.values.round(4)
    array([0.0858, 0.0547,    nan])
    >>> [ls.Status(code).name for code in r.status]
    ['OK', 'OK', 'SLIDES_BACK']
    """

    def __init__(
        self,
        outputs: Sequence[Output],
        axes: Mapping[str, NDArray[np.float64]],
        fixed: Mapping[str, float],
        values: Sequence[NDArray[Any]],
        *,
        over: str | None = None,
        rivals: NDArray[np.float64] | None = None,
        q: float | None = None,
        job: _core.Sweep | None = None,
        statuses: Mapping[str, NDArray[np.uint8]] | None = None,
        how: Mapping[str, str] | None = None,
    ) -> None:
        self.outputs = tuple(outputs)
        self.axes = dict(axes)
        self.fixed = dict(fixed)
        self.over = over
        self.rivals = rivals
        self.q = q
        self._values = {o.name: v for o, v in zip(outputs, values, strict=True)}
        self._statuses = dict(statuses or {})
        self._job = job
        self.how = dict(how or {})

    @property
    def name(self) -> str:
        """Name of the first output."""
        return self.outputs[0].name

    @property
    def unit(self) -> str:
        """Unit of the first output."""
        return self.outputs[0].unit

    @property
    def values(self) -> NDArray[Any]:
        """Values of the first output."""
        return self._values[self.name]

    @property
    def status(self) -> NDArray[np.uint8]:
        """Status codes of the first output."""
        return self.status_of(self.name)

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each axis."""
        return tuple(len(values) for values in self.axes.values())

    @property
    def plot(self) -> Plotter:
        """Pictures of this result."""
        from locosweep.plot.heatmap import Plotter

        return Plotter(self)

    def explore(self, *, limit: int | None = None, **at: float) -> Explorer:
        """Return a page with the map of any two axes, sliders for the others, values to point at.

        A notebook displays it; ``.save("page.html")`` writes it. It needs no network.

        Parameters
        ----------
        limit : int, optional
            Bytes that the page may have, default 8 MB. Where more cells are there, values are
            rounded to 16 bits, then evenly chosen along the longest axes; the page says so.
        **at
            By name of an axis, the value near which its slider stands first; default where
            the first output is best.

        Raises
        ------
        InputError
            No axis has more than one value, an unknown axis, or a limit too small for any cells.

        Examples
        --------
        >>> import locosweep as ls
        >>> r = ls.sweep("mean_velocity", mu_static=0.5, mu_coulomb=0.3,
        ...              slope_deg=[0, 10, 20], segments=range(2, 9))
        >>> "mean velocity" in r.explore().html
        True
        """
        from locosweep.plot.explorer.page import LARGEST, explorer

        return explorer(self, limit=LARGEST if limit is None else limit, at=at)

    def output(self, name: str | None = None) -> Output:
        """Return one output's record, by name; the first one without."""
        for output in self.outputs:
            if name in (None, output.name):
                return output
        raise unknown("output", str(name), self._values)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Values of an output by name."""
        return self._values[self.output(name).name]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Values of the only output, as ``np.asarray`` asks for them."""
        if len(self.outputs) > 1:
            names = ", ".join(f"result['{o.name}']" for o in self.outputs)
            raise InputError(f"this result has {len(self.outputs)} outputs: take one, {names}")
        return np.array(self.values, dtype=dtype, copy=copy)

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy or another process needs; statuses cannot be computed there."""
        for output in self.outputs:
            self.status_of(output.name)
        return {**vars(self), "_job": None}

    def sel(self, *, method: Literal["nearest"] | None = None, **at: Any) -> Result:
        """Return the part of this result at some values of its axes.

        Parameters
        ----------
        method : {None, "nearest"}
            None takes values as they stand in the axis; "nearest" the nearest of the axis.
        **at
            By name of an axis: a number takes the axis away, and stands in ``fixed``
            then; a sequence keeps these values, in its order.

        Returns
        -------
        Result
            Copies, with all outputs and their statuses.

        Raises
        ------
        InputError
            An unknown axis or method, or a value that does not stand in its axis.

        Examples
        --------
        >>> import locosweep as ls
        >>> r = ls.sweep("mean_velocity", mu_static=0.5, mu_coulomb=0.3,
        ...              slope_deg=[0, 10, 20], segments=range(2, 9))
        >>> some = r.sel(slope_deg=10, segments=[3, 4])
        >>> some.values.round(4), some.fixed["slope_deg"]
        (array([0.0428, 0.0547]), 10.0)
        >>> r.sel(slope_deg=9.2, method="nearest").fixed["slope_deg"]
        10.0
        """
        index, axes, fixed = select(self.axes, self.fixed, at, method)

        # One axis after the other, the last first, so that a dropped one shifts none before it.
        def part(array: NDArray[Any]) -> NDArray[Any]:
            for dimension in reversed(range(len(index))):
                array = np.take(array, index[dimension], axis=dimension)
            return np.asarray(array, order="C")

        statuses = {o.name: part(self.status_of(o.name)) for o in self.outputs}
        values = [part(self[o.name]) for o in self.outputs]
        return Result(self.outputs, axes, fixed, values, over=self.over, rivals=self.rivals,
                      q=self.q, statuses=statuses, how=self.how)  # fmt: skip

    def status_of(self, name: str) -> NDArray[np.uint8]:
        """Status codes of an output by name."""
        name = self.output(name).name
        if name not in self._statuses:
            if self._job is None:
                raise InputError(f"the statuses of {name} are not in this result")
            codes = np.empty(self.shape, np.uint8)
            memory.check(codes.nbytes, None, "the status array")
            index = [o.name for o in self.outputs].index(name)
            self._job.run([(index, codes)], _core.threads_to_use())
            self._statuses[name] = codes
        return self._statuses[name]

    def status_counts(self, name: str | None = None) -> dict[Status, int]:
        """Count the cells of each status that occurs."""
        codes = self.status_of(self.output(name).name)
        counts = np.bincount(codes.ravel(), minlength=1)
        return {Status(code): int(n) for code, n in enumerate(counts) if n}

    def to_polars(self) -> pl.DataFrame:
        """Return a long table: axis columns, then each output with its status."""
        import polars as pl

        cells = int(np.prod(self.shape, dtype=object))
        width = 8 * len(self.axes) + 12 * len(self.outputs)
        memory.check(cells * width, None, "the table")
        columns: dict[str, Any] = {}
        for dimension, (name, axis) in enumerate(self.axes.items()):
            view = axis.reshape([-1 if i == dimension else 1 for i in range(len(self.axes))])
            columns[name] = np.broadcast_to(view, self.shape).ravel()
        names = [status.name.lower() for status in Status]
        words = pl.Series(names, dtype=pl.Enum(names))
        for output in self.outputs:
            columns[output.name] = self[output.name].ravel()
            codes = pl.Series(self.status_of(output.name).ravel())
            # Gathered: Polars 2 does not cast numbers to an Enum.
            label = "status" if len(self.outputs) == 1 else f"{output.name}_status"
            columns[label] = words.gather(codes)
        return pl.DataFrame(columns)

    def to_pandas(self) -> pd.DataFrame:
        """Return the table of `to_polars` for pandas; needs the extra ``pandas``."""
        return for_pandas(self.to_polars())

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """Hand the table of `to_polars` to any library that speaks Arrow."""
        return self.to_polars().__arrow_c_stream__(requested_schema)

    def to_xarray(self) -> xr.Dataset:
        """Return an xarray Dataset with units; needs the extra ``xarray``."""
        try:
            import xarray as xr
        except ModuleNotFoundError:
            raise InputError("to_xarray needs xarray: pip install '.[xarray]' in a clone") from None
        dims = list(self.axes)
        data = {}
        for output in self.outputs:
            attributes = {"units": output.unit, "long_name": output.label}
            data[output.name] = (dims, self[output.name], attributes)
            attributes = {"units": "1", "long_name": f"status of {output.label}"}
            data[f"{output.name}_status"] = (dims, self.status_of(output.name), attributes)
        coords = {
            name: (
                name,
                axis,
                {"units": parameter(name).unit, "long_name": parameter(name).meaning},
            )
            for name, axis in self.axes.items()
        }
        return xr.Dataset(data, coords, attrs={**self.fixed, **self.how})

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the long table to a Parquet file that `load` reads back exactly."""
        from locosweep.files.results import save_result

        save_result(self, path)

    def __repr__(self) -> str:
        lines = [f"Result of {', '.join(o.name for o in self.outputs)}"]
        for name, axis in self.axes.items():
            span = f"{axis[0]:g} .. {axis[-1]:g}" if len(axis) > 1 else f"{axis[0]:g}"
            lines.append(f"  {name} [{parameter(name).unit}]: {len(axis)} values, {span}")
        for output in self.outputs:
            values = self[output.name]
            works = np.isfinite(values)
            if works.any():
                low, high = (
                    np.min(values, where=works, initial=np.inf),
                    np.max(values, where=works, initial=-np.inf),
                )
                span = f"{low:.6g}" if low == high else f"{low:.6g} .. {high:.6g}"
                unit = "" if output.unit == "1" else f" {output.unit}"
                text = span + unit
                if self.axes:
                    text += f", {works.mean():.1%} of the cells"
            else:
                text = "no cell has a value"
            q = f" ({self.q:g})" if output.reduce == "quantile" else ""
            lines.append(f"  {output.label}{q}: {text}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from locosweep.plot.html import result_card

        return result_card(self)
