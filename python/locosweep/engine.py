"""Sweeps: a quantity, or several, over a grid."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from locosweep import _core, memory
from locosweep._core import CancelToken
from locosweep.errors import InputError
from locosweep.grid import Grid
from locosweep.progress import progress_of
from locosweep.request import Request, how
from locosweep.result import Output, Result

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from locosweep.progress import Progress
    from locosweep.run_folder.run import Run

_LARGEST = 2**63 - 1
"""Largest whole number that the core takes."""
_FLOATS = {"float64": np.float64, "float32": np.float32}


@overload
def sweep(
    quantity: str | Sequence[str],
    grid: Grid | None = None,
    *,
    out: str | os.PathLike[str],
    **options: Any,
) -> Run: ...


@overload
def sweep(
    quantity: str | Sequence[str],
    grid: Grid | None = None,
    *,
    over: str | None = None,
    reduce: str | Sequence[str] | None = None,
    q: float | None = None,
    out: NDArray[Any] | Sequence[NDArray[Any]] | None = None,
    dtype: str | np.dtype[Any] | type = "float64",
    law: str | None = None,
    drive: str | None = None,
    gait: str | None = None,
    method: str | None = None,
    table: tuple[ArrayLike, ArrayLike] | None = None,
    threads: int | None = None,
    chunk: int | None = None,
    memory_limit: int | None = None,
    progress: bool | Progress = False,
    token: CancelToken | None = None,
    **fixed: Any,
) -> Result: ...


def sweep(
    quantity: str | Sequence[str],
    grid: Grid | None = None,
    *,
    over: str | None = None,
    reduce: str | Sequence[str] | None = None,
    q: float | None = None,
    out: NDArray[Any] | Sequence[NDArray[Any]] | str | os.PathLike[str] | None = None,
    dtype: str | np.dtype[Any] | type = "float64",
    law: str | None = None,
    drive: str | None = None,
    gait: str | None = None,
    method: str | None = None,
    table: tuple[ArrayLike, ArrayLike] | None = None,
    threads: int | None = None,
    chunk: int | None = None,
    memory_limit: int | None = None,
    progress: bool | Progress = False,
    token: CancelToken | None = None,
    shard: tuple[int, int] | None = None,
    client: Any = None,
    allow_drift: bool = False,
    **fixed: Any,
) -> Result | Run:
    """Evaluate quantities at every point of a grid, or fold one axis away.

    Parameters
    ----------
    quantity : str or sequence of str
        Names from ``locosweep.quantities()``; several are computed in one pass.
    grid : Grid, optional
        Axes and fixed values. Without it, all parameters come from ``fixed``.
    over : str, optional
        Axis to reduce; it is never stored.
    reduce : str or sequence of str, optional
        How (``locosweep.reductions()``), together with `over`.
    q : float, optional
        Which quantile, from 0 to 1, for ``reduce="quantile"``.
    out : ndarray, sequence of ndarray, or path of a folder, optional
        Where to put the result: C-contiguous float64 or float32 of the result's
        shape, one per output. Filled in place, not copied. Or a folder, which gets
        the result chunk by chunk, whatever its size, needs the extra ``runs``, and is
        resumed by the same call; then a `Run` is returned.
    dtype : {"float64", "float32"}
        Type of a fresh result; it is always computed in float64.
    law : str, optional
        Friction law (``locosweep.laws()``) of quantities that are simulated;
        default ``coulomb_viscous``. Its parameters may be axes.
    drive : str, optional
        Drive (``locosweep.drives()``) of quantities that are simulated; default
        ``constant``. Its parameters may be axes.
    gait : str, optional
        Gait of quantities of whole robots (``gait_advance`` and others); default
        ``single``, one segment at a time.
    method : str, optional
        How to simulate (``locosweep.methods()``); default: the best for law and
        drive, which is exact where the motion between events is known.
    table : (array_like, array_like), optional
        Times in s, rising, and values of the drive ``table``, one-dimensional.
    threads : int, optional
        Threads; default ``LOCOSWEEP_NUM_THREADS``, else what a batch system
        granted, else all processors. The result does not depend on it.
    chunk : int, optional
        Cells per unit of work; with a folder, cells of a stored chunk, where the folder is new:
        a begun run keeps its chunks. The result does not depend on it.
    memory_limit : int, optional
        Bytes; what would need more is refused before it starts. Default 80 % of
        the free memory.
    progress : bool or callable
        True writes a line to standard error; a callable receives finished and
        total evaluations and the rate in 1/s, at most ten times a second.
    token : CancelToken, optional
        Lets another thread stop the sweep, which then raises ``Cancelled``.
    shard : (int, int), optional
        With a folder: (i, n) computes every n-th chunk from the i-th on, from 0, then
        what is missing of the others.
    client : dask.distributed.Client, optional
        With a folder that all its workers see: they compute the chunks, each with
        `threads` (default 1). Needs the extra ``dask``.
    allow_drift : bool
        With a folder: resume it although this version computes other bits, and note so.
    **fixed
        Further parameters, as in `Grid`; sequences become axes at the end.

    Returns
    -------
    Result
        ``values`` and ``status`` have one axis per swept parameter, in order.
        A `Run` (``locosweep.open_run``) where `out` is a folder.

    Raises
    ------
    InputError
        Unknown names, values outside their range, a missing parameter, an `out`
        that does not fit, or more memory than allowed.
    Cancelled
        The token was used.

    Examples
    --------
    >>> import locosweep as ls
    >>> grid = ls.Grid(mu_static=0.5, mu_coulomb=0.3, segments=range(2, 6))
    >>> (1000 * ls.sweep("mean_velocity", grid).values).round(3)
    array([70.036, 87.35 , 85.776, 81.675])
    >>> best = ls.sweep("mean_velocity", grid, over="segments", reduce="argmax")
    >>> float(best.values)
    3.0
    """
    request = Request.of(
        quantity, reduce, q=q, table=table, over=over, law=law, drive=drive, gait=gait,
        method=method,
    )  # fmt: skip
    if grid is not None and not isinstance(grid, Grid):
        raise InputError(
            f"grid is a {type(grid).__name__}: allowed is a Grid, or parameters by name"
        )
    if token is not None and not isinstance(token, _core.CancelToken):
        raise InputError(f"token is {token!r}: allowed is a CancelToken")
    memory_limit = whole("memory_limit", memory_limit)
    grid = (Grid() if grid is None else grid).with_fixed(fixed)
    if isinstance(out, str | os.PathLike):
        from locosweep.run_folder.fill import Options, sweep_into

        options = Options(
            threads=whole("threads", threads), chunk=whole("chunk", chunk), shard=shard,
            memory_limit=memory_limit, progress=progress, token=token, client=client,
            allow_drift=allow_drift,
        )  # fmt: skip
        return sweep_into(out, request, grid, _float_name(dtype), options)
    stored = {"shard": shard, "client": client, "allow_drift": allow_drift or None}
    if any(value is not None for value in stored.values()):
        idle = next(name for name, value in stored.items() if value is not None)
        raise InputError(f"{idle} is given: allowed only together with out='FOLDER/'")
    job = request.job(grid.axes, grid.fixed)
    count = _core.threads_to_use(whole("threads", threads))
    shape = tuple(job.shape)
    outputs = len(request.outputs)
    arrays = _arrays(out, dtype, shape, outputs, job.working_bytes(count), memory_limit)
    meter = progress_of(progress, ", ".join(request.quantities))
    job.run(list(enumerate(arrays)), count, whole("chunk", chunk), meter, token, None, out is None)
    axes = {name: grid.axes[name] for name in job.axes}
    rivals = None if over is None else grid.axes[over]
    return Result(
        [Output.of(name, r, over) for name, r, _ in request.outputs],
        axes,
        dict(job.fixed),
        arrays,
        over=over,
        rivals=rivals,
        q=q,
        job=job,
        how=how(job, request.table),
    )


def whole(name: str, value: int | None) -> int | None:
    """Refuse what is no whole number from 1 upward; None passes."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise InputError(f"{name} is {value!r}: allowed is a whole number from 1 upward")
    if value > _LARGEST:
        raise InputError(f"{name} is {_short(value)}: allowed is a whole number up to {_LARGEST}")
    return int(value)


