"""CSV as loggers and spreadsheets write it: encoding, comments, names and separator from the text.

Nothing is guessed that the text leaves open: an error then names the option that settles it.
"""

from __future__ import annotations

import codecs
import csv
import io
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import DataFileError, first_line
from locosweep.files.csv_form import SEPARATORS
from locosweep.files.raw import check_size

if TYPE_CHECKING:
    from collections.abc import Sequence

    import polars as pl

COMMENTS = ("#", "%", "//")
"""Beginnings of lines that are no rows."""
_COMMENTS = tuple(mark.encode() for mark in COMMENTS)
_SKIPPED = re.compile(rb"^[ \t]*(?:$|#|%|//)", re.MULTILINE)
_CHUNK = 1 << 24
"""Bytes that are looked at together; numbers about them take as much memory again."""
_LONGEST = 4 << 20
"""Bytes of the line of names: 100 thousand names of 40 characters."""
_SAMPLE = 100
"""Lines that tell separator and line of names: loggers write some dozens above it, and more rows
say nothing new; all are counted later."""
_FITTING = 20
"""Rows that fit names below other lines: a run needs as many."""
_EDGES = re.compile(rb"^ +| +$", re.MULTILINE)
_MONITOR = re.compile(rb"^\d\d:\d\d:\d\d\.\d{3} -> ", re.MULTILINE)
"""What the serial monitor of Arduino puts before each line."""
_NUMBER = re.compile(r"\s*[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?\s*")
MISSING = ("", "nan", "na", "null")
"""Cells without a value, in lower case."""


@dataclass(frozen=True)
class Text:
    """Rows of a CSV file, line ends being LF, and what is known of its columns."""

    names: list[str]
    separator: str
    body: bytes
    """The rows, in UTF-8, without comments and blank lines; empty if there are none."""
    comments: int = 0
    """Lines below the names that were left out as comments."""
    above: int = 0
    """Lines above the names that were left out: what a logger says of itself."""


def parsed(data: bytes, path: str, separator: str | None = None) -> Text:
    r"""Find the names and the rows of a CSV file.

    Parameters
    ----------
    data : bytes
        The file: UTF-8, UTF-16 with its mark, or Windows-1252 (Latin-1).
    path : str
        What messages call it.
    separator : str, optional
        Name or character of `SEPARATORS`; found from the text if not given.

    Raises
    ------
    DataFileError
        No text, no line of names, or a separator that the text leaves open.

    Examples
    --------
    >>> from locosweep.files.csv_text import parsed
    >>> found = parsed(b"# a rig\nt;x\n0,5;1,5\n", "log.csv")
    >>> found.names, found.separator, found.body
    (['t', 'x'], ';', b'0,5;1,5')
    """
    data = _as_utf8(data, path)
    if _MONITOR.match(data):
        data = _MONITOR.sub(b"", data)
    given = SEPARATORS.get(separator or "", separator)
    header, body, said, comments = _parts(data)
    if len(header) > _LONGEST:
        raise DataFileError(f"{path}: its line of names has more than {_LONGEST >> 20} MB")
    if not header.strip():
        raise DataFileError(f"{path}: empty, allowed is at least a line of names")
    rows = body[: body.find(b"\n", 1 << 20) + 1 or None].split(b"\n", _SAMPLE)[:_SAMPLE]
    sample = [row.decode() for row in rows if row]
    first = header.decode()
    if said and _are_names(said.decode(), first):
        # NumPy's savetxt and rostopic write the names as a comment.
        body = header + b"\n" + body if body else header
        sample, first = [first, *sample[: _SAMPLE - 1]], said.decode()
    if _all_numbers(first):
        raise DataFileError(f"{path}: its first line holds numbers: allowed is a line of names")
    if given is None and (count := _blank_columns(sample)):
        names = re.split(r"\s{2,}", first.strip())
        names = names if len(names) == count else first.split()
        return Text(names, "\t", re.sub(rb" +", b"\t", _EDGES.sub(b"", body)), comments)
    above = _lines_above(first, sample, [given] if given else list(SEPARATORS.values()))
    if above:
        first, sample, body = sample[above - 1], sample[above:], body.split(b"\n", above)[above]
    char = given or _separator(first, sample, path)
    names = [name.strip() for name in _fields(first, char)]
    return Text(names, char, body, comments, above)


