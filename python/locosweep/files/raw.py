"""Bytes of a data file or of standard input, unpacked where they are compressed."""

from __future__ import annotations

import functools
import gzip
import sys
import zlib
from pathlib import Path

from locosweep.errors import DataFileError

STANDARD_INPUT = Path("-")
_GZIP = b"\x1f\x8b"


@functools.cache
def _standard_input() -> bytes:
    """Return what was piped in; it can be read once, and its digest is asked for as well."""
    return sys.stdin.buffer.read()


def stored(path: Path) -> bytes:
    """Return the bytes of a file as they are stored."""
    if path == STANDARD_INPUT:
        return _standard_input()
    try:
        return path.read_bytes()
    except OSError as error:
        raise DataFileError(f"{path}: {error.strerror or error}") from None


def contents(path: Path) -> bytes:
    """Return the bytes of a file, or those that it holds if it is compressed by gzip."""
    data = stored(path)
    try:
        return gzip.decompress(data) if data.startswith(_GZIP) else data
    except (OSError, EOFError, zlib.error) as error:
        raise DataFileError(f"{path}: {error}") from None
