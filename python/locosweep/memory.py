"""Limit of the memory that a call may take."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path

from locosweep.errors import InputError

_SHARE = 0.8
# Asking the system takes longer than a small sweep does.
_NEGLIGIBLE = 64 << 20


def default_limit() -> int:
    """Return 80 % of the memory that is free now, within the limits of a cgroup and ulimit."""
    free = [_system(), _address_space()]
    for limit, used in (
        ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"),
        (
            "/sys/fs/cgroup/memory/memory.limit_in_bytes",
            "/sys/fs/cgroup/memory/memory.usage_in_bytes",
        ),
    ):
        try:
            free.append(int(Path(limit).read_text()) - int(Path(used).read_text()))
        except (OSError, ValueError):
            continue
    return int(_SHARE * max(0, min(free)))


def _system() -> int:
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    except OSError:
        pass
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return 8 << 30


def _address_space() -> int:
    """Return what `ulimit -v` leaves: an allocation beyond it may end the process."""
    try:
        # Not every system has it.
        resource = importlib.import_module("resource")
        soft, _ = resource.getrlimit(resource.RLIMIT_AS)
        if soft == resource.RLIM_INFINITY:
            return sys.maxsize
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        return int(soft) - pages * int(resource.getpagesize())
    except (ImportError, OSError, ValueError, IndexError):
        return sys.maxsize


_REMEDY = "reduce an axis (over=, reduce=), use dtype='float32', or raise memory_limit="


def check(needed: int, limit: int | None, what: str, remedy: str = _REMEDY) -> None:
    """Refuse before anything is allocated, with what helps against it."""
    if limit is None and needed <= _NEGLIGIBLE:
        return
    allowed = default_limit() if limit is None else limit
    if needed > allowed:
        raise InputError(f"{what} needs {_size(needed)}, the limit is {_size(allowed)}: {remedy}")


def _size(count: int) -> str:
    size = float(count)
    for unit in ("bytes", "kB", "MB", "GB", "TB"):
        if size < 1000 or unit == "TB":
            return f"{size:.4g} {unit}"
        size /= 1000
    return f"{size:.4g} TB"
