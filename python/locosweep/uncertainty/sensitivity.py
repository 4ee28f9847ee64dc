"""Which unknown matters most: first-order and total Sobol indices with their intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import stats

from locosweep.errors import InputError
from locosweep.grid import number
from locosweep.result import Output, for_pandas
from locosweep.uncertainty.evaluate import Running, evaluate, split
from locosweep.uncertainty.unknowns import points, power_of_two, sequence, unknowns, whole_seed

if TYPE_CHECKING:
    from collections.abc import Mapping

    import pandas as pd
    import polars as pl
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from locosweep._core import CancelToken
    from locosweep.progress import Progress

    Floats = NDArray[np.float64]

_CONFIDENCE = 0.95
REPLICATES = 16
"""Sequences scrambled anew, whose spread gives the intervals: 15 degrees of freedom."""


class Sensitivity:
    """Sobol indices of a quantity: shares of its variance that unknown parameters make.

    Attributes
    ----------
    output : Output
        Name, unit and label of the quantity.
    names : list of str
        The unknown parameters, as they were given.
    first, total : ndarray, shape (names,)
        First-order index: the share of the variance that goes if the parameter were known; and
        total index: the share that stays if all others were. Their sums differ from 1 where
        parameters act together.
    first_interval, total_interval : ndarray, shape (names, 2)
        At 95 % confidence.
    deviation : float
        Standard deviation of the quantity.
    without_value : float
        Share of the points that have no value, and counted as `failed`.
    failed : float or None
    fixed : dict of str to float
        Every parameter that is known, defaults included.
    how : dict of str to str
        Law, drive, method and gait of what was simulated.
    """

    def __init__(
        self,
        output: Output,
        names: list[str],
        indices: tuple[Floats, Floats],
        deviation: float,
        failures: tuple[float, float | None],
        known: tuple[Mapping[str, float], Mapping[str, str]],
    ) -> None:
        self.output, self.names = output, names
        self.fixed, self.how = dict(known[0]), dict(known[1])
        self.first, self.first_interval = _summed_up(indices[0])
        self.total, self.total_interval = _summed_up(indices[1])
        self.deviation = deviation
        self.without_value, self.failed = failures

    def to_polars(self) -> pl.DataFrame:
        """Return a table, a row a parameter, the one that matters most first."""
        import polars as pl

        table = pl.DataFrame(
            {
                "unknown": self.names,
                "first": self.first,
                "first_low": self.first_interval[:, 0],
                "first_high": self.first_interval[:, 1],
                "total": self.total,
                "total_low": self.total_interval[:, 0],
                "total_high": self.total_interval[:, 1],
            }
        )
        return table.sort("total", descending=True)

    def to_pandas(self) -> pd.DataFrame:
        """Return the table of `to_polars` for pandas; needs the extra ``pandas``."""
        return for_pandas(self.to_polars())

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw both indices of each parameter as bars with their intervals.

        Parameters
        ----------
        ax : Axes, optional
            Where to draw; default the current axes of pyplot while they are empty.
        """
        from locosweep.uncertainty.picture import bars

        return bars(self, ax)

    def __repr__(self) -> str:
        unit = "" if self.output.unit == "1" else f" {self.output.unit}"
        lines = [f"{self.output.label}: standard deviation {self.deviation:.4g}{unit}"]
        if self.without_value:
            share = f"{100 * self.without_value:.3g} %"
            lines.append(f"  {share} of the points have no value, and count as {self.failed:g}")
        wide = max(map(len, self.names))
        lines.append(f"  {'':{wide}}  first order            total")
        for row in self.to_polars().iter_rows(named=True):
            cells = [
                written(row[kind], row[f"{kind}_low"], row[f"{kind}_high"])
                for kind in ("first", "total")
            ]
            lines.append(f"  {row['unknown']:{wide}}  {cells[0]:21}  {cells[1]}".rstrip())
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from locosweep.plot.html import card
        from locosweep.uncertainty.picture import small

        return card(repr(self), small(self))


def written(index: float, low: float, high: float) -> str:
    """Write an index with its interval; one within its error of zero as the bound it has.

    Examples
    --------
    >>> from locosweep.uncertainty.sensitivity import written
    >>> written(0.514, 0.49, 0.538), written(-0.001, -0.004, 0.002)
    ('0.51 (0.49 to 0.54)', 'below 0.01')
    """
    if low <= 0.0:
        return f"below {max(np.ceil(100.0 * high) / 100.0, 0.01):.2g}"
    return f"{index:.2f} ({low:.2f} to {high:.2f})"


