"""Verify a run folder: every file against what manifest and logs say of it; repair."""

from __future__ import annotations

import contextlib
import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

from locosweep import _core
from locosweep.errors import InputError
from locosweep.run_folder import arrays
from locosweep.run_folder.begin import prepare, refuse_drift
from locosweep.run_folder.manifest import read, store_files
from locosweep.run_folder.state import State
from locosweep.run_folder.writer import Filler, about

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path


@dataclass(frozen=True)
class Fault:
    """What is wrong with one file.

    Attributes
    ----------
    file : str
        Its path in the folder.
    chunk : int or None
        The chunk that it belongs to; None for metadata and coordinates.
    what : str
        The fault.
    """

    file: str
    chunk: int | None
    what: str


@dataclass(frozen=True)
class Verified:
    """What `verify` found.

    Attributes
    ----------
    chunks, done : int
        Chunks of the run, and those that logs call done.
    faults : tuple of Fault
        Files that are not as they were written.
    dropped : int
        Lines of logs that were torn or altered; their chunks count as missing.
    """

    chunks: int
    done: int
    faults: tuple[Fault, ...]
    dropped: int


def verify(folder: Path, progress: Callable[[int, int, float], object] | None = None) -> Verified:
    """Read every file of a run and hold it against its hash, its number of bytes and its place.

    Raises
    ------
    DataFileError
        The manifest, which says what all others are, is altered or is not there.
    """
    found = read(folder)
    state = State(folder, found)
    faults = []
    for path, content in store_files(found).items():
        fault = _compare(folder / arrays.STORE / path, hashlib.sha256(content).hexdigest())
        if fault:
            faults.append(Fault(f"{arrays.STORE}/{path}", None, fault))
    logged = sorted({*state.done, *state.damaged})
    for number, chunk in enumerate(logged, 1):
        for name in state.array_names:
            path = f"{arrays.STORE}/{name}/{found.plan.key(chunk)}"
            fault = _compare(folder / path, *state.hashes(chunk, name))
            if fault:
                faults.append(Fault(path, chunk, fault))
        if progress is not None:
            progress(number, len(logged), 0.0)
    dropped = sum(writer.dropped for writer in state.writers)
    return Verified(found.plan.count, len(logged), tuple(faults), dropped)


def _compare(path: Path, *wanted: str) -> str | None:
    """Say what is wrong with a file that may have any of these hashes."""
    try:
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    except FileNotFoundError:
        return "not there"
    except OSError as error:
        raise InputError(f"{path}: cannot read: {error.strerror or error}") from None
    return None if digest in wanted else "altered (hash differs)"


def repair(
    folder: Path, verified: Verified, threads: int | None = None, *, allow_drift: bool = False
) -> int:
    """Compute damaged chunks again and write metadata anew; return how many files.

    Refused where this version gives other bits than those that are there, without `allow_drift`.
    """
    found = read(folder)
    if not allow_drift:
        refuse_drift(folder, found, found.cells.probe())
    for fault in verified.faults:
        with _refusing(folder / fault.file), contextlib.suppress(FileNotFoundError):
            (folder / fault.file).unlink()
    prepare(folder, found)
    chunks = sorted({fault.chunk for fault in verified.faults if fault.chunk is not None})
    count = _core.threads_to_use(threads)
    Filler(folder, found, count, about(count)).fill(chunks, chunks)
    return len(verified.faults)


@contextlib.contextmanager
def _refusing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot remove: {error.strerror or error}") from None
