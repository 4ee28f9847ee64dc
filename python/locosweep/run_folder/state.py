"""What is there of a run: chunks that logs and file sizes agree on."""

from __future__ import annotations

import contextlib
import os
from typing import TYPE_CHECKING

from locosweep.errors import InputError
from locosweep.run_folder import arrays
from locosweep.run_folder.log import Done, Writer, read_logs
from locosweep.run_folder.manifest import LOGS

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from locosweep.run_folder.manifest import Manifest


class State:
    """The chunks of a run that are done, as its logs and its files say together.

    A file without a line in a log is not trusted: its chunk counts as missing and is computed
    again, which replaces it.

    Attributes
    ----------
    writers : list of Writer
        All logs.
    done : dict of int to list of Done
        Lines of each chunk whose files are there with their sizes; one, or one by each writer.
    damaged : dict of int to str
        Chunks that a log calls done, with what is wrong with which file.
    """

    def __init__(self, folder: Path, manifest: Manifest) -> None:
        self.folder = folder
        self.manifest = manifest
        self.writers: list[Writer] = []
        self.done: dict[int, list[Done]] = {}
        self.damaged: dict[int, str] = {}
        self._lines: dict[int, list[Done]] = {}
        self.refresh()

    def refresh(self) -> None:
        """Read logs and sizes anew."""
        plan = self.manifest.plan
        self.writers = read_logs(self.folder / LOGS)
        lines: dict[int, list[Done]] = {}
        for writer in self.writers:
            for one in writer.done:
                if 0 <= one.chunk < plan.count:
                    lines.setdefault(one.chunk, []).append(one)
        self._lines = lines
        sizes = self._sizes()
        self.done, self.damaged = {}, {}
        for chunk, known in lines.items():
            key = plan.key(chunk)
            there = {name: files.get(key) for name, files in sizes.items()}
            fits = {n: {one.files[n][1] for one in known if n in one.files} for n in there}
            wrong = [name for name, size in there.items() if size not in fits[name]]
            if wrong:
                size = there[wrong[0]]
                fault = "is not there" if size is None else f"has {size} bytes"
                self.damaged[chunk] = f"{wrong[0]}/{key} {fault}"
            else:
                self.done[chunk] = known

    def _sizes(self) -> dict[str, dict[str, int]]:
        """Sizes of all files by array and name."""
        found: dict[str, dict[str, int]] = {}
        root = self.folder / arrays.STORE
        for name in self.array_names:
            sizes = found.setdefault(name, {})
            try:
                with os.scandir(root / name) as entries:
                    for entry in entries:
                        sizes[entry.name] = entry.stat(follow_symlinks=False).st_size
            except FileNotFoundError:
                continue
            except OSError as error:
                raise InputError(f"{root / name}: {error.strerror or error}") from None
        return found

    @property
    def array_names(self) -> list[str]:
        """Names of the arrays that chunks fill."""
        return arrays.array_names(self.manifest.cells)

    @property
    def done_count(self) -> int:
        """Chunks that are done."""
        return len(self.done)

    @property
    def missing(self) -> list[int]:
        """Chunks that are not done, in order."""
        return [chunk for chunk in range(self.manifest.plan.count) if chunk not in self.done]

    def hashes(self, chunk: int, name: str) -> set[str]:
        """SHA-256 that a file of a chunk may have, one by each writer."""
        return {one.files[name][0] for one in self._lines.get(chunk, []) if name in one.files}

    def is_there(self, chunk: int) -> bool:
        """Whether the files of a chunk are there now, logged or about to be."""
        root, key = self.folder / arrays.STORE, self.manifest.plan.key(chunk)
        return all((root / name / key).exists() for name in self.array_names)


@contextlib.contextmanager
def keeping(folder: Path, manifest: Manifest) -> Iterator[None]:
    """Say, where what fills a run fails, how much of it is kept."""
    try:
        yield
    except InputError as error:
        done = State(folder, manifest).done_count
        raise type(error)(
            f"{error}; {done} of {manifest.plan.count} chunks are kept in {folder}, the same sweep "
            "goes on from there"
        ) from None