def _summed_up(replicates: Floats) -> tuple[Floats, Floats]:
    """Return means and their intervals of indices, shape (replicates, names)."""
    count = len(replicates)
    mean = replicates.mean(axis=0)
    far = stats.t.ppf(0.5 + _CONFIDENCE / 2.0, count - 1) * replicates.std(axis=0, ddof=1)
    half = far / np.sqrt(count)
    return mean, np.stack([mean - half, mean + half], axis=1)


def sensitivity(
    quantity: str,
    unknown: Mapping[str, Any],
    *,
    failed: float | None = None,
    samples: int = 2**14,
    seed: int = 0,
    threads: int | None = None,
    memory_limit: int | None = None,
    progress: bool | Progress | None = None,
    token: CancelToken | None = None,
    **known: Any,
) -> Sensitivity:
    """Say how much of a quantity's variance each unknown parameter makes.

    First-order indices are those of Saltelli et al. (2010), total ones of Jansen (1999), as
    ``scipy.stats.sobol_indices`` computes them, from 16 scrambled Sobol sequences whose spread
    gives the intervals.

    Parameters
    ----------
    quantity : str
        A name from ``locosweep.quantities()``; ``"feasible"`` says which unknown decides
        whether there is a value at all.
    unknown : mapping of str to distribution
        As in `propagate`.
    failed : float, optional
        What a point without a value counts as, for instance 0 for the speed of a robot that
        does not move. Needed where some points have none.
    samples : int
        Points, a power of two from 128 on; each is evaluated once more than there are unknowns,
        and once with all of them drawn anew.
    seed : int
        Of the scrambling.
    threads, memory_limit, progress, token
        As in `sweep`.
    **known
        Parameters that are known, numbers only; law, drive, gait, method and table as in `sweep`.

    Returns
    -------
    Sensitivity

    Raises
    ------
    InputError
        Names, distributions or numbers that are not allowed, points without a value where
        `failed` is not given, or a quantity that does not vary.
    Cancelled
        The token was used.

    Examples
    --------
    >>> import locosweep as ls
    >>> s = ls.sensitivity("mean_velocity", {"mu_coulomb": "normal:0.3:0.03",
    ...                    "slope_deg": "normal:5:1"}, mu_static=0.6, segments=5)
    >>> s.to_polars()["unknown"].to_list()
    ['slope_deg', 'mu_coulomb']
    """
    found = unknowns(unknown)
    count = power_of_two("samples", samples)
    if count < 8 * REPLICATES:
        raise InputError(f"samples is {samples}: allowed is a power of two from {8 * REPLICATES}")
    if failed is not None:
        failed = number("failed", failed, "a finite number")
    grid, choice = split(known, {one.name for one in found})
    if grid.axes:
        name = next(iter(grid.axes))
        raise InputError(f"{name} has {len(grid.axes[name])} values: allowed is one number")
    many, own = len(found), count // REPLICATES
    # Column i of the second half stands in for column i of the first, one after the other.
    drawn = np.stack([sequence(2 * many, own, whole_seed(seed), r) for r in range(REPLICATES)])
    here, there = drawn[..., :many], drawn[..., many:]
    sets = [here, there]
    for i in range(many):
        mixed = here.copy()
        mixed[..., i] = there[..., i]
        sets.append(mixed)
    chances = np.concatenate(sets).reshape(-1, many)
    sample = points(found, chances, grid.fixed)
    running = Running(threads, memory_limit, progress, token)
    made = evaluate(quantity, grid, sample, choice, running)
    values = made.values.reshape(many + 2, REPLICATES, own)
    missing = float(np.isnan(values).mean())
    if missing and failed is None:
        raise InputError(
            f"{100 * missing:.3g} % of the points have no value of {quantity}: say what they "
            "count as, for instance failed=0 for the speed of a robot that does not move"
        )
    if failed is not None:
        values = np.where(np.isnan(values), failed, values)
    deviation = float(np.std(values[:2]))
    if deviation == 0.0:
        raise InputError(f"{quantity} does not vary with {', '.join(o.key for o in found)}")
    if not np.ptp(values[:2], axis=-1).all():
        raise InputError(
            f"samples is {samples}: {quantity} is the same at all points of one of the "
            f"{REPLICATES} parts they are drawn in, more are needed"
        )
    indices = stats.sobol_indices(
        func={"f_A": values[0], "f_B": values[1], "f_AB": values[2:]}, n=own
    )
    first, total = (
        np.reshape(one, (REPLICATES, many)) for one in (indices.first_order, indices.total_order)
    )
    names = [one.key for one in found]
    output = Output.of(quantity, None, None)
    return Sensitivity(
        output, names, (first, total), deviation, (missing, failed if missing else None),
        (made.fixed, made.how),
    )  # fmt: skip
