"""Linear algebra on one thread.

Its matrices are small here: more threads multiply them no sooner, and where other programs take
the processors, threads that wait for each other use these up. On one thread the last bits do not
depend on the number of processors either.
"""

from __future__ import annotations

from functools import wraps
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable

_P = ParamSpec("_P")
_R = TypeVar("_R")


def on_one_thread(work: Callable[_P, _R]) -> Callable[_P, _R]:
    """Return a function during which the linear algebra of NumPy and SciPy has one thread."""

    @wraps(work)
    def limited(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(limits=1, user_api="blas"):
            return work(*args, **kwargs)

    return limited
