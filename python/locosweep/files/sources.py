"""Where measured runs come from: files, folders of them, standard input, frames of any maker."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.errors import DataFileError, InputError, first_line
from locosweep.files.bags import is_bag
from locosweep.files.raw import STANDARD_INPUT

if TYPE_CHECKING:
    import polars as pl

ENDINGS = (".csv", ".tsv", ".csv.gz", ".tsv.gz", ".parquet")
"""Files that are taken from a folder."""


def is_frame(data: object) -> bool:
    """Return whether data are columns in memory: no path, and no list of paths."""
    return isinstance(data, Mapping) or not isinstance(data, str | os.PathLike | Iterable) or (
        any(hasattr(data, name) for name in ("__arrow_c_stream__", "collect", "items", "dtype"))
    )  # fmt: skip


def frame_of(data: Any, name: str = "data") -> pl.DataFrame:
    """Return columns in memory as a Polars frame.

    Parameters
    ----------
    data : object
        A Polars frame (lazy or not), an Arrow table, a pandas frame, a structured NumPy array,
        or a mapping of names to arrays.
    name : str
        What messages call it.

    Raises
    ------
    InputError
        Anything else, or columns of several lengths.

    Examples
    --------
    >>> from locosweep.files.sources import frame_of
    >>> frame_of({"t": [0.0, 0.5]}).shape
    (2, 1)
    """
    import polars as pl

    if isinstance(data, pl.DataFrame):
        return data
    try:
        if isinstance(data, pl.LazyFrame):
            return data.collect()
        if isinstance(data, np.ndarray) and data.dtype.names:
            data = {column: data[column] for column in data.dtype.names}
        # Those of pandas only work where Arrow is installed; its columns always do.
        if hasattr(data, "__arrow_c_stream__") and not hasattr(data, "items"):
            return pl.DataFrame(data)
        if hasattr(data, "items"):
            return pl.DataFrame({str(key): _column(values) for key, values in data.items()})
    except (OverflowError, TypeError, ValueError, pl.exceptions.PolarsError,
            pl.exceptions.PanicException) as error:  # fmt: skip
        raise InputError(f"{name}: not columns of one length: {first_line(error)}") from None
    raise InputError(
        f"{name} is a {type(data).__name__}: allowed are files, frames and mappings of columns"
    )


def _column(values: Any) -> Any:
    """Return an array of plain values, missing ones as None where they are objects."""
    import polars as pl

    if isinstance(values, pl.Series):
        return values
    array = np.asarray(values)
    if array.dtype.kind in "mM":
        # Polars takes no whole seconds.
        return array.astype(f"{array.dtype.kind}8[ns]")
    if array.dtype != object:
        return array
    # pandas has a value of its own for missing ones, which equals nothing.
    return [None if type(v).__name__ in {"NAType", "NaTType"} else v for v in array.tolist()]


def files_of(data: Any) -> list[Path]:
    """Return the files of a path, a folder, ``-`` (standard input) or a list of these.

    DataFileError for a folder without a file of runs, InputError for a file that comes twice.
    """
    given = [data] if isinstance(data, str | os.PathLike) else list(data)
    if not given:
        raise InputError("runs is empty: allowed is at least one file")
    found: list[Path] = []
    for one in given:
        if not isinstance(one, str | os.PathLike):
            raise InputError(f"runs has a {type(one).__name__}: allowed are paths of files")
        path = Path(one)
        if path == STANDARD_INPUT or not path.is_dir() or is_bag(path):
            found.append(path)
            continue
        within = sorted((p for p in path.iterdir() if _has_runs(p)), key=_in_order)
        if not within:
            raise DataFileError(f"{path}: no file in it ends in {', '.join(ENDINGS)}")
        found += within
    for path in found:
        if found.count(path) > 1:
            raise InputError(f"{path} is given twice: allowed is once")
    return found


def names_of(files: list[Path]) -> list[str]:
    """Return a name for each file, without its ending, with its folder or ending where needed."""
    stems = [path.name.removesuffix(".gz").rsplit(".", 1)[0] or str(path) for path in files]
    names = [
        stem if stems.count(stem) == 1 else (path.parent / stem).as_posix()
        for stem, path in zip(stems, files, strict=True)
    ]
    # Of files in one folder that differ in their endings alone, with these.
    return [
        name if names.count(name) == 1 else path.as_posix()
        for name, path in zip(names, files, strict=True)
    ]


def _has_runs(path: Path) -> bool:
    return path.is_file() and not path.name.startswith(".") and path.name.lower().endswith(ENDINGS)


def _in_order(path: Path) -> list[tuple[int, str]]:
    """Return a key by which run2 comes before run10."""
    return [(int(p) if p.isdecimal() else -1, p) for p in re.split(r"(\d{1,9})", path.name)]
