"""What a folder of kept work was begun for: the same goes on, anything else is refused."""

from __future__ import annotations

import contextlib
import json
from typing import TYPE_CHECKING, Any

from locosweep.errors import DataFileError, InputError
from locosweep.files.folder import check_folder, make_folder
from locosweep.kept_work.staged import sweep_staged
from locosweep.run_folder.commit import write_first

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

BEGUN = "begun.json"
"""File that says what a folder is for; written once."""


def begin(folder: Path, wanted: Mapping[str, Any], *, force: bool = False) -> None:
    """Make a folder of kept work, or go on in one that was begun for the same.

    Parameters
    ----------
    folder : Path
        The folder.
    wanted : mapping
        What tells this work from another one in the same folder, as JSON has it.
    force : bool
        Begin in a folder that is not empty and was not begun.

    Raises
    ------
    InputError
        The folder was begun for something else, or is not empty.
    DataFileError
        The file that says what it was begun for cannot be read.
    """
    path = folder / BEGUN
    # In this order: another one that begins just now writes it before all else.
    free = force or _only_partials(folder)
    begun = path.is_file()
    make_folder(check_folder(folder, force=free or begun))
    if not begun:
        write_first(path, (json.dumps(wanted, indent=1) + "\n").encode())
    # Of several that begin at once the first one's word holds.
    try:
        found = json.loads(path.read_bytes())
        pairs = {name: (found.get(name), wanted.get(name)) for name in {**found, **wanted}}
    except OSError as error:
        raise DataFileError(f"{path}: {error.strerror or error}") from None
    except (ValueError, TypeError, AttributeError, RecursionError):
        raise DataFileError(f"{path}: altered or damaged: it says no longer what is here") from None
    for name, (there, here) in pairs.items():
        if there != here:
            raise InputError(
                f"{folder} was begun with {name} {_short(there)}, here it is {_short(here)}: "
                "name another folder"
            )
    sweep_staged(folder)


def _only_partials(folder: Path) -> bool:
    """Whether nothing is there but what others are about to write."""
    with contextlib.suppress(OSError):
        return all(path.name.endswith(".partial") for path in folder.iterdir())
    return False


def _short(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


_SHOWN = 60
"""Characters of a value in a message, which is to stay a line."""
