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

_PACKAGE = Path(__file__).parents[1]


def code_digest(*parts: str, engine: bool) -> str:
    """Hash of the named folders and files of the package, and of what they run on.

    Results of other code are not kept. That is the whole extension with `engine`,
    without it only the reality, which the engine has no part in, and what rows of
    effects say of rivals.
    """
    files = []
    for part in parts:
        place = _PACKAGE / part
        files += sorted(place.rglob("*.py")) if place.is_dir() else [place]
    rivals = [
        (e.name, e.needs, e.error_of, e.drawn, e.one_sided, e.over, e.spanned, e.refined,
         [(fit.name, fit.only_with, fit.rival) for fit in e.fits])
        for e in _core.effects()
    ]  # fmt: skip
    reality = f"{_core.reality_source()}{rivals}".encode()
    below = Path(_core.__file__).read_bytes() if engine else reality
    whole = hashlib.sha256(below)
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
