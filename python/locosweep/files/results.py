"""Results of sweeps as Parquet, read back to the same bits and refused where altered."""

from __future__ import annotations

import hashlib
import json
import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.errors import DataFileError, first_line
from locosweep.files.atomic import write_frame
from locosweep.registry import Status

if TYPE_CHECKING:
    import polars as pl

    from locosweep.result import Result

_FORMAT = "locosweep.result/1"


def save_result(result: Result, path: str | os.PathLike[str]) -> None:
    """Write a result as a Parquet table with everything needed to read it back."""
    header: dict[str, Any] = {
        "format": _FORMAT,
        "version": _core.version(),
        "axes": {name: [_text(v) for v in axis] for name, axis in result.axes.items()},
        "fixed": {name: _text(value) for name, value in result.fixed.items()},
        "over": result.over,
        "rivals": None if result.rivals is None else [_text(v) for v in result.rivals],
        "q": result.q,
        "outputs": [[o.quantity, o.reduce, result[o.name].dtype.name] for o in result.outputs],
        "how": result.how,
    }
    header["sha256"] = _digest(header, result)
    write_frame(path, result.to_polars(), {"locosweep": json.dumps(header)}, csv=False)


def _text(value: float) -> str:
    """Shortest text that reads back to the same bits."""
    return repr(float(value))


def _digest(header: dict[str, Any], result: Result) -> str:
    """Hash everything that is read back."""
    rest = {key: value for key, value in header.items() if key != "sha256"}
    digest = hashlib.sha256(json.dumps(rest, sort_keys=True).encode())
    for output in result.outputs:
        digest.update(np.ascontiguousarray(result[output.name]).tobytes())
        digest.update(np.ascontiguousarray(result.status_of(output.name)).tobytes())
    return digest.hexdigest()


def load(path: str | os.PathLike[str]) -> Result:
    """Read a result that `Result.save` wrote.

    Parameters
    ----------
    path : path-like
        The Parquet file.

    Returns
    -------
    Result
        With the same bits as when it was saved.

    Raises
    ------
    DataFileError
        No such file, no Parquet, not a result of this package, or altered since.

    Examples
    --------
    >>> import locosweep as ls, tempfile, pathlib
    >>> r = ls.sweep("optimal_segments", mu_static=[0.4, 0.5], mu_coulomb=0.3)
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "r.parquet"
    >>> r.save(file)
    >>> bool((ls.load(file).values == r.values).all())
    True
    """
    import polars as pl

    from locosweep.result import Result

    path = Path(path)
    if not path.is_file():
        raise DataFileError(f"{path}: no such file")
    try:
        header = _header(path, pl.read_parquet_metadata(path).get("locosweep"))
        frame = pl.read_parquet(path)
    except (OSError, pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        raise DataFileError(f"{path}: not a readable Parquet file: {first_line(error)}") from None
    try:
        outputs, axes, fixed, values, statuses = _unpack(header, frame)
        rivals, q = header["rivals"], header["q"]
        result = Result(
            outputs,
            axes,
            fixed,
            values,
            over=header["over"],
            rivals=None if rivals is None else np.array([float(v) for v in rivals]),
            q=None if q is None else float(q),
            statuses=statuses,
            how={str(key): str(value) for key, value in header.get("how", {}).items()},
        )
        unaltered = _digest(header, result) == header.get("sha256")
    except (AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError,
            pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:  # fmt: skip
        raise DataFileError(f"{path}: not a result of locosweep: {error}") from None
    if not unaltered:
        raise DataFileError(f"{path}: altered or damaged since it was written (hash differs)")
    return result


def _header(path: Path, text: str | None) -> dict[str, Any]:
    try:
        header = json.loads(text or "")
    except (ValueError, RecursionError):
        header = None
    if not isinstance(header, dict) or "format" not in header:
        raise DataFileError(f"{path}: a Parquet file, but not a result of locosweep")
    if header["format"] != _FORMAT:
        raise DataFileError(f"{path}: format {header['format']!r}: this version reads {_FORMAT!r}")
    return header


def _unpack(header: dict[str, Any], frame: pl.DataFrame) -> tuple[Any, ...]:
    import polars as pl

    from locosweep.result import Output

    over = header["over"]
    axes = {name: np.array([float(v) for v in axis]) for name, axis in header["axes"].items()}
    fixed = {name: float(value) for name, value in header["fixed"].items()}
    shape = tuple(len(axis) for axis in axes.values())
    if frame.height != math.prod(shape):
        raise ValueError(f"{frame.height} rows for a grid of {math.prod(shape)} cells")
    outputs, values, statuses = [], [], {}
    single = len(header["outputs"]) == 1
    for name, reduce, dtype in header["outputs"]:
        output = Output.of(name, reduce, over)
        column = frame[output.name].to_numpy()
        if dtype not in ("float64", "float32") or column.dtype.name != dtype:
            raise ValueError(f"column {output.name} has type {column.dtype}")
        label = "status" if single else f"{output.name}_status"
        codes = {status.name.lower(): int(status) for status in Status}
        read = frame[label].cast(str).replace_strict(codes, return_dtype=pl.UInt8)
        outputs.append(output)
        values.append(np.ascontiguousarray(column).reshape(shape))
        statuses[output.name] = np.ascontiguousarray(read.to_numpy()).reshape(shape)
    return outputs, axes, fixed, values, statuses