def _short(value: int) -> str:
    try:
        return f"{float(value):.3g}"
    except OverflowError:
        return "too large"


def _arrays(
    out: NDArray[Any] | Sequence[NDArray[Any]] | None,
    dtype: str | np.dtype[Any] | type,
    shape: tuple[int, ...],
    count: int,
    working: int,
    limit: int | None,
) -> list[NDArray[Any]]:
    if out is not None:
        if not isinstance(out, np.ndarray | list | tuple):
            raise InputError(f"out is {out!r}: allowed are arrays, or the path of a folder")
        given = [out] if isinstance(out, np.ndarray) else list(out)
        if len(given) != count:
            raise InputError(f"out has {len(given)} arrays: the sweep has {count} outputs")
        for array in given:
            _check_out(array, shape)
        memory.check(working, limit, "the sweep")
        return given
    kind = _float_name(dtype)
    cells = int(np.prod(shape, dtype=object))
    memory.check(count * cells * np.dtype(kind).itemsize + working, limit, "the result")
    # NumPy asks for huge pages: filling a fresh result then costs little more
    # than filling a used one.
    return [np.empty(shape, _FLOATS[kind]) for _ in range(count)]


def _float_name(dtype: str | np.dtype[Any] | type) -> str:
    try:
        kind = np.dtype(dtype).name
    except TypeError:
        kind = str(dtype)
    if kind not in _FLOATS:
        raise InputError(f"dtype is {kind}: allowed are {', '.join(_FLOATS)}")
    return kind


def _check_out(array: object, shape: tuple[int, ...]) -> None:
    if not isinstance(array, np.ndarray):
        raise InputError(f"out is a {type(array).__name__}: allowed is a NumPy array")
    if array.shape != shape:
        raise InputError(f"out has shape {array.shape}: the result has shape {shape}")
    if array.dtype not in (np.float64, np.float32) or not array.dtype.isnative:
        raise InputError(f"out has type {array.dtype}: allowed are native float64 and float32")
    flags = array.flags
    if not (flags.c_contiguous and flags.writeable and flags.aligned):
        raise InputError("out must be C-contiguous, aligned and writeable")
