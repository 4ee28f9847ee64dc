"""The store of a run for reading: every chunk is held against the hash in the logs first."""

from __future__ import annotations

import asyncio
import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from zarr.abc.store import OffsetByteRequest, RangeByteRequest, SuffixByteRequest
from zarr.storage import LocalStore

from locosweep.errors import DataFileError
from locosweep.run_folder import arrays, manifest
from locosweep.run_folder.state import State, altered

if TYPE_CHECKING:
    from zarr.abc.store import ByteRequest
    from zarr.core.buffer import Buffer, BufferPrototype


class VerifiedStore(LocalStore):
    """``data.zarr`` of a run, read-only; DataFileError names a chunk that was altered.

    Metadata and coordinates come from the manifest, whose own hash was checked. A chunk that
    no log has, whatever lies in its file, is not there.
    """

    def __init__(self, folder: str, state: State | None = None) -> None:
        super().__init__(Path(folder) / arrays.STORE, read_only=True)
        self._folder = Path(folder)
        found = manifest.read(self._folder) if state is None else state.manifest
        self._state = State(self._folder, found) if state is None else state
        self._files = manifest.store_files(found)

    def __reduce__(self) -> tuple[Any, ...]:
        return VerifiedStore, (str(self._folder),)

    def with_read_only(self, read_only: bool = False) -> VerifiedStore:
        """Return this store, which is never written to."""
        del read_only
        return self

    async def get(
        self,
        key: str,
        prototype: BufferPrototype | None = None,
        byte_range: ByteRequest | None = None,
    ) -> Buffer | None:
        """Return a file, or a part of it, once the whole has the right hash."""
        from zarr.core.buffer import default_buffer_prototype

        content = await asyncio.to_thread(self._content, key)
        if content is None:
            return None
        if byte_range is not None:
            content = content[_slice(byte_range, len(content))]
        return (prototype or default_buffer_prototype()).buffer.from_bytes(content)

    def _content(self, key: str) -> bytes | None:
        if key in self._files:
            return self._files[key]
        name, _, file = key.partition("/")
        chunk = self._state.manifest.plan.number(file) if name in self._state.array_names else None
        if chunk is None:
            return None
        wanted = self._state.hashes(chunk, name)
        if chunk in self._state.damaged:
            raise self._altered(self._state.damaged[chunk], chunk)
        if not wanted:
            return None
        path = self._folder / arrays.STORE / key
        try:
            content = path.read_bytes()
        except OSError as error:
            raise DataFileError(f"{path}: {error.strerror or error}") from None
        if hashlib.sha256(content).hexdigest() not in wanted:
            raise self._altered(f"{key} was altered", chunk)
        return content

    def _altered(self, what: str, chunk: int) -> DataFileError:
        return DataFileError(altered(self._folder, chunk, what))

    async def exists(self, key: str) -> bool:
        """Return whether a file counts."""
        return key in self._files or await self.get(key) is not None


def _slice(wanted: ByteRequest, size: int) -> slice:
    if isinstance(wanted, RangeByteRequest):
        return slice(wanted.start, wanted.end)
    if isinstance(wanted, OffsetByteRequest):
        return slice(wanted.offset, None)
    if isinstance(wanted, SuffixByteRequest):
        return slice(max(0, size - wanted.suffix), None)
    raise TypeError(f"unknown part of a file: {wanted!r}")
