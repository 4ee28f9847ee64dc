"""The fault hook of tests: fails or kills this process at a named step of a commit."""

from __future__ import annotations

import os
import re
import signal
import threading

from locosweep.errors import InputError

STEPS = (
    "manifest", "metadata", "write", "half_written", "fsync", "rename", "folder", "log",
    "half_logged", "logged",
)  # fmt: skip
"""Each is passed just before it is taken; half_written and half_logged in its middle."""
_VARIABLE = "LOCOSWEEP_FAULT"
_FORM = re.compile(r"(kill|[0-9]{1,3})@([a-z_]+):([0-9]{1,9})")
_passed: dict[str, int] = {}
_lock = threading.Lock()


def step(name: str) -> None:
    """Pass a step: ``LOCOSWEEP_FAULT=ACTION@STEP:N`` acts at its N-th time in this process.

    ACTION is ``kill`` (SIGKILL), or the number of an error that the system would give.
    """
    wanted = os.environ.get(_VARIABLE)
    if not wanted:
        return
    form = _FORM.fullmatch(wanted)
    if form is None or form[2] not in STEPS:
        raise InputError(f"{_VARIABLE} is {wanted!r}: allowed is kill@STEP:N or ERRNO@STEP:N")
    if form[2] != name:
        return
    with _lock:
        _passed[name] = _passed.get(name, 0) + 1
        due = _passed[name] == int(form[3])
    if due and form[1] == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    elif due:
        raise OSError(int(form[1]), os.strerror(int(form[1])))
