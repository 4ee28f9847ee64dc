"""Names of run folders, told from those of files."""

from __future__ import annotations

import os
from pathlib import Path

from locosweep.errors import InputError


def check_run_name(out: str | os.PathLike[str]) -> Path:
    """Refuse a name that is a file's, or that the system does."""
    path = Path(out)
    if "\0" in str(path):
        raise InputError(f"{str(path)!r}: a folder's name cannot have a NUL in it")
    try:
        path.stat()
    except FileNotFoundError:
        pass
    except OSError as error:
        raise InputError(f"{path}: cannot use this folder: {error.strerror or error}") from None
    if is_file_name(out):
        raise InputError(
            f"out is {os.fspath(out)!r}, which ends as a file's name does: a folder has no ending, "
            "or a slash behind it"
        )
    return path


def is_file_name(out: str | os.PathLike[str]) -> bool:
    """Whether a path names a file: by an ending, unless a folder is there or a slash ends it."""
    if os.fspath(out).endswith(("/", os.sep)) or Path(out).is_dir():
        return False
    return bool(Path(out).suffix)
