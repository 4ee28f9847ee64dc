"""Logs of a run: which chunks are done, by whom, with the hash of each file.

A writer appends to a log of its own, so that no file is appended to by two machines. A torn or
altered line counts as not written.
"""

from __future__ import annotations

import contextlib
import io
import os
import secrets
import time
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from locosweep.errors import InputError
from locosweep.run_folder.commit import WRITING, host, sync_folders
from locosweep.run_folder.faults import step
from locosweep.run_folder.log_lines import Done, Reader, line_of

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path


@dataclass
class Writer:
    """What one log says."""

    name: str
    about: dict[str, Any]
    done: list[Done] = field(default_factory=list)
    dropped: int = 0
    """Lines that were torn or altered."""

    def take(self, said: Done | dict[str, Any] | None) -> None:
        """Add what one line says."""
        if said is None:
            self.dropped += 1
        elif isinstance(said, Done):
            self.done.append(said)
        else:
            self.about = said


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
        self._write(b"".join(line_of(line) for line in lines))

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


def read_logs(folder: Path, names: Sequence[str]) -> list[Writer]:
    """Read all logs of a run of arrays `names`; what is torn or altered is dropped and counted."""
    found = []
    reader = Reader(names)
    try:
        paths = sorted(p for p in folder.iterdir() if p.suffix == ".jsonl")
    except FileNotFoundError:
        return []
    except OSError as error:
        raise InputError(f"{folder}: cannot read: {error.strerror or error}") from None
    for path in paths:
        try:
            content = io.BytesIO(path.read_bytes())
        except OSError as error:
            raise InputError(f"{path}: cannot read: {error.strerror or error}") from None
        writer = Writer(path.stem, {})
        for line in content:
            if line != b"\n":
                writer.take(reader.read(line.rstrip(b"\n")))
        found.append(writer)
    return found
