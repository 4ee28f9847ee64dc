"""Files that appear under their name only when they are whole."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from locosweep.errors import InputError, printable

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import polars as pl

_FORMULA = ("=", "+", "-", "@", " ")
"""Beginnings of formulas; a space may have been a tab or a line end before one."""


def check_file_name(path: str | os.PathLike[str]) -> Path:
    """Refuse a path that cannot become a file: a folder, or in none that exists."""
    path = Path(path)
    if "\0" in str(path):
        raise InputError(f"{str(path)!r}: a file name cannot have a NUL in it")
    if path.is_dir():
        raise InputError(f"{path} is a folder: name a file")
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist")
    return path


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path that replaces `path` when all went well.

    Nothing half-written is left under the final name, whatever happens.
    """
    path = check_file_name(path)
    try:
        handle, name = tempfile.mkstemp(suffix=path.suffix, prefix=".locosweep-", dir=path.parent)
    except OSError as error:
        raise InputError(f"{path}: cannot write: {error.strerror}") from None
    os.close(handle)
    try:
        yield Path(name)
        mask = os.umask(0)
        os.umask(mask)
        Path(name).chmod(0o666 & ~mask)
        Path(name).replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot write: {error.strerror or error}") from None
    finally:
        Path(name).unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text file in UTF-8."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def write_frame(
    path: str | os.PathLike[str],
    frame: pl.DataFrame,
    metadata: Mapping[str, str] | None = None,
    *,
    csv: bool = True,
) -> None:
    """Write a table as Parquet with its metadata, or as CSV if the name ends so and `csv`."""
    import polars as pl

    with replacing(path) as temporary:
        try:
            if csv and temporary.suffix.lower() == ".csv":
                # Quotes only where needed: files without any are read ten times as fast.
                style: Literal["non_numeric", "necessary"] = (
                    "non_numeric" if _looks_like_comment(frame) else "necessary"
                )
                _harmless(frame).write_csv(temporary, quote_style=style)
            else:
                frame.write_parquet(temporary, metadata=dict(metadata) if metadata else None)
        except (pl.exceptions.PolarsError, pl.exceptions.PanicException) as error:
            raise InputError(f"{path}: cannot write: {error}") from None


def _looks_like_comment(frame: pl.DataFrame) -> bool:
    """Return whether a row could begin as a comment does, which readers leave out."""
    import polars as pl

    if not frame.width or frame.dtypes[0] != pl.String:
        return False
    return bool(frame.to_series().str.contains(r"^(#|%|//)").any())


def _harmless(frame: pl.DataFrame) -> pl.DataFrame:
    """Return a table of which no text is a formula to a spreadsheet or steers a terminal."""
    import polars as pl

    for name, kind in frame.schema.items():
        if kind == pl.String:
            texts = frame[name].unique().drop_nulls().to_list()
            changed = {text: new for text in texts if (new := _plain(text)) != text}
            if changed:
                frame = frame.with_columns(pl.col(name).replace(changed))
    return frame


def _plain(text: str) -> str:
    """Return a text that a spreadsheet takes as one: behind an apostrophe where it begins so."""
    shown = printable(text)
    with contextlib.suppress(ValueError):
        float(shown)
        return shown
    return f"'{shown}" if shown.startswith(_FORMULA) else shown
