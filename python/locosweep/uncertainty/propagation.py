"""Forward uncertainty: how a quantity is distributed when parameters are."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import stats

from locosweep.errors import InputError
from locosweep.grid import select
from locosweep.registry import Status, quantity
from locosweep.result import Output, for_pandas
from locosweep.uncertainty.evaluate import Running, evaluate, split
from locosweep.uncertainty.unknowns import points, power_of_two, sequence, unknowns, whole_seed

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import pandas as pd
    import polars as pl
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray

    from locosweep._core import CancelToken
    from locosweep.progress import Progress

    Floats = NDArray[np.float64]

QUANTILES = (0.05, 0.5, 0.95)
"""Those that tables and pictures show."""
_CONFIDENCE = 0.95
_COMPARISONS = {">=": np.greater_equal, "<=": np.less_equal, ">": np.greater, "<": np.less}


@dataclass(frozen=True)
class Need:
    """What a quantity has to meet: a comparison and a number."""

    comparison: str
    bound: float

    @classmethod
    def of(cls, text: str) -> Need:
        """Read ``">= 0.01"``."""
        found = re.fullmatch(r"\s*(>=|<=|>|<)\s*(\S+)\s*", str(text))
        try:
            need = cls(found[1], float(found[2]))  # type: ignore[index]
        except (TypeError, ValueError):
            need = None
        if need is None or not math.isfinite(need.bound):
            raise InputError(
                f"need is {text!r}: allowed is >=, <=, > or < and a number, such as '>= 0.01'"
            )
        return need

    def met(self, values: Floats) -> NDArray[np.bool_]:
        """Return which values meet it; none that is missing does."""
        met: NDArray[np.bool_] = _COMPARISONS[self.comparison](values, self.bound)
        return met

    def __str__(self) -> str:
        return f"{self.comparison} {self.bound:g}"


class Propagation:
    """Values of a quantity at points drawn from what is unknown, in every cell of a grid.

    Attributes
    ----------
    output : Output
        Name, unit and label of the quantity.
    axes : dict of str to ndarray
        Axes of the grid, in order: designs to compare.
    fixed : dict of str to float
        Every other parameter that is known, defaults included.
    points : dict of str to ndarray, shape (samples,)
        The unknown parameters at each point: the same points in every cell.
    values : ndarray, shape (axes, samples)
        The quantity; NaN exactly where `status` is not 0.
    status : ndarray of uint8, shape (axes, samples)
        Status codes (see ``locosweep.Status``).
    need : Need or None
        What the quantity has to meet.
    how : dict of str to str
        Law, drive, method and gait of what was simulated.
    """

    def __init__(
        self,
        output: Output,
        axes: Mapping[str, Floats],
        fixed: Mapping[str, float],
        points: Mapping[str, Floats],
        values: Floats,
        status: NDArray[np.uint8],
        need: Need | None,
        how: Mapping[str, str],
    ) -> None:
        self.output = output
        self.axes, self.fixed, self.points = dict(axes), dict(fixed), dict(points)
        self.values, self.status, self.need, self.how = values, status, need, dict(how)

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each axis of the grid."""
        return self.values.shape[:-1]

    @property
    def samples(self) -> int:
        """Number of points."""
        return int(self.values.shape[-1])

    @property
    def with_value(self) -> Floats:
        """Share of the points that have a value, in each cell."""
        return self._by_cell(lambda row: np.isfinite(row).mean())

    @property
    def mean(self) -> Floats:
        """Mean of the points that have a value; NaN where none has."""
        return self._by_cell(lambda row: _mean(row[np.isfinite(row)]))

    def quantile(self, q: ArrayLike) -> Floats:
        """Return quantiles, in which a point without a value counts as the worst.

        Parameters
        ----------
        q : array_like
            Shares of the points, from 0 to 1.

        Returns
        -------
        ndarray, shape (q, axes)
            NaN where a quantile falls among the points without a value.
        """
        wanted = np.asarray(q, np.float64)
        if not ((wanted >= 0.0) & (wanted <= 1.0)).all():
            raise InputError(f"q is {q!r}: allowed is 0 to 1")
        worst = -np.inf if quantity(self.output.name).larger_is_better else np.inf

        def quantiles(row: Floats) -> Floats:
            whole = np.where(np.isfinite(row), row, worst)
            found: Floats = np.quantile(whole, wanted, method="inverted_cdf")
            return np.where(np.isfinite(found), found, np.nan)

        rows, cells = self._by_cell(quantiles), len(self.shape)
        return rows.transpose(*range(cells, rows.ndim), *range(cells))

    @property
    def share(self) -> Floats:
        """Share of the points that meet the need, in each cell; those without a value do not."""
        asked = self._asked()
        return self._by_cell(lambda row: asked.met(row).mean())

    @property
    def share_interval(self) -> Floats:
        """Interval of `share` at 95 % confidence, shape (2, axes), after Clopper and Pearson.

        That of independent points: those of a Sobol sequence mostly lie closer.
        """
        met = np.round(self.share * self.samples)
        tail, count = (1.0 - _CONFIDENCE) / 2.0, self.samples
        low = stats.beta.ppf(tail, met, count - met + 1)
        high = stats.beta.ppf(1.0 - tail, met + 1, count - met)
        return np.array([np.where(met == 0, 0.0, low), np.where(met == count, 1.0, high)])

    def _by_cell(self, of: Callable[[Floats], Any]) -> Floats:
        """Return a number, or several, of each cell's points: one cell after the other."""
        rows = np.array([of(row) for row in self.values.reshape(-1, self.samples)], np.float64)
        return rows.reshape((*self.shape, *rows.shape[1:]))

    def _asked(self) -> Need:
        if self.need is None:
            raise InputError("need is missing: give propagate a need, such as need='>= 0.01'")
        return self.need

    def statuses(self) -> dict[Status, int]:
        """Count the points of each status that occurs, over all cells."""
        counts = np.bincount(self.status.ravel(), minlength=1)
        return {Status(code): int(n) for code, n in enumerate(counts) if n}

    def _why(self) -> list[str]:
        """Name the most frequent reason for which points of each cell have no value."""
        rows = self.status.reshape(-1, self.samples)
        counts = [np.bincount(row, minlength=2) for row in rows]
        return [
            Status(int(row[1:].argmax()) + 1).name.lower() if row[1:].any() else ""
            for row in counts
        ]

    def sel(self, *, method: str | None = None, **at: Any) -> Propagation:
        """Return the part at some values of the grid's axes, as `Result.sel` does."""
        index, axes, fixed = select(self.axes, self.fixed, at, method)
        values, status = self.values, self.status
        for dimension in reversed(range(len(index))):
            values = np.take(values, index[dimension], axis=dimension)
            status = np.take(status, index[dimension], axis=dimension)
        return Propagation(
            self.output, axes, fixed, self.points, values, status, self.need, self.how
        )

    def to_polars(self) -> pl.DataFrame:
        """Return a table, a row a cell: axes, mean, quantiles, shares, the commonest failure."""
        import polars as pl

        columns: dict[str, Any] = {}
        grids = np.meshgrid(*self.axes.values(), indexing="ij") if self.axes else []
        for name, grid in zip(self.axes, grids, strict=True):
            columns[name] = grid.ravel()
        columns["mean"] = self.mean.ravel()
        for q, values in zip(QUANTILES, self.quantile(QUANTILES), strict=True):
            columns[f"quantile_{q:g}"] = values.ravel()
        columns["with_value"] = self.with_value.ravel()
        if self.need is not None:
            columns["share"] = self.share.ravel()
            low, high = self.share_interval
            columns["share_low"], columns["share_high"] = low.ravel(), high.ravel()
        columns["without_value"] = self._why()
        return pl.DataFrame(columns).fill_nan(None)

    def to_pandas(self) -> pd.DataFrame:
        """Return the table of `to_polars` for pandas; needs the extra ``pandas``."""
        return for_pandas(self.to_polars())

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Values, as ``np.asarray`` asks for them: shape (axes, samples)."""
        return np.array(self.values, dtype=dtype, copy=copy)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the distribution: as a histogram, or its quantiles along the only axis of the grid.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; default the current axes of pyplot while they are empty.

        Raises
        ------
        InputError
            More than one axis: take one by `sel`.
        """
        from locosweep.uncertainty.picture import distribution

        return distribution(self, ax)

    def __repr__(self) -> str:
        unit = "" if self.output.unit == "1" else f" {self.output.unit}"
        lines = [f"{self.output.label} at {self.samples} points of {', '.join(self.points)}"]
        for name, axis in self.axes.items():
            lines.append(f"  {name}: {len(axis)} values, {axis[0]:g} .. {axis[-1]:g}")
        lines.append(f"  with a value: {_span(100.0 * self.with_value, ' %')} of the points")
        for status, number in self.statuses().items():
            if status:
                lines.append(f"    {number} without: {status.sentence}")
        for q, values in zip(QUANTILES, self.quantile(QUANTILES), strict=True):
            lines.append(f"  quantile {q:g}: {_span(values, unit)}")
        if self.need is not None:
            lines.append(f"  {self.need}{unit}: {_span(100.0 * self.share, ' %')} of the points")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from locosweep.plot.html import card
        from locosweep.uncertainty.picture import small

        return card(repr(self), small(self))


