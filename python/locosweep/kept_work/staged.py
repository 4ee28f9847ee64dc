"""Files of a piece of work that appear whole, whoever else makes the same ones."""

from __future__ import annotations

import contextlib
import os
import shutil
from typing import TYPE_CHECKING

from locosweep.errors import InputError
from locosweep.run_folder.commit import beside, sweep_stale, sync_folders

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


@contextlib.contextmanager
def staged(folder: Path, *wholes: str) -> Iterator[Path]:
    """Yield an empty folder whose files go to the same places in `folder` when all went well.

    Each file is brought to the disk and replaces the one of its name at once, so that another
    process that makes the same files never reads half of one. Folders `wholes` are emptied of
    files that were not made.
    """
    temporary = beside(folder / "work")
    try:
        temporary.mkdir(parents=True)
        yield temporary
        made = sorted(path for path in temporary.rglob("*") if path.is_file())
        names = {path.relative_to(temporary) for path in made}
        for path in made:
            # For writing, as Windows asks for that.
            with path.open("r+b") as file:
                os.fsync(file.fileno())
            target = folder / path.relative_to(temporary)
            target.parent.mkdir(parents=True, exist_ok=True)
            path.replace(target)
        for whole in wholes:
            for path in [p for p in (folder / whole).glob("*") if p.is_file()]:
                if path.relative_to(folder) not in names:
                    path.unlink(missing_ok=True)
        sync_folders(sorted({(folder / name).parent for name in names}))
    except OSError as error:
        raise InputError(f"{folder}: cannot write: {error.strerror or error}") from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def sweep_staged(folder: Path) -> int:
    """Remove what dead processes of this machine left half-made; return how many folders."""
    return sweep_stale([folder])
