"""Specifications as TOML files: reading, writing, and paths relative to the file."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from locosweep.files import toml
from locosweep.files.atomic import write_text

if TYPE_CHECKING:
    import os


class SpecFile(ABC):
    """A specification that a TOML file holds."""

    _kind: ClassVar[str]

    @abstractmethod
    def to_toml(self) -> str:
        """Return the text of a file."""

    @classmethod
    @abstractmethod
    def _of(cls, document: dict[str, Any], folder: Path) -> Self:
        """Read the content of a file; relative paths in it count from a folder."""

    @abstractmethod
    def _moved(self, folder: Path) -> Self:
        """Return the same specification, its relative paths counted from another folder."""

    @classmethod
    def from_toml(cls, text: str, *, source: str | None = None) -> Self:
        """Read the text of a file.

        Parameters
        ----------
        text : str
            TOML.
        source : str, optional
            Its name in messages.

        Raises
        ------
        DataFileError
            Not TOML, an unknown table or key (with the nearest known one), a value
            of the wrong kind, number or range; names source, table and key.
        """
        source = cls._kind if source is None else source
        document = toml.parse(text, source)
        with toml.refusing(source):
            return cls._of(document, Path())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a file; paths in it count from its folder."""
        document = toml.read(path)
        with toml.refusing(path):
            return cls._of(document, Path(path).parent)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file, in one step; paths in it count from its folder."""
        write_text(path, self._moved(Path(path).parent).to_toml())
