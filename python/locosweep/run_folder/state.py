"""What is there of a run: chunks that logs and file sizes agree on."""

from __future__ import annotations

import contextlib
import gc
import math
from typing import TYPE_CHECKING

from locosweep import _core
from locosweep.errors import Cancelled, InputError
from locosweep.registry import Status
from locosweep.run_folder import arrays
from locosweep.run_folder.log import Writer, read_logs
from locosweep.run_folder.manifest import LOGS

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from locosweep.run_folder.log_lines import Done
    from locosweep.run_folder.manifest import Manifest


_NO_SIZE = 2**64 - 1
"""What no file has, and 64 bits hold."""
_CODES = {str(int(status)) for status in Status}


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

    def refresh(self, *, sizes: bool = True) -> None:
        """Read logs and sizes anew.

        Without `sizes`, only the files of chunks that were damaged are looked at: a thousand
        processes that each look at all files of a run are more than a file system bears.
        """
        with _no_search_for_circles():
            self.writers = read_logs(self.folder / LOGS, self.array_names)
            self._lines = lines = self._fitting_lines()
            looked_at = list(lines if sizes else lines.keys() & self.damaged.keys())
            self.damaged = self._faults(lines, looked_at, few=not sizes)
            self.done = {**lines}
            for chunk in self.damaged:
                del self.done[chunk]

    def _fitting_lines(self) -> dict[int, list[Done]]:
        """Lines by chunk; one that says what no chunk of this run can be counts as altered."""
        count, cells = self.manifest.plan.count, self.manifest.cells
        names = set(arrays.array_names(cells))
        outputs = {output.name for output in cells.outputs}
        found: dict[int, list[Done]] = {}
        for writer in self.writers:
            # Most lines share what they count, and their sizes.
            counted = {id(one.counts): one.counts for one in writer.done}
            sized = {id(one.sizes): one.sizes for one in writer.done}
            right = {
                i
                for i, counts in counted.items()
                if outputs == counts.keys() and all(c.keys() <= _CODES for c in counts.values())
            }
            whole = {i for i, sizes in sized.items() if names == sizes.keys()}
            fitting = []
            for one in writer.done:
                if 0 <= one.chunk < count and id(one.counts) in right and id(one.sizes) in whole:
                    fitting.append(one)
                    found.setdefault(one.chunk, []).append(one)
            writer.dropped += len(writer.done) - len(fitting)
            writer.done = fitting
        return found

    def _faults(
        self, lines: dict[int, list[Done]], chunks: list[int], *, few: bool
    ) -> dict[int, str]:
        """Say of each of these chunks which file has not the size that any of its lines tells."""
        keys, names = self.manifest.plan.keys(chunks), self.array_names
        first = [lines[chunk][0].sizes for chunk in chunks]
        told = {name: [one[name] for one in first] for name in names}
        folders = [self.folder / arrays.STORE / name for name in names]
        if few:
            other = [_looked_up(folder, keys) for folder in folders]
        else:
            try:
                other = _core.other_sizes(folders, keys, [_in_range(told[name]) for name in names])
            except OSError as error:
                raise InputError(f"{error.filename}: {error.strerror or error}") from None
        found: dict[int, str] = {}
        for at in sorted({i for one in other for i in one}):
            for name, sizes in zip(names, other, strict=True):
                size = sizes.get(at, told[name][at])
                if all(one.sizes[name] != size for one in lines[chunks[at]]):
                    what = "is not there" if size is None else f"has {size} bytes"
                    found[chunks[at]] = f"{name}/{keys[at]} {what}"
                    break
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


def _looked_up(folder: Path, keys: list[str]) -> dict[int, int | None]:
    """Return the size of each of a few files, by index; None where there is none."""
    found: dict[int, int | None] = dict.fromkeys(range(len(keys)))
    for i, key in enumerate(keys):
        with contextlib.suppress(OSError):
            found[i] = (folder / key).lstat().st_size
    return found


def _in_range(sizes: list[int]) -> list[int]:
    """Return sizes of files; an altered line may tell one that no file can have."""
    if min(sizes, default=0) >= 0 and max(sizes, default=0) < _NO_SIZE:
        return sizes
    return [size if 0 <= size < _NO_SIZE else _NO_SIZE for size in sizes]


@contextlib.contextmanager
def _no_search_for_circles() -> Iterator[None]:
    """Let a hundred thousand records be made without looking for circles, a third of the time."""
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.enable()


def altered(folder: Path, chunk: int, what: str) -> str:
    """Say that a chunk is damaged, and what helps."""
    return (
        f"{folder}: chunk {chunk} is damaged ({what}): "
        f"locosweep verify {folder} --repair computes it again"
    )


@contextlib.contextmanager
def keeping(folder: Path, manifest: Manifest) -> Iterator[None]:
    """Say, where what fills a run fails or is stopped, how much of it is kept."""
    plan, each = manifest.plan, manifest.cells.points_per_cell
    try:
        yield
    except (InputError, Cancelled) as error:
        done = State(folder, manifest).done
        what = str(error)
        if isinstance(error, Cancelled):
            # The core knows of one chunk only.
            points, all_ = plan.cells_in(list(done)) * each, math.prod(plan.shape) * each
            what = f"interrupted after {points} of {all_} points"
        raise type(error)(
            f"{what}; {len(done)} of {plan.count} chunks are kept in {folder}, the same sweep goes "
            "on from there"
        ) from None
