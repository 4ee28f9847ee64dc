"""Choice of a simulation by name or file: law, drive, method and drive samples."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from locosweep import registry
from locosweep.errors import DataFileError, InputError
from locosweep.files.toml import moved
from locosweep.files.units import DRIVES

if TYPE_CHECKING:
    import os

    import numpy as np
    from numpy.typing import NDArray

    Samples = tuple[NDArray[np.float64], NDArray[np.float64]]

SIMULATION = ("law", "drive", "method", "drive_file", "gait")
_TABLE = "table"
_COLUMNS = {"t": ("s",), "drive": DRIVES}
"""Columns of drive samples with their allowed units."""


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
        """Names of those that are given."""
        return [name for name in SIMULATION if getattr(self, name) is not None]

    def options(self) -> dict[str, Any]:
        """Return the arguments of `sweep` and `simulate`; reads the drive file."""
        table = None if self.drive_file is None else read_drive(self.folder / self.drive_file)
        found = {"law": self.law, "drive": self.drive, "method": self.method, "table": table}
        # Only simulations of whole robots take a gait.
        return found if self.gait is None else {**found, "gait": self.gait}

    def moved(self, folder: Path) -> Simulation:
        """Return the same choice, its drive file relative to another folder."""
        return replace(self, drive_file=moved(self.drive_file, self.folder, folder), folder=folder)


def read_drive(path: str | os.PathLike[str]) -> Samples:
    r"""Read times [s] and values of a drive: the columns t and drive of CSV or Parquet.

    DataFileError names file, row (the first below the names is 1) and column of a cell that
    is missing or no finite number, or of times that do not rise.

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

    from locosweep.files.columns import check_complete, check_rising, number_columns
    from locosweep.files.table import read_table

    numbers, _ = number_columns(read_table(path, _COLUMNS, tuple(_COLUMNS)))
    t, drive = (numbers[name] for name in _COLUMNS)
    # Not the blank lines between and below.
    rows = np.flatnonzero(~(np.isnan(t) & np.isnan(drive)))
    if not rows.size:
        raise DataFileError(f"{path}: no rows")
    check_complete(f"{path}: ", "t", t[rows], rows)
    check_complete(f"{path}: ", "drive", drive[rows], rows)
    check_rising(f"{path}: ", t[rows], rows)
    return t[rows], drive[rows]
