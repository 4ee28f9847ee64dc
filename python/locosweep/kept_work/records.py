"""Records of work that is kept: for what it was done, and which files it made.

Work is done again where its record is torn, of another key, or of files that have changed since.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from locosweep.run_folder.commit import sync_folders, write_file

if TYPE_CHECKING:
    from collections.abc import Iterable


def digest(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def kept(record: Path, key: object) -> dict[str, Any] | None:
    """Return what a record says; None where the work has to be done.

    Parameters
    ----------
    record : Path
        File of the record.
    key : object
        What the work depends on, as JSON has it.

    Returns
    -------
    dict or None
        As `keep` wrote it; None if that was for another key, or if a file of it has changed.
    """
    try:
        known = json.loads(record.read_text())
        if known["key"] != key:
            return None
        whole = all(digest(record.parent / name) == was for name, was in known["files"].items())
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return None
    return dict(known) if whole else None


def keep(record: Path, key: object, files: Iterable[Path] = (), **said: object) -> None:
    """Write a record of `files` that the work made, and of what it `said`."""
    record.parent.mkdir(parents=True, exist_ok=True)
    made = {Path(os.path.relpath(path, record.parent)).as_posix(): digest(path) for path in files}
    whole = {"key": key, "files": made, **said}
    text = json.dumps(whole, indent=1, allow_nan=False) + "\n"
    # Brought to the disk, as hours of work may stand behind it.
    write_file(record, [text.encode()])
    sync_folders([record.parent])
