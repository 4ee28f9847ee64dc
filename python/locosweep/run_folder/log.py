"""Logs of a run: which chunks are done, by whom, with the hash of each file.

A writer appends to a log of its own, so that no file is appended to by two machines. A line
is JSON, a tab and its CRC-32: a torn or altered line counts as not written.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import secrets
import time
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from locosweep.errors import InputError
from locosweep.run_folder.commit import WRITING, host, sync_folders
from locosweep.run_folder.faults import step

if TYPE_CHECKING:
    from collections.abc import Sequence


class Done(NamedTuple):
    """One finished chunk.

    Attributes
    ----------
    files : dict of str to (str, int)
        SHA-256 and bytes of each file, by the name of its array.
    counts : dict of str to dict of str to int
        Cells of each status code, by output.
    seconds : float
        What it took to compute.
    """

    chunk: int
    files: dict[str, tuple[str, int]]
    counts: dict[str, dict[str, int]]
    seconds: float
    at: float = 0.0


@dataclass
class Writer:
    """What one log says."""

    name: str
    about: dict[str, Any]
    done: list[Done] = field(default_factory=list)
    dropped: int = 0
    """Lines that were torn or altered."""


class Log:
    """The log of this writer, made with its first line."""

    def __init__(self, folder: Path, about: dict[str, Any]) -> None:
        self._folder = folder
        self._about = about
        self._handle: int | None = None
        self._path = folder

    def append(self, finished: Sequence[Done]) -> None:
        """Append finished chunks, one line each, and bring them to the disk."""
        lines = [] if self._handle is not None else [self._open()]
        for one in finished:
            lines.append(
                {"chunk": one.chunk, "files": one.files, "counts": one.counts,
                 "seconds": round(one.seconds, 6), "at": round(time.time(), 3)}
            )  # fmt: skip
        self._write(b"".join(_line(line) for line in lines))

    def _open(self) -> dict[str, Any]:
        name = f"{host()}-{os.getpid()}-{time.strftime('%Y%m%dT%H%M%S', time.gmtime())}"
        self._path = self._folder / f"{name}-{secrets.token_hex(2)}.jsonl"
        try:
            self._handle = os.open(self._path, WRITING | os.O_APPEND, 0o666)
        except OSError as error:
            raise InputError(f"{self._path}: cannot write: {error.strerror or error}") from None
        sync_folders([self._folder])
        return {"writer": host(), "pid": os.getpid(), "at": round(time.time(), 3), **self._about}

    def _write(self, text: bytes) -> None:
        handle = self._handle
        if handle is None:
            raise AssertionError("a log that is not open")
        before = os.fstat(handle).st_size
        try:
            step("log")
            for part in (text[: len(text) // 2], text[len(text) // 2 :]):
                rest = part
                while rest:
                    rest = rest[os.write(handle, rest) :]
                step("half_logged")
            os.fsync(handle)
            step("logged")
        except OSError as error:
            # Half a line would be dropped on reading, but the next one would join it.
            with contextlib.suppress(OSError):
                os.ftruncate(handle, before)
            raise InputError(
                f"{self._path}: cannot write {len(text)} bytes: {error.strerror or error}"
            ) from None

    def close(self) -> None:
        """Close the file."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None


def _line(record: dict[str, Any]) -> bytes:
    text = json.dumps(record, separators=(",", ":")).encode()
    return text + b"\t%08x\n" % zlib.crc32(text)


def read_logs(folder: Path) -> list[Writer]:
    """Read all logs; what is torn or altered is dropped and counted."""
    found = []
    try:
        paths = sorted(p for p in folder.iterdir() if p.suffix == ".jsonl")
    except FileNotFoundError:
        return []
    except OSError as error:
        raise InputError(f"{folder}: cannot read: {error.strerror or error}") from None
    for path in paths:
        try:
            content = path.read_bytes()
        except OSError as error:
            raise InputError(f"{path}: cannot read: {error.strerror or error}") from None
        writer = Writer(path.stem, {})
        for line in content.split(b"\n"):
            if line:
                _take(line, writer)
        found.append(writer)
    return found


def _take(line: bytes, writer: Writer) -> None:
    text, tab, check = line.rpartition(b"\t")
    if not tab or check != b"%08x" % zlib.crc32(text):
        writer.dropped += 1
        return
    try:
        record = json.loads(text.decode())
        if "chunk" not in record:
            writer.about = {**record, "at": _finite(record.get("at", 0.0))}
            return
        files = {n: (str(sha), int(size)) for n, (sha, size) in record["files"].items()}
        counts = {
            name: {code: int(n) for code, n in codes.items()}
            for name, codes in record["counts"].items()
        }
        done = Done(
            int(record["chunk"]), files, counts, _finite(record["seconds"]), _finite(record["at"])
        )
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError):
        writer.dropped += 1
        return
    writer.done.append(done)


def _finite(value: Any) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(value)
    return number
