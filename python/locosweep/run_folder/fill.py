"""A sweep into a folder: begun or resumed, filled, and returned opened."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from locosweep import _core
from locosweep.errors import InputError
from locosweep.run_folder import arrays
from locosweep.run_folder.begin import begin, prepare
from locosweep.run_folder.cells import Cells
from locosweep.run_folder.commit import sweep_stale
from locosweep.run_folder.name import check_run_name
from locosweep.run_folder.run import Run
from locosweep.run_folder.shards import Order, check_shard
from locosweep.run_folder.state import State
from locosweep.run_folder.writer import Filler, about

if TYPE_CHECKING:
    import os

    from locosweep._core import CancelToken
    from locosweep.grid import Grid
    from locosweep.progress import Progress
    from locosweep.request import Request


@dataclass(frozen=True)
class Options:
    """How to fill a run folder; see `locosweep.sweep`."""

    threads: int | None = None
    chunk: int | None = None
    shard: tuple[int, int] | None = None
    memory_limit: int | None = None
    progress: bool | Progress = False
    token: CancelToken | None = None
    client: Any = None
    allow_drift: bool = False


def sweep_into(
    out: str | os.PathLike[str], request: Request, grid: Grid, dtype: str, options: Options
) -> Run:
    """Compute what a run folder still misses, and return it opened."""
    folder = check_run_name(out)
    check_shard(options.shard)
    if options.client is not None and (options.shard is not None or options.token is not None):
        other = "token" if options.shard is None else "shard"
        raise InputError(f"client and {other} are both given: allowed is one of them")
    cells = Cells(request, grid, dtype)
    threads = _core.threads_to_use(options.threads)
    found, drifted = begin(
        folder, cells, threads, chunk=options.chunk, memory_limit=options.memory_limit,
        allow_drift=options.allow_drift,
    )  # fmt: skip
    prepare(folder, found)
    names = [*arrays.array_names(cells), *cells.axes]
    sweep_stale([folder, folder / arrays.STORE, *(folder / arrays.STORE / name for name in names)])
    if options.client is not None:
        from locosweep.run_folder.over_dask import fill_over_dask

        fill_over_dask(
            folder, found, options.client, options.threads, allow_drift=options.allow_drift,
            progress=options.progress,
        )  # fmt: skip
        return Run(folder)
    state = State(folder, found)
    order = Order(state, options.shard)
    told = about(threads, shard=options.shard, drifted=drifted)
    filler = Filler(folder, found, threads, told, options.token)
    filler.fill(order, order.missing(), options.progress)
    state.refresh(sizes=False)
    return Run(folder, state=state)
