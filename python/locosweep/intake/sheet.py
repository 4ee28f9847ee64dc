"""A file of a log: its columns as guessed, before any number is converted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from locosweep.errors import DataFileError, InputError
from locosweep.files.bags import is_bag
from locosweep.files.runs import wanted_columns
from locosweep.files.table import listed, read_table, whole_table
from locosweep.intake.guess import guess_columns

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from locosweep.files.csv_form import CsvForm
    from locosweep.files.table import Table


@dataclass(frozen=True)
class Sheet:
    """One file of a log."""

    table: Table
    """The columns that were chosen, as they stand in the file."""
    why: dict[str, str]
    """Why each was chosen, by our name."""
    left: list[str]
    """What stays open."""

    @property
    def path(self) -> str:
        """What messages call the file."""
        return self.table.path

    @property
    def names(self) -> dict[str, str]:
        """Names in the file, by ours."""
        return {role: self.table.labels[role] for role in self.why}


def opened(
    path: Path, columns: Mapping[str, str], units: Mapping[str, str], form: CsvForm
) -> Sheet:
    """Return a file with the columns that it seems to have; `columns` and `units` are given."""
    if is_bag(path):
        raise InputError(f"{path}: a bag names its topics: locosweep diagnose --map takes it")
    names, frame = whole_table(path, form)
    for role, name in columns.items():
        if name not in names:
            raise DataFileError(
                f"{path}: no column {name} (given for {role}): there are {listed(names)}"
            )
    there = list(dict.fromkeys(names))
    frame = frame.select(frame[str(names.index(name))].alias(name) for name in there)
    found, left = guess_columns(there, frame, columns, units, str(path))
    chosen = {role: name for role, (name, _) in found.items()}
    # Only these: a column of one of our names may have been found to be something else.
    wanted = {role: allowed for role, allowed in wanted_columns().items() if role in chosen}
    table = read_table(path, wanted, tuple(chosen), chosen, form)
    return Sheet(table, {role: why for role, (_, why) in found.items()}, left)
