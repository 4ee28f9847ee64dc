"""Work over processes, and whether what they left is of the same code."""

from __future__ import annotations

import contextlib
import hashlib
import multiprocessing
import os
import signal
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

from locosweep import _core

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["code_digest", "pool_of"]

_PACKAGE = Path(__file__).parents[1]


def code_digest(*parts: str) -> str:
    """Hash of the extension and of the named folders and files of the package.

    Results of other code are not kept.
    """
    files = [Path(_core.__file__)]
    for part in parts:
        place = _PACKAGE / part
        files += sorted(place.rglob("*.py")) if place.is_dir() else [place]
    whole = hashlib.sha256()
    for file in files:
        whole.update(file.read_bytes())
    return whole.hexdigest()


@contextlib.contextmanager
def pool_of(processes: int) -> Iterator[ProcessPoolExecutor]:
    """Yield processes that end at once with Ctrl-C or an error in one of them."""
    context = multiprocessing.get_context("spawn")
    # One thread each: as many processes as threads were asked for.
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "POLARS_MAX_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    # Ctrl-C reaches a whole group of processes: the first of them ends the others.
    pool = ProcessPoolExecutor(
        processes, context, initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN)
    )
    try:
        yield pool
        pool.shutdown()
    except BaseException:
        # Their work is written whole or not at all, so it may be cut.
        for process in list(getattr(pool, "_processes", {}).values()):
            process.terminate()
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
