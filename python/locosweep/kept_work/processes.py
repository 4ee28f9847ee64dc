"""Work over processes, and a digest of the code that their results depend on."""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import signal
import threading
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from locosweep import _core
from locosweep.run_folder.shards import dealt

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import Any

_Found = TypeVar("_Found")

_PACKAGE = Path(__file__).parents[1]
_PAUSE = 0.1
"""Seconds until the process that waits for others looks for Ctrl-C: less than the 0.25 s within
which it has to end."""


def code_digest(*parts: str, engine: bool) -> str:
    """Hash of the named folders and files of the package, and of what they run on.

    Results of other code are not kept. That is the whole extension with `engine`,
    without it only the reality, which the engine has no part in, and what rows of
    effects say of rivals.
    """
    files: list[Path] = []
    for path in (_PACKAGE / part for part in parts):
        files += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    rivals = [
        (e.name, e.needs, e.error_of, e.drawn, e.one_sided, e.over, e.spanned, e.refined,
         [(fit.name, fit.only_with, fit.rival) for fit in e.fits])
        for e in _core.effects()
    ]  # fmt: skip
    reality = f"{_core.reality_source()}{rivals}".encode()
    whole = hashlib.sha256(Path(_core.__file__).read_bytes() if engine else reality)
    for file in files:
        whole.update(file.read_bytes())
    return whole.hexdigest()


def _begin() -> None:
    """Make a worker of this process: Ctrl-C is its parent's, whose end is its own, too."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        # Work is written whole or not at all, so it may be cut.
        os._exit(1)


def over_processes(
    function: Callable[..., _Found],
    calls: Sequence[tuple[Any, ...]],
    processes: int,
    progress: Callable[[int, int], object] | None = None,
    shard: tuple[int, int] | None = None,
    each: Callable[[int, _Found], object] | None = None,
) -> list[_Found]:
    """Call a function with each tuple of arguments; return the results in their order.

    Processes end at once with Ctrl-C, an error in one of them, or the process that asked,
    however that ended.

    Parameters
    ----------
    function : callable
        Of a module. With a shard it returns at once what another process has done and kept.
    calls : sequence of tuple
        Arguments of each call.
    processes : int
        How many there are.
    progress : callable, optional
        Receives how many calls are done, and all.
    shard : (int, int), optional
        (i, n): every n-th call from the i-th on comes first, then the others from the end.
    each : callable, optional
        Receives number and result of each call as it ends.
    """
    # One thread each: as many processes as threads were asked for.
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "POLARS_MAX_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    # Ctrl-C reaches a whole group of processes: the first of them ends the others.
    pool = ProcessPoolExecutor(
        processes, multiprocessing.get_context("spawn"),
        initializer=_begin,
    )  # fmt: skip
    try:
        order = dealt(len(calls), shard or (0, 1))
        given = {pool.submit(function, *calls[i]): i for i in order}
        left, found = set(given), dict[int, _Found]()
        while left:
            # A signal that another thread receives does not wake this one, which handles it.
            ended, left = wait(left, timeout=_PAUSE, return_when=FIRST_COMPLETED)
            for future in ended:
                found[given[future]] = future.result()
                if each is not None:
                    each(given[future], found[given[future]])
                if progress is not None:
                    progress(len(found), len(given))
        pool.shutdown()
    except BaseException:
        # Their work is written whole or not at all, so it may be cut.
        for process in list(getattr(pool, "_processes", {}).values()):
            process.terminate()
        # They are gone at once: waiting for it gives back what was shared with them.
        pool.shutdown(cancel_futures=True)
        raise
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
    return [found[i] for i in range(len(calls))]
