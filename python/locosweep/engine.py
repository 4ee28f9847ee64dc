"""Sweeps: a quantity, or several, over a grid."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core, memory
from locosweep._core import CancelToken
from locosweep.errors import InputError
from locosweep.grid import Grid
from locosweep.progress import Meter
from locosweep.result import Output, Result

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from locosweep.progress import Progress

_LARGEST = 2**63 - 1
"""Largest whole number that the core takes."""
_FLOATS = {"float64": np.float64, "float32": np.float32}


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
) -> Result:
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
    out : ndarray or sequence of ndarray, optional
        Where to put the result: C-contiguous float64 or float32 of the result's
        shape, one per output. Filled in place, not copied.
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
        Cells per unit of work. The result does not depend on it.
    memory_limit : int, optional
        Bytes; what would need more is refused before it starts. Default 80 % of
        the free memory.
    progress : bool or callable
        True writes a line to standard error; a callable receives finished and
        total evaluations and the rate in 1/s, at most ten times a second.
    token : CancelToken, optional
        Lets another thread stop the sweep, which then raises ``Cancelled``.
    **fixed
        Further parameters, as in `Grid`; sequences become axes at the end.

    Returns
    -------
    Result
        ``values`` and ``status`` have one axis per swept parameter, in order.

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
    names = [quantity] if isinstance(quantity, str) else list(quantity)
    how = [reduce] if reduce is None or isinstance(reduce, str) else list(reduce)
    if not names or not how:
        raise InputError(f"{'quantity' if not names else 'reduce'} is empty: name at least one")
    grid = (Grid() if grid is None else grid).with_fixed(fixed)
    if q is not None and "quantile" not in how:
        raise InputError(f"q is {q!r}: allowed only together with reduce 'quantile'")
    requests = [(name, r, q if r == "quantile" else None) for name in names for r in how]
    if len(set(requests)) < len(requests):
        raise InputError("quantity or reduce names the same thing twice")
    job = _core.Sweep(
        list(grid.axes.items()),
        list(grid.fixed.items()),
        requests,
        over,
        law=law,
        drive=drive,
        gait=gait,
        method=method,
        table=samples_of(table),
    )
    count = _core.threads_to_use(whole("threads", threads))
    shape = tuple(job.shape)
    arrays = _arrays(out, dtype, shape, len(requests), job.working_bytes(count), memory_limit)
    meter = Meter(", ".join(names)) if progress is True else progress or None
    job.run(list(enumerate(arrays)), count, whole("chunk", chunk), meter, token, None, out is None)
    outputs = [Output.of(name, r, over) for name, r, _ in requests]
    axes = {name: grid.axes[name] for name in job.axes}
    rivals = None if over is None else grid.axes[over]
    return Result(
        outputs,
        axes,
        dict(job.fixed),
        arrays,
        over=over,
        rivals=rivals,
        q=q,
        job=job,
        how=_how(job, table),
    )


def _how(job: _core.Sweep, table: tuple[ArrayLike, ArrayLike] | None) -> dict[str, str]:
    """Tell how simulated quantities were found; empty for closed forms."""
    how = {}
    if job.choice is not None:
        how = dict(zip(("law", "drive", "method"), job.choice, strict=True))
    if job.gait is not None:
        how["gait"] = job.gait
    samples = samples_of(table)
    if samples is not None:
        digest = hashlib.sha256(b"".join(part.tobytes() for part in samples))
        how["table_sha256"] = digest.hexdigest()
    return how


def samples_of(
    table: tuple[ArrayLike, ArrayLike] | None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Turn the samples of a drive into two arrays of numbers."""
    if table is None:
        return None
    try:
        times, values = (np.asarray(part, dtype=np.float64) for part in table)
    except (TypeError, ValueError):
        raise InputError("table is not two arrays of numbers: times and values") from None
    if times.ndim != 1 or values.ndim != 1:
        raise InputError(
            f"table has {times.ndim} and {values.ndim} dimensions: allowed is one each"
        )
    return times, values


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
        given = [out] if isinstance(out, np.ndarray) else list(out)
        if len(given) != count:
            raise InputError(f"out has {len(given)} arrays: the sweep has {count} outputs")
        for array in given:
            _check_out(array, shape)
        memory.check(working, limit, "the sweep")
        return given
    try:
        kind = np.dtype(dtype).name
    except TypeError:
        kind = str(dtype)
    if kind not in _FLOATS:
        raise InputError(f"dtype is {kind}: allowed are {', '.join(_FLOATS)}")
    cells = int(np.prod(shape, dtype=object))
    memory.check(count * cells * np.dtype(kind).itemsize + working, limit, "the result")
    # NumPy asks for huge pages: filling a fresh result then costs little more
    # than filling a used one.
    return [np.empty(shape, _FLOATS[kind]) for _ in range(count)]


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
