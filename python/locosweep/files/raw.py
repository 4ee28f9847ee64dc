"""Bytes of a data file, unpacked where it is compressed."""

from __future__ import annotations

import gzip
import zlib
from typing import TYPE_CHECKING

from locosweep.errors import DataFileError

if TYPE_CHECKING:
    from pathlib import Path

_GZIP = b"\x1f\x8b"


def contents(path: Path) -> bytes:
    """Return the bytes of a file, or those that it holds if it is compressed by gzip."""
    try:
        data = path.read_bytes()
        return gzip.decompress(data) if data.startswith(_GZIP) else data
    except (OSError, EOFError, zlib.error) as error:
        raise DataFileError(f"{path}: {getattr(error, 'strerror', None) or error}") from None
