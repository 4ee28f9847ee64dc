"""What a simulation is told by name or file: law, drive, method and drive samples."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from locosweep import registry
from locosweep.errors import DataFileError, InputError
from locosweep.files.toml import moved

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable

    import numpy as np
    from numpy.typing import NDArray

    Samples = tuple[NDArray[np.float64], NDArray[np.float64]]

__all__ = ["SIMULATION", "Simulation", "read_drive"]

SIMULATION = ("law", "drive", "method", "drive_file", "gait")
_TABLE = "table"
_COLUMNS = ("t", "drive")


@dataclass(frozen=True)
class Simulation:
    """Law, drive and method by name; what is None takes the default of `sweep`.

    Attributes
    ----------
    law, drive, method : str, optional
        Names from ``locosweep.laws()``, ``drives()`` and ``methods()``.
    drive_file : str, optional
        CSV file with the columns t in s and drive, for the drive ``table``. A
        relative path counts from `folder`.
    gait : str, optional
        Gait of quantities of whole robots.
    folder : Path
        Where a relative `drive_file` starts: the current folder, or that of the
        sweep file that named it.

    Raises
    ------
    InputError
        An unknown name, a file without the drive ``table``, or that without one.

    Examples
    --------
    >>> from locosweep.specs.simulation import Simulation
    >>> Simulation(law="lugre", drive="sine").given
    ['law', 'drive']
    """

    law: str | None = None
    drive: str | None = None
    method: str | None = None
    drive_file: str | None = None
    gait: str | None = None
    folder: Path = field(default=Path(), compare=False)

    def __post_init__(self) -> None:
        if self.law is not None:
            registry.law(self.law)
        if self.drive is not None:
            registry.drive(self.drive)
        if self.method is not None and self.method not in registry.methods():
            raise registry.unknown("method", self.method, registry.methods())
        if (self.drive_file is None) == (self.drive == _TABLE):
            raise InputError(
                "drive 'table' and a drive file go together: the file has the columns t and drive"
            )

    @property
    def given(self) -> list[str]:
        """Which of them are given."""
        return [name for name in SIMULATION if getattr(self, name) is not None]

    def options(self) -> dict[str, Any]:
        """Return the arguments of `sweep` and `simulate`; reads the drive file."""
        table = None if self.drive_file is None else read_drive(self.folder / self.drive_file)
        found = {"law": self.law, "drive": self.drive, "method": self.method, "table": table}
        # What simulates no whole robot takes no gait.
        return found if self.gait is None else {**found, "gait": self.gait}

    def beside(self, folder: Path) -> Simulation:
        """Return the same, its drive file counted from a folder."""
        return replace(self, folder=folder)

    def moved(self, folder: Path) -> Simulation:
        """Return the same drive file, told from another folder."""
        return replace(self, drive_file=moved(self.drive_file, self.folder, folder), folder=folder)


def read_drive(path: str | os.PathLike[str]) -> Samples:
    r"""Read the samples of a drive from a CSV file.

    Parameters
    ----------
    path : path-like
        Comma-separated, with a header that names at least ``t`` (s, rising) and
        ``drive``; other columns are left alone.

    Returns
    -------
    tuple of ndarray
        Times in s and values of the drive.

    Raises
    ------
    DataFileError
        No such file, a column missing, a cell that is no finite number, times
        that do not rise; names the file, the row (the header is row 1) and column.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from locosweep.specs.simulation import read_drive
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "drive.csv"
    >>> _ = file.write_text("t,drive\n0,1.5\n0.5,-1.5\n")
    >>> read_drive(file)
    (array([0. , 0.5]), array([ 1.5, -1.5]))
    """
    import numpy as np

    path = Path(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as lines:
            rows = _rows(path, csv.reader(lines, strict=True))
    except OSError as error:
        raise DataFileError(f"{path}: {error.strerror or error}") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise DataFileError(f"{path}: not a CSV file: {error}") from None
    times, values = np.array(rows, dtype=np.float64).reshape(-1, 2).T.copy()
    return times, values


def _rows(path: Path, table: Iterable[list[str]]) -> list[tuple[float, float]]:
    numbered = ((row, cells) for row, cells in enumerate(table, 1) if cells)
    _, heads = next(numbered, (1, []))
    names = [head.strip() for head in heads]
    for name in _COLUMNS:
        if names.count(name) != 1:
            often = "no" if name not in names else "more than one"
            found = ", ".join(names) or "none, the file is empty"
            raise DataFileError(f"{path}: {often} column '{name}': its columns are {found}")
    places = [names.index(name) for name in _COLUMNS]
    rows: list[tuple[float, float]] = []
    for row, cells in numbered:
        t, drive = (
            _cell(path, row, name, cells[place] if place < len(cells) else "")
            for name, place in zip(_COLUMNS, places, strict=True)
        )
        if rows and t <= rows[-1][0]:
            raise DataFileError(
                f"{path}: row {row}, column t: {t:g} s after {rows[-1][0]:g} s: "
                f"allowed are times that rise"
            )
        rows.append((t, drive))
    if not rows:
        raise DataFileError(f"{path}: no row below its header: allowed is at least one")
    return rows


def _cell(path: Path, row: int, column: str, text: str) -> float:
    # Python also reads 1_000 and non-Latin digits; those are typing errors here.
    plain = text.isascii() and "_" not in text
    try:
        number = float(text) if plain else math.nan
    except ValueError:
        number = math.nan
    if math.isfinite(number):
        return number
    shown = f"'{text.strip()[:40]}'" if text.strip() else "empty"
    raise DataFileError(
        f"{path}: row {row}, column {column} is {shown}: allowed is a finite number"
    )
