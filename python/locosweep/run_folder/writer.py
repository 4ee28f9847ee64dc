"""One process that fills a run folder: it computes while its threads write."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.errors import Cancelled
from locosweep.run_folder import arrays
from locosweep.run_folder.cells import NUMERICS_VERSION
from locosweep.run_folder.chunk_files import commit_chunk, count_statuses
from locosweep.run_folder.commit import sync_folders
from locosweep.run_folder.log import Log
from locosweep.run_folder.log_lines import Done
from locosweep.run_folder.manifest import LOGS
from locosweep.run_folder.plan import HELD
from locosweep.run_folder.state import keeping
from locosweep.run_folder.work_done import WorkDone

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    from locosweep._core import CancelToken
    from locosweep.progress import Progress
    from locosweep.run_folder.cells import Block
    from locosweep.run_folder.manifest import Manifest

_WRITERS = 2
"""Threads that hash and write: one hashes while the other one waits for the disk."""
_PATIENCE = 0.15
"""Seconds that an end waits for files in the middle of being written."""


def about(threads: int, **more: object) -> dict[str, Any]:
    """Return what a log says of its writer."""
    return {
        "locosweep": _core.version(), "numerics_version": NUMERICS_VERSION,
        "simd": _core.simd_level(), "threads": threads, **more,
    }  # fmt: skip


class Filler:
    """One process that fills a run: this thread computes, others write.

    Parameters
    ----------
    folder : Path
        The run, begun.
    found : Manifest
        Its manifest.
    threads : int
        Threads that compute a chunk.
    about : dict
        What the log says of this writer.
    token : CancelToken, optional
        Stops it from another thread.
    """

    def __init__(
        self,
        folder: Path,
        found: Manifest,
        threads: int,
        about: dict[str, Any],
        token: CancelToken | None = None,
    ) -> None:
        self._folder = folder
        self._manifest = found
        self._cells = found.cells
        self._threads = threads
        self._token = token
        self._roots = [folder / arrays.STORE / name for name in arrays.array_names(found.cells)]
        self._log = Log(folder / LOGS, about)
        self._lock = threading.Lock()
        self._waiting: queue.SimpleQueue[tuple[int, list[Block], float] | None] = (
            queue.SimpleQueue()
        )
        # Not Thread.join: before Python 3.13, one that a signal interrupts takes its thread for
        # ended, and the end of this process would cut what that is writing.
        self._ended: queue.SimpleQueue[None] = queue.SimpleQueue()
        self._writing = 0
        self._room = threading.Semaphore(HELD - 1)
        self._renamed: deque[Done] = deque()
        self._stopped = False
        self._fault: BaseException | None = None

    def fill(
        self, chunks: Iterable[int], expected: Sequence[int], progress: bool | Progress = False
    ) -> None:
        """Compute and commit chunks; raise what stopped it, with those that are done kept.

        `expected` is what `chunks` will give, as far as it is known, for the progress.
        """
        work = WorkDone(self._cells, self._manifest.plan, expected, progress)
        for _ in range(_WRITERS):
            threading.Thread(target=self._write_all, daemon=True).start()
            self._writing += 1
        try:
            with keeping(self._folder, self._manifest):
                self._fill(chunks, work)
        finally:
            work.close()
        self._log.close()

    def _fill(self, chunks: Iterable[int], work: WorkDone) -> None:
        try:
            for chunk in chunks:
                self._compute(chunk, work)
            self._end_writers()
            self._raise_fault()
        except BaseException:
            self._stopped = True
            # One that waits for the disk is left to end with the process.
            self._end_writers(_PATIENCE)
            raise

    def _compute(self, chunk: int, work: WorkDone) -> None:
        self._room.acquire()
        self._raise_fault()
        begin = time.perf_counter()
        blocks = self._cells.block(
            self._manifest.plan.slices(chunk), self._threads, work.within, self._token
        )
        self._waiting.put((chunk, blocks, time.perf_counter() - begin))
        work.finish(chunk, int(np.count_nonzero(blocks[0][1])))

    def _raise_fault(self) -> None:
        if self._fault is not None:
            raise self._fault

    def _end_writers(self, patience: float = math.inf) -> None:
        """Wait until the writers have done what waits for them, so many seconds at most."""
        for _ in range(_WRITERS):
            self._waiting.put(None)
        until = time.monotonic() + patience
        while self._writing:
            left = until - time.monotonic()
            try:
                self._ended.get(timeout=None if math.isinf(left) else max(0.0, left))
            except queue.Empty:
                return
            self._writing -= 1

    def _write_all(self) -> None:
        try:
            self._write_waiting()
        finally:
            self._ended.put(None)

    def _write_waiting(self) -> None:
        while (item := self._waiting.get()) is not None:
            try:
                if not self._stopped:
                    self._commit(*item)
            except BaseException as error:
                # Raised again by the thread that computes.
                if not isinstance(error, Cancelled):
                    self._fault = self._fault or error
                self._stopped = True
            finally:
                del item
                self._room.release()

    def _commit(self, chunk: int, blocks: list[Block], seconds: float) -> None:
        counts = count_statuses(self._cells, blocks)
        plan = self._manifest.plan
        files = commit_chunk(self._folder, plan, self._cells, chunk, blocks, lambda: self._stopped)
        self._renamed.append(Done(chunk, files, counts, seconds))
        with self._lock:
            # What other threads renamed meanwhile goes along. The queue is emptied, not replaced: a
            # thread that is about to append would append to the old one, which nobody reads.
            batch = [self._renamed.popleft() for _ in range(len(self._renamed))]
            if batch:
                sync_folders(self._roots)
                self._log.append(batch)
