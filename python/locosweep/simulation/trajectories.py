"""Trajectories of one segment: to look at, one point of a grid or a few."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core, memory
from locosweep.engine import whole
from locosweep.errors import InputError
from locosweep.grid import Grid, few
from locosweep.progress import progress_of
from locosweep.registry import Status, parameter
from locosweep.request import samples_of

if TYPE_CHECKING:
    import polars as pl
    from numpy.typing import ArrayLike, NDArray

    from locosweep._core import CancelToken
    from locosweep.progress import Progress

_FIELDS = 4
_ADAPTIVE, _FIXED = "dormand_prince", "runge_kutta"


@dataclass(frozen=True, repr=False)
class Trajectories:
    """Motion of one segment at every point of a grid.

    Attributes
    ----------
    t : ndarray
        Times in s: one-dimensional, or of the shape of ``x`` where the duration is
        an axis.
    x, v : ndarray
        Position in m and speed in m/s, shape of the grid with the samples last.
    force : ndarray
        Force of the drive on the segment in N.
    way : ndarray
        Direction of sliding, 1 or -1; 0 while friction holds the segment.
    status : ndarray of uint8
        Codes of ``locosweep.Status``, shape of the grid: 0 is ok.
    axes : dict of str to ndarray
        The grid's axes.
    fixed : dict of str to float
        All other parameters.
    law, drive, method : str
        What was simulated, and how.
    """

    t: NDArray[np.float64]
    x: NDArray[np.float64]
    v: NDArray[np.float64]
    force: NDArray[np.float64]
    way: NDArray[np.float64]
    status: NDArray[np.uint8]
    axes: dict[str, NDArray[np.float64]]
    fixed: dict[str, float]
    law: str
    drive: str
    method: str

    def failure(self, index: tuple[int, ...]) -> tuple[Status, float | None]:
        """Return why the curve at a grid index fails, and from when on it has no values.

        Parameters
        ----------
        index : tuple of int
            Position in ``status``; the empty tuple where there is no axis.

        Returns
        -------
        Status
            ``Status.OK`` if it does not fail.
        float or None
            Seconds; None where it has all its values.

        Examples
        --------
        >>> import locosweep as ls
        >>> run = ls.simulate(law="coulomb", mu_coulomb=0.3, drive_force=2)
        >>> run.failure(())
        (<Status.OK: 0>, None)
        """
        gone = np.broadcast_to(self.t, self.x.shape)[index][np.isnan(self.x[index])]
        return Status(int(self.status[index])), float(gone[0]) if gone.size else None

    def to_polars(self) -> pl.DataFrame:
        """Return a long table: the axes, then t, x, v, force and way."""
        import polars as pl

        shape = self.x.shape
        index = np.indices(shape[:-1])
        columns = {
            name: np.repeat(values[along.ravel()], shape[-1])
            for (name, values), along in zip(self.axes.items(), index, strict=True)
        }
        columns["t"] = np.broadcast_to(self.t, shape).ravel()
        for name in ("x", "v", "force", "way"):
            columns[name] = getattr(self, name).ravel()
        return pl.DataFrame(columns)

    def __repr__(self) -> str:
        count = int(np.prod(self.x.shape[:-1], dtype=object))
        end, many = float(np.max(self.t)), "y" if count == 1 else "ies"
        lines = [
            f"Trajectories: law {self.law}, drive {self.drive}, method {self.method}; "
            f"{count} trajector{many} of {self.x.shape[-1]} samples up to {end:g} s"
        ]
        lines += [
            f"  {name} [{parameter(name).unit}]: {few(values, 6)}"
            for name, values in self.axes.items()
        ]
        for name, unit in (("x", "m"), ("v", "m/s"), ("force", "N")):
            values = getattr(self, name)
            if np.isfinite(values).any():
                lines.append(f"  {name}: {np.nanmin(values):.4g} .. {np.nanmax(values):.4g} {unit}")
        for code in np.unique(self.status[self.status > 0]).tolist():
            failed = int(np.count_nonzero(self.status == code))
            lines.append(f"  {failed} with status {Status(code).name.lower()}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from locosweep.plot.html import trajectories_card

        return trajectories_card(self)


def simulate(
    grid: Grid | None = None,
    *,
    law: str | None = None,
    drive: str | None = None,
    method: str | None = None,
    table: tuple[ArrayLike, ArrayLike] | None = None,
    samples: int = 501,
    threads: int | None = None,
    memory_limit: int | None = None,
    progress: bool | Progress | None = None,
    token: CancelToken | None = None,
    **fixed: Any,
) -> Trajectories:
    """Simulate one segment at every point of a grid and keep its motion.

    Solves m dv/dt = F - R - m g sin(alpha) with the drive force F, friction R and
    true sticking. For numbers of millions of trajectories use `sweep`, which keeps
    no motion.

    Parameters
    ----------
    grid : Grid, optional
        Axes and fixed values. Without it, all parameters come from ``fixed``.
    law, drive, method, table
        As in `sweep`; without a method dry laws that are not exact take adaptive
        steps with dense output, which ``samples`` do not shorten, and fixed ones where
        those do not come to an end.
    samples : int
        Evenly spread times from 0 to the duration at which motion is kept.
    threads, memory_limit, progress, token
        As in `sweep`.
    **fixed
        Further parameters, as in `Grid`.

    Returns
    -------
    Trajectories
        NaN from where a trajectory has left all bounds or could not be followed;
        ``status`` says why, and which motion is too coarse to trust.

    Raises
    ------
    InputError
        As in `sweep`.
    Cancelled
        The token was used.

    Examples
    --------
    >>> import locosweep as ls
    >>> run = ls.simulate(law="coulomb_viscous", mu_coulomb=0.15, viscous=0.5,
    ...                   drive_force=1.5951, duration=1.0, samples=3)
    >>> run.v.round(4)
    array([0.    , 1.4415, 2.0146])
    """
    grid = (Grid() if grid is None else grid).with_fixed(fixed)
    count = whole("samples", samples)
    if count is None or count < 2:
        raise InputError(f"samples is {samples}: allowed is a whole number from 2 upward")
    job = _core.Sweep(
        list(grid.axes.items()),
        list(grid.fixed.items()),
        [("final_position", None, None)],
        law=law,
        drive=drive,
        method=method,
        table=samples_of(table),
        motion=True,
    )
    workers = _core.threads_to_use(whole("threads", threads))
    needed = 8 * _FIELDS * job.cells * count + job.working_bytes(workers)
    memory.check(needed, memory_limit, "the trajectories")
    shares = np.linspace(0.0, 1.0, count)
    meter = progress_of(progress, "simulate")
    fields, codes = job.trace(shares, workers, meter, token)
    chosen = job.choice
    adaptive = method is None and chosen is not None and chosen[2] == _ADAPTIVE
    if adaptive and not np.isfinite(fields[0]).all():
        # Resistance that rises infinitely steeply from rest has no error estimate.
        return simulate(
            grid, law=law, drive=drive, method=_FIXED, samples=samples, table=table,
            threads=threads, memory_limit=memory_limit, progress=progress, token=token,
        )  # fmt: skip
    shape = (*job.shape, count)
    x, v, force, way = (field.reshape(shape) for field in fields)
    values = dict(job.fixed)
    axes = {name: grid.axes[name] for name in job.axes}
    if "duration" in axes:
        axis = list(axes).index("duration")
        durations = axes["duration"].reshape([-1 if i == axis else 1 for i in range(len(shape))])
        t = np.broadcast_to(durations * shares, shape).copy()
    else:
        t = values["duration"] * shares
    used = job.choice
    if used is None:  # pragma: no cover - a simulated quantity always has one
        raise InputError("nothing to simulate")
    status = codes.reshape(job.shape)
    return Trajectories(t, x, v, force, way, status, axes, values, *used)
