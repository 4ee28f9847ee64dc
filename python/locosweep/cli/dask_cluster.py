"""The connection of a command to a Dask cluster."""

from __future__ import annotations

import contextlib
import logging
from typing import TYPE_CHECKING, Any

from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator

_SECONDS = 10
"""A scheduler on the same network answers within one."""


@contextlib.contextmanager
def cluster(scheduler: str | None) -> Iterator[Any]:
    """Yield a client of a scheduler, None without an address."""
    if scheduler is None:
        yield None
        return
    try:
        import distributed
    except ModuleNotFoundError:
        raise InputError("--dask needs Dask: pip install locosweep[dask]") from None
    connect: Any = distributed.Client
    # Its errors come as exceptions; what it logs beside them would be further lines.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        client = connect(scheduler, timeout=_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(f"--dask {scheduler}: no scheduler answers: {error}") from None
    with client:
        yield client
