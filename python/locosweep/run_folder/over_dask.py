"""Fill a run folder by the workers of a Dask cluster, all of which see the folder.

A task is a chunk: a worker computes it, commits its files and its log line, and answers with a
few numbers. No array crosses the network, and a worker that dies costs its chunk.
"""

from __future__ import annotations

import secrets
import threading
import time
from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from locosweep.errors import DataFileError, InputError
from locosweep.run_folder import arrays
from locosweep.run_folder.begin import refuse_drift
from locosweep.run_folder.chunk_files import commit_chunk, count_statuses
from locosweep.run_folder.commit import sync_folders
from locosweep.run_folder.log import Log
from locosweep.run_folder.log_lines import Done
from locosweep.run_folder.manifest import LOGS, read
from locosweep.run_folder.state import State, keeping
from locosweep.run_folder.work_done import WorkDone
from locosweep.run_folder.writer import about

if TYPE_CHECKING:
    from collections.abc import Generator

    from locosweep.progress import Progress
    from locosweep.run_folder.manifest import Manifest

MOST_AT_ONCE = 10_000
"""Tasks that a scheduler is given at once: of 100 000 none began for 40 to 90 s
(dask/distributed#2181)."""
_RETRIES = 3
"""Times that a chunk is given to another worker; a worker may reach its time limit."""


@dataclass(frozen=True)
class Task:
    """What a worker has to know of a run.

    Attributes
    ----------
    folder : str
        Its absolute path, the same on all machines.
    spec_sha256 : str
        Which run that has to be.
    threads : int
        Threads of one chunk.
    allow_drift : bool
        Whether a worker may compute other bits than the version that began the run.
    call : str
        Which call gave it: a folder of the same name may be another one by the next call.
    """

    folder: str
    spec_sha256: str
    threads: int
    allow_drift: bool
    call: str


class _Site:
    """A run as one worker process sees it: manifest and a log of its own."""

    def __init__(self, task: Task) -> None:
        self.folder = Path(task.folder)
        self.manifest = read(self.folder)
        if self.manifest.spec_sha256 != task.spec_sha256:
            raise DataFileError(f"{self.folder}: a worker sees another run there: share the folder")
        if not task.allow_drift:
            refuse_drift(self.folder, self.manifest, self.manifest.cells.probe())
        self.lock = threading.Lock()
        self.log = Log(self.folder / LOGS, about(task.threads, dask=True))


_sites: dict[str, tuple[Task, _Site]] = {}
"""Of each folder the last task and what the worker knows for it."""
_sites_lock = threading.Lock()


def _site(task: Task) -> _Site:
    # Threads of one worker that begin at once would otherwise make a log each.
    with _sites_lock:
        known, site = _sites.get(task.folder, (None, None))
        if site is not None and known == task:
            return site
        if site is not None:
            with site.lock:
                site.log.close()
        _sites[task.folder] = task, _Site(task)
        return _sites[task.folder][1]


def compute_chunk(task: Task, chunk: int) -> tuple[int, int]:
    """Compute and commit a chunk on a worker; return its number and its cells without a value."""
    site = _site(task)
    cells, plan = site.manifest.cells, site.manifest.plan
    begin = time.perf_counter()
    blocks = cells.block(plan.slices(chunk), task.threads)
    seconds = time.perf_counter() - begin
    files = commit_chunk(site.folder, plan, cells, chunk, blocks)
    with site.lock:
        sync_folders(site.folder / arrays.STORE / name for name in arrays.array_names(cells))
        site.log.append([Done(chunk, files, count_statuses(cells, blocks), seconds)])
    return chunk, int((blocks[0][1] != 0).sum())


def fill_over_dask(
    folder: Path,
    found: Manifest,
    client: Any,
    threads: int | None,
    *,
    allow_drift: bool,
    progress: bool | Progress,
) -> None:
    """Have workers compute all that is missing; raise what stopped it, with chunks kept."""
    # Dask gives a worker as many tasks as it has threads.
    call = secrets.token_hex(4)
    task = Task(str(folder.absolute()), found.spec_sha256, threads or 1, allow_drift, call)
    missing = State(folder, found).missing
    work = WorkDone(found.cells, found.plan, missing, progress)
    try:
        # Closed, so that what was given is taken back at once where something stops the loop.
        with keeping(folder, found), closing(_answers(client, task, missing)) as answers:
            for chunk, without in answers:
                work.finish(chunk, without)
    finally:
        work.close()


def _answers(client: Any, task: Task, chunks: list[int]) -> Generator[tuple[int, int]]:
    """Give chunks to the workers, so many at a time, and yield their answers as they come."""
    distributed = arrays.need("distributed", "dask")
    # New names: a scheduler remembers the answers of a call that is still open elsewhere.
    prefix = f"locosweep-{task.spec_sha256[:8]}-{task.call}"
    left = iter(chunks)

    def some(count: int) -> list[Any]:
        batch = list(islice(left, count))
        keys = [f"{prefix}-{chunk}" for chunk in batch]
        found: list[Any] = client.map(
            compute_chunk, [task] * len(batch), batch, key=keys, retries=_RETRIES, pure=False
        )
        return found

    first = some(MOST_AT_ONCE)
    given = set(first)
    waiting = distributed.as_completed(first, loop=client.loop)
    try:
        for future in waiting:
            given.discard(future)
            yield _answer(future, distributed)
            for more in some(1):
                given.add(more)
                waiting.add(more)
    finally:
        if given:
            client.cancel(list(given))


def _answer(future: Any, distributed: Any) -> tuple[int, int]:
    try:
        answer: tuple[int, int] = future.result()
    except distributed.KilledWorker as error:
        raise InputError(
            f"{error.allowed_failures + 1} workers ended while they had chunk "
            f"{str(error.task).rpartition('-')[2]}: by a limit of time or memory, or killed"
        ) from None
    return answer
