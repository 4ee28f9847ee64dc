"""What Ctrl-C, SIGTERM and SIGHUP do to the command."""

from __future__ import annotations

import os
import signal
import sys
import threading
from typing import Any, NoReturn

INTERRUPTED = 130
_TERMINATED = {"SIGTERM": 143, "SIGHUP": 129}
"""Exit codes: 128 and the signal's number. Not every system knows SIGHUP."""
_IMPATIENT = 3
"""Presses of Ctrl-C that end the process without any cleaning up."""


class _Presses:
    """Presses of Ctrl-C. A plain number: a lock that the main thread holds would wait for ever."""

    count = 0


def listen() -> None:
    """Take over the signals of this process, where it is the main thread that asks.

    Signals that are ignored stay so: Ctrl-C in the background of a script, SIGHUP under nohup.
    """
    _Presses.count = 0
    if threading.current_thread() is not threading.main_thread():
        return
    signal.signal(signal.SIGTERM, _terminate)
    hung_up = getattr(signal, "SIGHUP", None)
    if hung_up is not None and signal.getsignal(hung_up) is not signal.SIG_IGN:
        signal.signal(hung_up, _terminate)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)


def pressed() -> bool:
    """Return whether Ctrl-C was pressed since `listen`."""
    return _Presses.count > 0


def end_at_once(code: int) -> NoReturn:
    """End the process without unloading it.

    A library whose import was cut may bring the interpreter down while it ends. What processes
    have shared is given back first: its tracker would complain of it.
    """
    shared = sys.modules.get("multiprocessing.util")
    if shared is not None:
        shared._exit_function()
    sys.stderr.flush()
    os._exit(code)


def _interrupt(*_: Any) -> None:
    _Presses.count += 1
    if _Presses.count == 1:
        raise KeyboardInterrupt
    # What the first one began, removing temporary files, is not cut by a second.
    if _Presses.count >= _IMPATIENT:
        os._exit(INTERRUPTED)


def _terminate(number: int, _: Any) -> NoReturn:
    # An exception, so that temporary files are removed on the way out.
    raise SystemExit(_TERMINATED[signal.Signals(number).name])