def frame_of(text: Text, path: str, keep: Sequence[int]) -> pl.DataFrame:
    """Return the columns at the places `keep`, as text, under their places as names.

    DataFileError if a row is shorter or longer than the line of names, or has an open quote.
    """
    import polars as pl

    if not text.body:
        return pl.DataFrame({str(place): pl.Series([], dtype=pl.String) for place in keep})
    check_size(path, text.body.count(b"\n") + 1, len(keep))
    _check_lengths(text, path)
    try:
        frame = pl.read_csv(
            text.body,
            has_header=False,
            separator=text.separator,
            columns=sorted(keep),
            infer_schema=False,
            truncate_ragged_lines=False,
        )
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
        raise DataFileError(f"{path}: not a readable CSV file: {first_line(error)}") from None
    return frame.rename(dict(zip(frame.columns, map(str, sorted(keep)), strict=True)))


def _as_utf8(data: bytes, path: str) -> bytes:
    """Return the text in UTF-8 with LF at line ends, without a byte order mark."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            data = data.decode("utf-16").encode()
        except UnicodeDecodeError:
            raise DataFileError(f"{path}: not text: its UTF-16 is broken") from None
    data = data.removeprefix(codecs.BOM_UTF8)
    if b"\0" in data:
        line = data.count(b"\n", 0, data.index(b"\0")) + 1
        raise DataFileError(f"{path}: line {line}: a NUL byte, so this is no text file")
    broken = _not_utf8(data)
    if broken is not None:
        line = data.count(b"\n", 0, broken) + 1
        try:
            text = data.decode("cp1252")
        except UnicodeDecodeError:
            text = "\x1b"
        if re.search("[\x00-\x08\x0b\x0c\x0e-\x1f]", text):
            raise DataFileError(
                f"{path}: line {line}: neither UTF-8 nor Latin-1 text, allowed is CSV or Parquet"
            ) from None
        data = text.encode()
    if b"\r" in data:
        data = data.replace(b"\r\n", b"\n")
        if b"\n" not in data:
            data = data.replace(b"\r", b"\n")
    return data


def _not_utf8(data: bytes) -> int | None:
    """Return where a text stops being UTF-8; None if all of it is."""
    decode = codecs.getincrementaldecoder("utf-8")()
    for start in range(0, len(data), _CHUNK):
        try:
            # In parts: the text as a whole would take its size once more.
            decode.decode(data[start : start + _CHUNK], final=start + _CHUNK >= len(data))
        except UnicodeDecodeError as error:
            return start + error.end - 1
    return None


def _parts(data: bytes) -> tuple[bytes, bytes, bytes, int]:
    """Return the line of names, the rows, the last comment above the names, and those below."""
    at, said, comments = 0, b"", 0
    while at < len(data):
        end = data.find(b"\n", at)
        end = len(data) if end < 0 else end
        line = data[at:end]
        at = end + 1
        bare = line.strip()
        if bare.startswith(_COMMENTS):
            said = bare.lstrip(b"#%/ ")
        elif bare and not re.fullmatch(rb'"?sep=."?', bare):
            last = len(data)
            while last > at and data[last - 1] == ord("\n"):
                last -= 1
            body = data[at:last]
            if _SKIPPED.search(body):
                rows = body.split(b"\n")
                comments = sum(row.lstrip(b" \t").startswith(_COMMENTS) for row in rows)
                body = b"\n".join(row for row in rows if not _SKIPPED.match(row))
            return line, body, said, comments
    return b"", b"", said, comments


def _fields(line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator), [])
    except csv.Error:
        return []


def _cells(line: str) -> list[str]:
    return re.split(r"[;,\t|]", line)


def _all_numbers(line: str) -> bool:
    # A decimal comma cuts a number into two numbers.
    return all(_NUMBER.fullmatch(cell) for part in _cells(line) for cell in part.split() or [""])


def _are_names(said: str, first: str) -> bool:
    """Return whether a comment names the columns of the line below it."""
    if _all_numbers(said) or _all_numbers(first):
        return not _all_numbers(said)
    above, below = _cells(said), _cells(first)
    return len(above) == len(below) > 1 and (
        any(map(_NUMBER.fullmatch, below)) and not any(map(_NUMBER.fullmatch, above))
    )


def _blank_columns(rows: list[str]) -> int:
    """Return the number of columns between blanks; 0 unless all rows are numbers so parted."""
    counts = {len(row.split()) for row in rows}
    alone = all(len(_cells(row)) == 1 and _all_numbers(row) for row in rows)
    return counts.pop() if len(counts) == 1 and alone and counts != {1} else 0


def _lines_above(first: str, rows: list[str], separators: Sequence[str]) -> int:
    """Return how many lines stand above the names: those after which all rows fit their names."""
    lines = [first, *rows]
    for above, line in enumerate(lines[:-_FITTING]):
        below = lines[above + 1 :]
        for char in separators:
            names = _fields(line, char)
            if len(names) > 1 and all(len(_fields(row, char)) == len(names) for row in below):
                named = sum(map(bool, map(str.strip, names))) > 1
                # Numbers follow at once, or below a row of units.
                numbers = named and _numbers(below[1:3], char) > max(0.5, _numbers([line], char))
                if above == 0 or numbers:
                    return above
    return 0


def _separator(header: str, rows: list[str], path: str) -> str:
    """Return the separator by which all rows have as many values as there are names."""
    counts = {char: len(_fields(header, char)) for char in SEPARATORS.values()}
    several = [char for char in counts if counts[char] > 1]
    fits = [
        char for char in several if all(len(_fields(row, char)) == counts[char] for row in rows)
    ]
    if len(several) < 2 or not fits:
        # Rows that are too short or too long are named later.
        return max(several or [","], key=lambda char: counts[char])
    if len(fits) == 1:
        return fits[0]
    # Names may hold commas and so may numbers: the right columns are those of numbers.
    share = {char: _numbers(rows, char) for char in fits}
    best = max(share.values())
    ahead = [char for char in fits if share[char] == best]
    if len(ahead) > 1:
        names = " or ".join(name for name, char in SEPARATORS.items() if char in ahead)
        raise DataFileError(f"{path}: columns may be separated by {names}: --separator settles it")
    return ahead[0]


def _numbers(rows: list[str], separator: str) -> float:
    cells = [cell for row in rows for cell in _fields(row, separator)]
    numbers = sum(_NUMBER.fullmatch(cell) is not None for cell in cells)
    return numbers / len(cells) if cells else 0.0


def _check_lengths(text: Text, path: str) -> None:
    """Refuse a row with fewer or more values than there are names."""
    wanted = len(text.names)
    wrong, has = _quoted_lengths(text, path) if b'"' in text.body else _plain_lengths(text)
    if wrong is not None:
        hint = ""
        if text.separator == "," and has == 2 * wanted:
            hint = ": decimal commas need another separator"
        raise DataFileError(
            f"{path}: row {wrong + 1} has {has} values, there are {wanted} names{hint}"
        )


def _plain_lengths(text: Text) -> tuple[int | None, int]:
    """Return the first row of another length than the names', and its length."""
    wanted, start, row = len(text.names), 0, 0
    while start < len(text.body):
        end = text.body.find(b"\n", start + _CHUNK)
        end = len(text.body) if end < 0 else end
        chars = np.frombuffer(text.body, np.uint8, end - start, start)
        starts = np.concatenate([[0], np.flatnonzero(chars == ord("\n")) + 1])
        counts = np.add.reduceat(chars == ord(text.separator), starts, dtype=np.int64) + 1
        wrong = np.flatnonzero(counts != wanted)
        if wrong.size:
            return row + int(wrong[0]), int(counts[wrong[0]])
        start, row = end + 1, row + counts.size
    return None, 0


def _quoted_lengths(text: Text, path: str) -> tuple[int | None, int]:
    lines = io.TextIOWrapper(io.BytesIO(text.body), encoding="utf-8", newline="")
    row = -1
    try:
        for row, cells in enumerate(csv.reader(lines, delimiter=text.separator, strict=True)):
            if len(cells) != len(text.names):
                return row, len(cells)
    except csv.Error as error:
        raise DataFileError(f"{path}: row {row + 2}: {error}") from None
    return None, 0
