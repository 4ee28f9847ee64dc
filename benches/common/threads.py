"""How many threads a peer may use, set outside of the measured time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


def thread_counts() -> tuple[int, ...]:
    """One thread, and two where the machine has them."""
    return (1, 2) if len(os.sched_getaffinity(0)) > 1 else (1,)


@contextmanager
def numba_threads(count: int) -> Iterator[None]:
    """Let numba use this many threads."""
    import numba

    before = numba.get_num_threads()
    numba.set_num_threads(count)
    try:
        yield
    finally:
        numba.set_num_threads(before)


@contextmanager
def one_processor() -> Iterator[None]:
    """Keep all threads on one processor: JAX and BLAS cannot change their number later."""
    allowed = os.sched_getaffinity(0)
    _pin({min(allowed)})
    try:
        yield
    finally:
        _pin(allowed)


def _pin(processors: set[int]) -> None:
    for thread in Path("/proc/self/task").iterdir():
        try:
            os.sched_setaffinity(int(thread.name), processors)
        except ProcessLookupError:
            continue
