"""Commit of a file: whole under its name and on the disk, or not there at all."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import shutil
import socket
import time
from pathlib import Path
from typing import TYPE_CHECKING

from locosweep.errors import Cancelled, InputError
from locosweep.run_folder.faults import step

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

_PIECE = 4 << 20
"""Bytes between two looks at whether to stop: 15 ms at 265 MB/s."""
WRITING = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
"""Flags of a new file; Windows would otherwise turn bytes that look like line ends into two."""
_PARTIAL = re.compile(r"\.(?P<host>[^.]+)-(?P<pid>\d+)-[0-9a-f]+\.partial$")
_NO_LINKS = {
    errno.EPERM, errno.EACCES, errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP,
    errno.EMLINK, errno.EXDEV,
}  # fmt: skip
"""What file systems without hard links answer: FAT, some of networks, clouds and telephones."""
_TURN_SECONDS = 10.0
"""Seconds that one process waits for another one to look and rename, which takes milliseconds."""
_TURN_PAUSE = 0.02
"""Seconds between two looks at the file of turns."""


def host() -> str:
    """Name of this machine as it stands in file names."""
    return re.sub(r"[^A-Za-z0-9]+", "_", socket.gethostname()) or "host"


def write_file(
    path: Path, parts: Sequence[bytes | memoryview], stop: Callable[[], bool] | None = None
) -> None:
    """Write a file beside its name, bring it to the disk and rename it; the folder is not yet."""
    partial = beside(path)
    with _refusing(path, parts):
        try:
            step("write")
            _write(partial, parts, stop)
            step("rename")
            partial.replace(path)
        except BaseException:
            with contextlib.suppress(OSError):
                partial.unlink(missing_ok=True)
            raise


def beside(path: Path) -> Path:
    """Return a name beside a path that tells who writes there, for `sweep_stale`."""
    return path.with_name(f"{path.name}.{host()}-{os.getpid()}-{secrets.token_hex(4)}.partial")


@contextlib.contextmanager
def _refusing(path: Path, parts: Sequence[bytes | memoryview]) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        size = sum(len(part) for part in parts)
        raise InputError(f"{path}: cannot write {size} bytes: {error.strerror or error}") from None


def _write(
    path: Path, parts: Sequence[bytes | memoryview], stop: Callable[[], bool] | None
) -> None:
    handle = os.open(path, WRITING, 0o666)
    try:
        written = 0
        for part in parts:
            view = memoryview(part).cast("B")
            while len(view):
                if stop is not None and stop():
                    raise Cancelled("stopped")
                count = os.write(handle, view[:_PIECE])
                # Lets the disk begin, so that little is left for fsync, which nothing can stop.
                if hasattr(os, "posix_fadvise"):
                    os.posix_fadvise(handle, written, count, os.POSIX_FADV_DONTNEED)
                written += count
                view = view[count:]
                step("half_written")
        step("fsync")
        # An error here may be told once only: it is never tried again.
        os.fsync(handle)
    finally:
        os.close(handle)


def write_first(path: Path, content: bytes) -> None:
    """Write a file that stays as the first of several writers at once left it."""
    partial = beside(path)
    with _refusing(path, [content]):
        try:
            _write(partial, [content], None)
            step("manifest")
            # A link, unlike renaming, does not replace what another one made meanwhile.
            try:
                os.link(partial, path)
            except FileExistsError:
                pass
            except OSError as error:
                if error.errno not in _NO_LINKS:
                    raise
                _rename_first(partial, path)
        finally:
            partial.unlink(missing_ok=True)
    sync_folders([path.parent])


def _rename_first(partial: Path, path: Path) -> None:
    """Rename a file unless its name is taken, where the file system has no links.

    Renaming replaces, so that one process at a time looks and renames: the one that made the
    file of turns. One that dies within leaves it, and nobody can tell that from a slow one.
    """
    turn = path.with_name(f"{path.name}.turn.partial")
    until = time.monotonic() + _TURN_SECONDS
    while not path.exists():
        try:
            os.close(os.open(turn, WRITING, 0o666))
        except FileExistsError:
            if time.monotonic() > until:
                raise InputError(
                    f"{path}: another process began to write it and did not end: if none runs, "
                    f"remove {turn} and try again"
                ) from None
            time.sleep(_TURN_PAUSE)
            continue
        try:
            if not path.exists():
                partial.replace(path)
        finally:
            turn.unlink(missing_ok=True)


def sync_folders(folders: Iterable[Path]) -> None:
    """Bring the names in folders to the disk, where the system lets folders be opened."""
    directory = getattr(os, "O_DIRECTORY", None)
    for folder in dict.fromkeys(folders):
        try:
            step("folder")
            if directory is None:
                continue
            handle = os.open(folder, os.O_RDONLY | directory)
            try:
                os.fsync(handle)
            finally:
                os.close(handle)
        except OSError as error:
            raise InputError(f"{folder}: cannot write: {error.strerror or error}") from None


def sweep_stale(folders: Iterable[Path]) -> int:
    """Remove what dead writers of this machine left half-written; return how many."""
    removed = 0
    for folder in folders:
        with contextlib.suppress(OSError), os.scandir(folder) as entries:
            for entry in entries:
                found = _PARTIAL.search(entry.name)
                if found and found["host"] == host() and not _is_alive(int(found["pid"])):
                    with contextlib.suppress(OSError):
                        if entry.is_dir(follow_symlinks=False):
                            shutil.rmtree(entry.path)
                        else:
                            Path(entry.path).unlink()
                        removed += 1
    return removed


def _is_alive(pid: int) -> bool:
    if os.name == "nt":
        # There, the question whether it lives would be Ctrl-C to it.
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True
