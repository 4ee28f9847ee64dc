"""Which chunks a process computes, and in which order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from locosweep.run_folder.state import State


def check_shard(shard: tuple[int, int] | None) -> None:
    """Refuse a shard that does not exist."""
    if shard is None:
        return
    try:
        i, n = shard
        right = all(isinstance(k, int) and not isinstance(k, bool) for k in (i, n)) and 0 <= i < n
    except (TypeError, ValueError):
        right = False
    if not right:
        text = "/".join(map(str, shard)) if isinstance(shard, tuple) else repr(shard)
        raise InputError(f"shard is {text}: allowed is I/N with I from 0 to N - 1")


def from_end(others: Sequence[int], shard: tuple[int, int]) -> list[int]:
    """Turn what is of others, so that several shards that are done begin at different ones.

    Examples
    --------
    >>> from locosweep.run_folder.shards import from_end
    >>> from_end([9, 6, 3, 0], (1, 2))
    [3, 0, 9, 6]
    """
    turn = len(others) * shard[0] // shard[1]
    return [*others[turn:], *others[:turn]]


def dealt(count: int, shard: tuple[int, int]) -> list[int]:
    """Return all of so many in the order of one shard: its own, then others from the end.

    Examples
    --------
    >>> from locosweep.run_folder.shards import dealt
    >>> dealt(6, (1, 2))
    [1, 3, 5, 2, 0, 4]
    """
    index, of = shard
    others = [i for i in reversed(range(count)) if i % of != index]
    return [*range(index, count, of), *from_end(others, shard)]


class Order:
    """The chunks that one process computes, in order: its own, then missing ones of others.

    Chunks are dealt round robin. Those of others come from the end, so that whoever is still
    there meets them last; several that are done at once begin at different ones.
    """

    def __init__(self, state: State, shard: tuple[int, int] | None) -> None:
        self._state = state
        self._index, self._of = shard or (0, 1)

    def missing(self) -> list[int]:
        """Chunks of this shard that are not done."""
        return [c for c in self._state.missing if c % self._of == self._index]

    def __iter__(self) -> Iterator[int]:
        mine: set[int] = set()
        first = self.missing()
        # Files that nobody logged were left by a process that died: they are not trusted.
        left_over = {chunk for chunk in first if self._state.is_there(chunk)}
        for chunk in first:
            if chunk in left_over or not self._state.is_there(chunk):
                mine.add(chunk)
                yield chunk
        if self._of > 1:
            for chunk in from_end(self._rest(mine), (self._index, self._of)):
                if not self._state.is_there(chunk):
                    mine.add(chunk)
                    yield chunk
        # What another process wrote and did not log, because it died or has yet to do so.
        yield from self._rest(mine)

    def _rest(self, mine: set[int]) -> list[int]:
        """Chunks that nobody has logged, from the end, without those of this process."""
        self._state.refresh(sizes=False)
        return [chunk for chunk in reversed(self._state.missing) if chunk not in mine]
