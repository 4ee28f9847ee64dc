"""The plan of a run: how its grid is cut into chunks, each one file per array."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

MOST_BYTES = 64 << 20
"""Of a chunk's arrays together: files large enough for the full rate of a disk, few enough for a
file system, and those that are held, two of them filled up to their shape in a copy, within 512 MB
beside the interpreter."""
HELD = 4
"""Chunks that one process has in memory: one computed, two written, one that waits."""
MOST_SECONDS = 30.0
"""What the end of a process may cost."""


@dataclass(frozen=True)
class Plan:
    """Chunks of one shape; those at the ends of axes may hold less.

    Attributes
    ----------
    shape, chunk : tuple of int
        Cells along each axis, of the grid and of a chunk.

    Examples
    --------
    >>> from locosweep.run_folder.plan import Plan
    >>> plan = Plan((10, 4), (4, 4))
    >>> plan.count, plan.slices(2), plan.key(2)
    (3, (slice(8, 10, None), slice(0, 4, None)), 'c.2.0')
    """

    shape: tuple[int, ...]
    chunk: tuple[int, ...]

    @cached_property
    def parts(self) -> tuple[int, ...]:
        """Chunks along each axis."""
        return tuple(-(-n // c) for n, c in zip(self.shape, self.chunk, strict=True))

    @cached_property
    def count(self) -> int:
        """Chunks in all."""
        return math.prod(self.parts)

    def place(self, chunk: int) -> tuple[int, ...]:
        """Return where a chunk stands among the chunks, by axis."""
        places = []
        for count in reversed(self.parts):
            chunk, place = divmod(chunk, count)
            places.append(place)
        return tuple(reversed(places))

    def slices(self, chunk: int) -> tuple[slice, ...]:
        """Return the cells of a chunk along each axis."""
        places = zip(self.place(chunk), self.chunk, self.shape, strict=True)
        return tuple(slice(p * c, min((p + 1) * c, n)) for p, c, n in places)

    def key(self, chunk: int) -> str:
        """Return the file name of a chunk within its array."""
        return ".".join(["c", *map(str, self.place(chunk))])

    def keys(self, chunks: Sequence[int]) -> list[str]:
        """Return `key` of many chunks at once, an axis at a time."""
        rest, words = list(chunks), []
        for count in reversed(self.parts):
            words.append([str(chunk % count) for chunk in rest])
            rest = [chunk // count for chunk in rest]
        words.append(["c"] * len(rest))
        return [".".join(places) for places in zip(*reversed(words), strict=True)]

    def number(self, key: str) -> int | None:
        """Return the chunk that a file name stands for, None for another file."""
        head, *words = key.split(".")
        parts = self.parts
        if head != "c" or len(words) != len(parts) or not all(w.isdecimal() for w in words):
            return None
        places = [int(word) for word in words]
        if any(p >= n for p, n in zip(places, parts, strict=True)):
            return None
        chunk = 0
        for place, count in zip(places, parts, strict=True):
            chunk = chunk * count + place
        return chunk

    def cells(self, chunk: int) -> int:
        """Return how many cells a chunk holds."""
        places = zip(self.place(chunk), self.chunk, self.shape, strict=True)
        return math.prod(min(c, n - p * c) for p, c, n in places)

    def cells_in(self, chunks: Sequence[int]) -> int:
        """Return how many cells many chunks hold together, an axis at a time."""
        rest, found = list(chunks), [1] * len(chunks)
        axes = zip(self.parts, self.chunk, self.shape, strict=True)
        for count, cells, length in reversed(list(axes)):
            last = length - (count - 1) * cells
            found = [
                n * (last if chunk % count == count - 1 else cells)
                for n, chunk in zip(found, rest, strict=True)
            ]
            rest = [chunk // count for chunk in rest]
        return sum(found)


def cut(shape: tuple[int, ...], cells: int) -> Plan:
    """Cut a grid into near-cubic chunks of at most so many cells, nearly equal among each other.

    A slice through any axis then touches few of them.
    """
    low, high = 1, max(shape, default=1)
    while low < high:
        side = (low + high + 1) // 2
        if math.prod(min(n, side) for n in shape) <= max(cells, 1):
            low = side
        else:
            high = side - 1
    chunk = [-(-n // -(-n // low)) for n in shape]
    # The whole numbers of a side leave room: the axes take it from the last one on.
    for i in reversed(range(len(shape))):
        room = max(cells, 1) // max(math.prod(chunk) // chunk[i], 1)
        if room > chunk[i]:
            chunk[i] = -(-shape[i] // -(-shape[i] // min(room, shape[i])))
    return Plan(tuple(shape), tuple(chunk))


def cells_of_chunk(bytes_per_cell: int, seconds_per_cell: float) -> int:
    """Return how many cells a chunk may have by size and time."""
    most = MOST_BYTES // bytes_per_cell
    if seconds_per_cell > 0:
        # No least size: what takes half a minute to compute is worth a small file.
        most = min(most, int(MOST_SECONDS / seconds_per_cell))
    return max(most, 1)
