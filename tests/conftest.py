"""What tests of several files share."""

from __future__ import annotations

import os
import signal
import sys
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator


# Tests draw without a display.
os.environ.setdefault("MPLBACKEND", "agg")


@pytest.fixture(autouse=True)
def _figures() -> Iterator[None]:
    """Close what a test drew with pyplot, which keeps every figure and warns of many."""
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.fixture(autouse=True)
def _handlers() -> Iterator[None]:
    """Give back the signal handlers that the command sets where a test runs it in here.

    SIGHUP ends what a test starts also where nohup started the tests.
    """
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in numbers}
    if before[signal.SIGHUP] is signal.SIG_IGN:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    # What asks again for an end would come when nobody listens any more.
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def ctrl_c() -> None:
    """Let Ctrl-C interrupt this process and what it starts, as on a terminal.

    A shell starts the background commands of a script with SIGINT ignored, and children
    inherit that: no KeyboardInterrupt would come and no exit code 130. A handler, unlike
    ignoring, is back at its default in a child.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
