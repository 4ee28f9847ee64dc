"""Bytes of a data file or of standard input, bounded, and unpacked where they are compressed."""

from __future__ import annotations

import functools
import gzip
import io
import sys
import zlib
from pathlib import Path
from typing import TYPE_CHECKING

from locosweep.errors import DataFileError

if TYPE_CHECKING:
    from typing import BinaryIO

STANDARD_INPUT = Path("-")
MOST_BYTES = 256 << 20
"""Bytes of text that are read: 5 million rows of 50 characters. What is read takes three times as
much memory for a moment, and a compressed file of 0.3 MB may hold as much."""
MOST_VALUES = 20_000_000
"""Rows times columns that are read: 5 million samples of four columns, 80 minutes at 1 kHz. As many
in a CSV file of 160 MB take 1.2 GB for a moment (`tests/files/test_raw.py`)."""
_GZIP = b"\x1f\x8b"
_REMEDY = "take parts of the log, or fewer samples a second"


@functools.cache
def _standard_input() -> bytes:
    """Return what was piped in; it can be read once, and its digest is asked for as well."""
    return _bounded(STANDARD_INPUT, sys.stdin.buffer)


def stored(path: Path, most: int | None = None) -> bytes:
    """Return the bytes of a file as they are stored; DataFileError where there are too many."""
    if path == STANDARD_INPUT:
        return _standard_input()
    try:
        with path.open("rb") as file:
            return _bounded(path, file, most)
    except OSError as error:
        raise DataFileError(f"{path}: {error.strerror or error}") from None


def contents(path: Path) -> bytes:
    """Return the bytes of a file, or those that it holds if it is compressed by gzip."""
    data = stored(path)
    if not data.startswith(_GZIP):
        return data
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as file:
            return _bounded(path, file)
    except (OSError, EOFError, zlib.error) as error:
        raise DataFileError(f"{path}: {error}") from None


def check_size(path: object, rows: int, columns: int) -> None:
    """Refuse a table that is too large, before its values are read."""
    if rows * columns > MOST_VALUES:
        raise DataFileError(
            f"{path}: {rows} rows of {columns} columns, allowed are {MOST_VALUES:.0e} values "
            f"(rows times columns that are used): {_REMEDY}"
        )


def _bounded(path: Path, file: BinaryIO | gzip.GzipFile, most: int | None = None) -> bytes:
    most = MOST_BYTES if most is None else most
    data = file.read(most + 1)
    if len(data) > most:
        raise DataFileError(f"{path}: holds more than {most >> 20} MB of text: {_REMEDY}")
    return data