def too_many(axes: Mapping[str, Any]) -> InputError:
    """Return what is said of a picture of a distribution over more than one axis."""
    names = ", ".join(axes)
    return InputError(f"a picture of {len(axes)} axes, {names}, is asked for: allowed is one")


def _mean(values: Floats) -> float:
    return float(values.mean()) if values.size else np.nan


def _span(values: Floats, unit: str) -> str:
    known = values[np.isfinite(values)]
    if not known.size:
        return "none"
    low, high = float(known.min()), float(known.max())
    return (f"{low:.4g}" if low == high else f"{low:.4g} .. {high:.4g}") + unit


def propagate(
    quantity: str,
    unknown: Mapping[str, Any],
    *,
    need: str | None = None,
    samples: int = 2**14,
    seed: int = 0,
    threads: int | None = None,
    memory_limit: int | None = None,
    progress: bool | Progress | None = None,
    token: CancelToken | None = None,
    **known: Any,
) -> Propagation:
    """Evaluate a quantity at points drawn from what is not known, in every cell of a grid.

    Parameters
    ----------
    quantity : str
        A name from ``locosweep.quantities()``.
    unknown : mapping of str to distribution
        By name of the parameter, or ``"a/b"`` for the ratio of parameter `a` to parameter `b`. A
        distribution is a text, ``"0.2:0.6"`` (equally likely between two bounds),
        ``"normal:MEAN:DEVIATION"``, ``"lognormal:MEDIAN:FACTOR"`` or
        ``"triangular:LOW:MODE:HIGH"``; two numbers, its bounds; more numbers, equally likely
        values such as measured ones; or a distribution of ``scipy.stats``. It is truncated to the
        range of its parameter. The parameters are independent of one another.
    need : str, optional
        What the quantity has to meet, such as ``">= 0.01"`` (SI units).
    samples : int
        Points, a power of two; the same ones in every cell, from a scrambled Sobol sequence.
    seed : int
        Of the scrambling.
    threads, memory_limit, progress, token
        As in `sweep`.
    **known
        Parameters that are known, as in `Grid`: numbers, and sequences as axes of designs to
        compare; law, drive, gait, method and table as in `sweep`.

    Returns
    -------
    Propagation

    Raises
    ------
    InputError
        Names, distributions or numbers that are not allowed, or more memory than there is.
    Cancelled
        The token was used.

    Examples
    --------
    >>> import locosweep as ls
    >>> friction = {"mu_static": "0.4:0.6", "mu_coulomb/mu_static": "0.5:0.9"}
    >>> p = ls.propagate("mean_velocity", friction, need=">= 0.06", segments=[3, 6, 12],
    ...                  slope_deg=5, stroke=0.02, samples=1024)
    >>> p.share.round(2).tolist()
    [0.7, 0.84, 0.0]
    """
    found = unknowns(unknown)
    asked = None if need is None else Need.of(need)
    count = power_of_two("samples", samples)
    grid, choice = split(known, {one.name for one in found})
    for one in found:
        if one.share_of in grid.axes:
            raise InputError(f"unknown {one.key!r}: {one.share_of} is an axis, allowed is a number")
    chances = sequence(len(found), count, whole_seed(seed))
    sample = points(found, chances, grid.fixed)
    running = Running(threads, memory_limit, progress, token)
    made = evaluate(quantity, grid, sample, choice, running)
    output = Output.of(quantity, None, None)
    return Propagation(
        output, grid.axes, made.fixed, sample, made.values, made.status, asked, made.how
    )
