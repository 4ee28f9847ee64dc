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
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from locosweep.run_folder.log_lines import Done
    from locosweep.run_folder.manifest import Manifest


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
            keys = self.manifest.plan.keys(looked_at)
            found = self._sizes() if sizes else self._sizes_of(keys)
            self.damaged = _faults(lines, dict(zip(looked_at, keys, strict=True)), found)
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

    def _sizes(self) -> dict[str, dict[str, int]]:
        """Sizes of all files by array and name."""
        names = self.array_names
        folders = [self.folder / arrays.STORE / name for name in names]
        try:
            return dict(zip(names, _core.file_sizes(folders), strict=True))
        except OSError as error:
            raise InputError(f"{error.filename}: {error.strerror or error}") from None

    def _sizes_of(self, keys: Iterable[str]) -> dict[str, dict[str, int]]:
        """Sizes of the files of a few chunks by array and name."""
        found: dict[str, dict[str, int]] = {name: {} for name in self.array_names}
        for key in keys:
            for name, sizes in found.items():
                with contextlib.suppress(OSError):
                    path = self.folder / arrays.STORE / name / key
                    sizes[key] = path.lstat().st_size
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


def _faults(
    lines: dict[int, list[Done]], keys: dict[int, str], sizes: dict[str, dict[str, int]]
) -> dict[int, str]:
    """Say of each of the chunks `keys` which file has not the size that any of its lines tells."""
    doubtful: set[int] = set()
    for name, files in sizes.items():
        size = files.get
        doubtful.update(c for c, key in keys.items() if lines[c][0].sizes[name] != size(key))
    # In the order of the logs.
    found = {c: _fault(keys[c], lines[c], sizes) for c in keys if c in doubtful}
    return {chunk: fault for chunk, fault in found.items() if fault}


def _fault(key: str, lines: list[Done], sizes: dict[str, dict[str, int]]) -> str | None:
    """Say which file of a chunk has not the size that any of its lines tells."""
    for name, files in sizes.items():
        size = files.get(key)
        if all(one.sizes[name] != size for one in lines):
            what = "is not there" if size is None else f"has {size} bytes"
            return f"{name}/{key} {what}"
    return None


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
