"""A folder that is written as a whole or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator


def make_folder(path: str | os.PathLike[str]) -> Path:
    """Make a folder where there is none; InputError if that fails."""
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: cannot make this folder: {error.strerror}") from None
    return path


def check_folder(path: str | os.PathLike[str], *, force: bool = False) -> Path:
    """Refuse a folder that cannot be written, or that is not empty unless `force`.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from locosweep.files.folder import check_folder
    >>> here = pathlib.Path(tempfile.mkdtemp())
    >>> check_folder(here / "new") == here / "new"
    True
    """
    path = Path(path)
    if "\0" in str(path):
        raise InputError(f"{str(path)!r}: a folder's name cannot have a NUL in it")
    try:
        full = path.exists() and any(path.iterdir())
        above = next(p for p in (path.absolute(), *path.absolute().parents) if p.exists())
    except NotADirectoryError:
        raise InputError(f"{path}: a file is there: allowed is a folder") from None
    except OSError as error:
        raise InputError(f"{path}: cannot use this folder: {error.strerror or error}") from None
    if full and not force:
        raise InputError(f"{path} is not empty: name another folder, or give --force")
    if not above.is_dir() or not os.access(above, os.W_OK | os.X_OK):
        raise InputError(f"{path}: cannot make files in {above}")
    return path


@contextlib.contextmanager
def filling(
    path: str | os.PathLike[str], names: Collection[str], *, force: bool = False
) -> Iterator[Path]:
    """Yield a temporary folder whose files replace those of `path` when all went well.

    `names` are all names that a writer may use: older files of these names are removed, so
    that no picture of another result is left; files under other names stay.
    """
    path = check_folder(path, force=force)
    there = path.exists()
    try:
        if not there:
            path.parent.mkdir(parents=True, exist_ok=True)
        # Inside a folder that exists: its parent may not be ours to write.
        parent = path if there else path.parent
        temporary = Path(tempfile.mkdtemp(prefix=".locosweep-", dir=parent))
    except OSError as error:
        raise InputError(f"{path}: cannot write: {error.strerror or error}") from None
    try:
        yield temporary
        if there:
            made = sorted(temporary.iterdir())
            # First away with the old ones: a process that is killed here leaves a part of one
            # result, never parts of two.
            for name in {*names, *(file.name for file in made)}:
                (path / name).unlink(missing_ok=True)
            for file in made:
                file.replace(path / file.name)
        else:
            mask = os.umask(0)
            os.umask(mask)
            temporary.chmod(0o777 & ~mask)
            temporary.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot write: {error.strerror or error}") from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
