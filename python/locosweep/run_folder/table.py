"""The long table of a run, part by part: for Polars and as Parquet files."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.errors import InputError, LocosweepError
from locosweep.files.atomic import replacing, write_frame
from locosweep.files.folder import filling
from locosweep.registry import Status

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

    import polars as pl

    from locosweep.run_folder.run import Run

    Told = Callable[[int, int, float], object]

_ROWS = 1 << 20
"""Rows of a part: 50 to 100 MB with a few axes and outputs."""


def columns(run: Run) -> dict[str, Any]:
    """Return names and types of the table's columns, those of `Result.to_polars`."""
    import polars as pl

    value = pl.Float32 if run.cells.dtype == "float32" else pl.Float64
    names = [status.name.lower() for status in Status]
    found: dict[str, Any] = dict.fromkeys(run.axes, pl.Float64)
    for output in run.outputs:
        found[output.name] = value
        found[_status_name(run, output.name)] = pl.Enum(names)
    return found


def _status_name(run: Run, output: str) -> str:
    return "status" if len(run.outputs) == 1 else f"{output}_status"


def frames(
    run: Run, wanted: list[str] | None = None, told: Told | None = None
) -> Iterator[pl.DataFrame]:
    """Yield the rows of finished chunks, a million at a time; each file is read once.

    `told` receives the chunks that are read, and all.
    """
    plan = run.manifest.plan
    names = list(columns(run)) if wanted is None else wanted
    for chunk in range(plan.count):
        if not run.allow_missing or chunk in run.state.done:
            yield from _rows(run, chunk, names)
        if told is not None:
            told(chunk + 1, plan.count, 0.0)


def _rows(run: Run, chunk: int, names: list[str]) -> Iterator[pl.DataFrame]:
    cells = run.manifest.plan.slices(chunk)
    blocks = {}
    for output in run.outputs:
        label = _status_name(run, output.name)
        for name, path in ((output.name, output.name), (label, f"{output.name}_status")):
            if name in names:
                blocks[name] = np.asarray(run.array(path)[cells])
    axes = [axis[part] for axis, part in zip(run.axes.values(), cells, strict=True)]
    for part in _split(tuple(slice(0, len(axis)) for axis in axes)):
        yield _frame(run, axes, blocks, part, names)


def _frame(
    run: Run, axes: list[Any], blocks: dict[str, Any], part: tuple[slice, ...], names: list[str]
) -> pl.DataFrame:
    import polars as pl

    shape = tuple(s.stop - s.start for s in part)
    kinds = columns(run)
    found: dict[str, Any] = {}
    for dimension, name in enumerate(run.axes):
        if name in names:
            form = [-1 if i == dimension else 1 for i in range(len(shape))]
            view = axes[dimension][part[dimension]].reshape(form)
            found[name] = np.broadcast_to(view, shape).ravel()
    for name, block in blocks.items():
        rows = block[part].ravel()
        if rows.dtype == np.uint8:
            # Gathered: Polars 2 does not cast numbers to an Enum.
            words = kinds[name].categories
            rows = pl.Series(words, dtype=kinds[name]).gather(pl.Series(rows))
        found[name] = rows
    return pl.DataFrame(found).select(names)


def _split(cells: tuple[slice, ...]) -> Iterator[tuple[slice, ...]]:
    lengths = [s.stop - s.start for s in cells]
    if math.prod(lengths) <= _ROWS:
        yield cells
        return
    # Along the first axis that is longer than one: parts follow each other as rows do.
    axis = next(i for i, n in enumerate(lengths) if n > 1)
    step = max(1, _ROWS * lengths[axis] // math.prod(lengths))
    whole = cells[axis]
    for start in range(whole.start, whole.stop, step):
        part = slice(start, min(start + step, whole.stop))
        yield from _split((*cells[:axis], part, *cells[axis + 1 :]))


def scan(
    run: Run, faults: list[LocosweepError] | None = None, told: Told | None = None
) -> pl.LazyFrame:
    """Return a LazyFrame that reads the chunks of a run as a query takes them.

    `faults` gets what goes wrong on reading, which Polars wraps into an error of its own; `told`
    as in `frames`.
    """
    from polars.io.plugins import register_io_source

    # Refused now rather than in the middle of a query.
    _ = run.store

    def read(
        with_columns: list[str] | None,
        predicate: pl.Expr | None,
        n_rows: int | None,
        batch_size: int | None,
    ) -> Iterator[pl.DataFrame]:
        del batch_size
        left = n_rows
        try:
            for rows in frames(run, with_columns, told):
                if left is not None and left <= 0:
                    return
                found = rows if left is None else rows.head(left)
                if left is not None:
                    left -= found.height
                yield found if predicate is None else found.filter(predicate)
        except LocosweepError as error:
            if faults is not None:
                faults.append(error)
            raise

    return register_io_source(read, schema=columns(run))


def export(run: Run, out: Path, progress: Told | None = None) -> int:
    """Write the table as Parquet: one file, or a folder of files; return how many.

    A file name ends in ``.parquet``. A folder appears as a whole. `progress` receives the chunks
    that are read, and all, and 0.
    """
    _ = run.store
    if out.suffix.lower() == ".parquet":
        with replacing(out) as temporary:
            _sink(run, temporary, out, progress)
        return 1
    if out.suffix:
        raise InputError(f"{out} ends in {out.suffix}: allowed are .parquet, and a folder")
    if out.is_dir() and any(out.iterdir()):
        raise InputError(f"{out} is not empty: allowed is a new folder, or an empty one")
    count = 0
    with filling(out, []) as folder:
        for count, rows in enumerate(frames(run, told=progress), 1):
            write_frame(folder / f"part-{count - 1:06d}.parquet", rows, csv=False)
    return count


def _sink(run: Run, path: Path, name: Path, told: Told | None) -> None:
    """Write all rows as they are read."""
    import polars as pl

    faults: list[LocosweepError] = []
    try:
        scan(run, faults, told).sink_parquet(path)
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        raise (faults or [InputError(f"{name}: cannot write: {error}")])[0] from None
