"""What Ctrl-C, SIGTERM and SIGHUP do to the command."""

from __future__ import annotations

import os
import signal
import sys
import threading
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from collections.abc import Callable

INTERRUPTED = 130
_TERMINATED = {"SIGTERM": 143, "SIGHUP": 129}
"""Exit codes: 128 and the signal's number. Not every system knows SIGHUP."""
_IMPATIENT = 3
"""Presses of Ctrl-C that end the process without any cleaning up."""


_LOOK = 0.05
"""Seconds between looks at whether an end was heeded, of the quarter within which it has to be."""


class _Presses:
    """Presses of Ctrl-C. A plain number: a lock that the main thread holds would wait for ever."""

    count = 0


class _End:
    """The exception that ends this process, once a signal asked for it."""

    asked: BaseException | None = None


_before: dict[int, Any] = {}
"""What answered each signal before the command took it over."""


def listen() -> None:
    """Take over the signals of this process, where it is the main thread that asks.

    Signals that are ignored stay so: Ctrl-C in the background of a script, SIGHUP under nohup.
    `leave` gives them back.
    """
    _Presses.count = 0
    rest()
    if not _is_main():
        return
    _take(signal.SIGTERM, _terminate)
    hung_up = getattr(signal, "SIGHUP", None)
    if hung_up is not None and signal.getsignal(hung_up) is not signal.SIG_IGN:
        _take(hung_up, _terminate)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        _take(signal.SIGINT, _interrupt)
    if hasattr(signal, "SIGALRM"):
        _take(signal.SIGALRM, _look)


def _take(number: int, answer: Callable[..., Any]) -> None:
    _before.setdefault(number, signal.signal(number, answer))


def leave() -> None:
    """Give the signals back: those that come later are for whoever called the command.

    Its own process unloads then. A timer that SIGTERM starts there would end it as SIGALRM does,
    since an interpreter that ends has no handlers left.
    """
    if not _is_main():
        return
    alarm = _before.pop(getattr(signal, "SIGALRM", -1), None)
    try:
        while _before:
            _give(*_before.popitem())
    finally:
        # After the signals that start the timer, and also where one of them came just now.
        rest()
        if alarm is not None:
            _give(signal.SIGALRM, alarm)


def _give(number: int, answer: Any) -> None:
    # One that was not set by Python reads as None, and cannot be set by it.
    if answer is not None:
        signal.signal(number, answer)


def _is_main() -> bool:
    return threading.current_thread() is threading.main_thread()


def pressed() -> bool:
    """Return whether Ctrl-C was pressed since `listen`."""
    return _Presses.count > 0


def terminated() -> int | None:
    """Return the exit code of the signal that asked this process to end, None without one."""
    return _End.asked.code if isinstance(_End.asked, SystemExit) else None  # type: ignore[return-value]


def rest() -> None:
    """Ask no more: the end is under way."""
    _End.asked = None
    if hasattr(signal, "setitimer") and _is_main():
        signal.setitimer(signal.ITIMER_REAL, 0.0)


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
        _end(KeyboardInterrupt())
    # What the first one began, removing temporary files, is not cut by a second.
    if _Presses.count >= _IMPATIENT:
        os._exit(INTERRUPTED)


def _terminate(number: int, _: Any) -> NoReturn:
    # An exception, so that temporary files are removed on the way out.
    _end(SystemExit(_TERMINATED[signal.Signals(number).name]))


def _end(error: BaseException) -> NoReturn:
    """Raise what ends this process, and look later whether that was heeded.

    What is raised while an object is given up, or a library calls back, is lost: SIGTERM while
    a picture was drawn ended nothing.
    """
    _End.asked = error
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, _LOOK, _LOOK)
    raise error


def _look(*_: Any) -> None:
    """Raise once more what was lost; what is on its way out, cleaning up, is not cut."""
    asked, handled = _End.asked, sys.exc_info()[1]
    while handled is not None and handled is not asked:
        handled = handled.__context__
    if asked is not None and handled is None:
        raise asked
