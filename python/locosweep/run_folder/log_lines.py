"""Lines of a log: written, and read back, with what is torn or altered told from what is whole.

A line is JSON, a tab and its CRC-32. Lines as `line_of` writes them are read by their form,
which takes a fifth of the time of JSON: a run may have a hundred thousand. Every other one is
read as JSON, with the same outcome.
"""

from __future__ import annotations

import json
import math
import re
import zlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    Counts = dict[str, dict[str, int]]
    Files = dict[str, tuple[str, int]]

# Numbers that JSON and Python read alike, finite and not too long for either.
_WHOLE = "(?:0|[1-9][0-9]{0,17})"
_NUMBER = rf"({_WHOLE}(?:\.[0-9]{{1,18}})?(?:e-0?[0-9])?)"
_MOST_KEPT = 1 << 16
"""Counts, and sizes, that a reader keeps to share: most lines repeat one of a few."""


class Done:
    """One finished chunk.

    Attributes
    ----------
    files : dict of str to (str, int)
        SHA-256 and bytes of each file, by the name of its array.
    sizes : dict of str to int
        Bytes of each file.
    counts : dict of str to dict of str to int
        Cells of each status code, by output.
    seconds : float
        What it took to compute.
    at : float
        When its line was written, in seconds since 1970.
    """

    __slots__ = ("_files", "at", "chunk", "counts", "seconds", "sizes")

    def __init__(
        self,
        chunk: int,
        files: Files | bytes,
        counts: Counts,
        seconds: float,
        at: float = 0.0,
        sizes: dict[str, int] | None = None,
    ) -> None:
        self.chunk = chunk
        # As text where it was read so: a hundred thousand dictionaries take longer than all else.
        self._files = files
        self.counts = counts
        self.seconds = seconds
        self.at = at
        self.sizes = {n: size for n, (_, size) in self.files.items()} if sizes is None else sizes

    @property
    def files(self) -> Files:
        """SHA-256 and bytes of each file, by the name of its array."""
        given = self._files
        return _files(json.loads(given)) if isinstance(given, bytes) else given


def line_of(record: dict[str, Any]) -> bytes:
    """Return a record as a line."""
    text = json.dumps(record, separators=(",", ":")).encode()
    return text + b"\t%08x\n" % zlib.crc32(text)


class Reader:
    """Reads lines of the logs of one run.

    Parameters
    ----------
    names : sequence of str
        Arrays of the run, in the order in which lines name their files.
    """

    def __init__(self, names: Sequence[str]) -> None:
        files = ",".join(
            rf'{re.escape(json.dumps(name))}:\["[0-9a-f]{{64}}",({_WHOLE})\]' for name in names
        )
        self._names = tuple(names)
        self._written = re.compile(
            rf'\{{"chunk":({_WHOLE}),"files":(\{{{files}\}}),"counts":(\{{.*\}}),'
            rf'"seconds":{_NUMBER},"at":{_NUMBER}\}}'.encode()
        ).fullmatch
        self._counts: dict[bytes, Counts] = {}
        self._sizes: dict[tuple[bytes, ...], dict[str, int]] = {}

    def read(self, line: bytes) -> Done | dict[str, Any] | None:
        """Return a finished chunk, or what a writer says of itself; None for what is not whole.

        Lines that say the same share one dictionary of `counts`, and one of `sizes`.
        """
        text, tab, check = line.rpartition(b"\t")
        if not tab or check != b"%08x" % zlib.crc32(text):
            return None
        try:
            found = self._written(text)
            return (found and self._of_form(found.groups())) or _of_json(text)
        except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError):
            return None

    def _of_form(self, words: tuple[bytes, ...]) -> Done | None:
        text, key = words[-3], words[2:-3]
        counts, sizes = self._counts.get(text), self._sizes.get(key)
        if counts is None:
            try:
                counts = _counts(json.loads(text))
            except ValueError:
                # No JSON by itself: a key of the line may stand twice.
                return None
            if len(self._counts) < _MOST_KEPT:
                self._counts[text] = counts
        if sizes is None:
            sizes = dict(zip(self._names, map(int, key), strict=True))
            if len(self._sizes) < _MOST_KEPT:
                self._sizes[key] = sizes
        return Done(int(words[0]), words[1], counts, float(words[-2]), float(words[-1]), sizes)


def _of_json(text: bytes) -> Done | dict[str, Any]:
    record = json.loads(text.decode())
    if "chunk" not in record:
        return {**record, "at": _finite(record.get("at", 0.0))}
    return Done(
        int(record["chunk"]), _files(record["files"]), _counts(record["counts"]),
        _finite(record["seconds"]), _finite(record["at"]),
    )  # fmt: skip


def _files(record: dict[str, Any]) -> Files:
    return {name: (str(sha), int(size)) for name, (sha, size) in record.items()}


def _counts(record: dict[str, Any]) -> Counts:
    return {name: {code: int(n) for code, n in codes.items()} for name, codes in record.items()}


def _finite(value: Any) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(value)
    return number
