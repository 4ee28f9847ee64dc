"""Kinds of arguments of commands that fill or read run folders."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from locosweep.cli import options
from locosweep.run_folder.name import is_file_name

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem


class _FolderOrTable(click.ParamType["Path | str"]):
    """A run folder as the text that was given, or a Parquet file as a path: the ending tells."""

    name = "FOLDER/|FILE.parquet"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> Path | str:
        """Tell one from the other."""
        return options.TABLE.convert(value, param, ctx) if is_file_name(value) else str(value)


class _QuantityOrSpec(click.ParamType[str]):
    """A quantity, or a sweep file in its place."""

    name = "quantity"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Let a name pass that ends as a sweep file does."""
        text = str(value)
        return text if text.endswith(".toml") else options.QUANTITY.convert(text, param, ctx)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Complete quantities."""
        return options.QUANTITY.shell_complete(ctx, param, incomplete)


class _Shown(_QuantityOrSpec):
    """A quantity, or in its place a sweep file, a saved result or a run folder."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Let a name pass that ends as a result does, or is a folder's."""
        text = str(value)
        return text if is_result(text) or is_run(text) else super().convert(text, param, ctx)


def is_result(text: str) -> bool:
    """Return whether an argument is the name of a saved result."""
    return text.endswith(".parquet")


def is_run(text: str) -> bool:
    """Return whether an argument is a run folder: one that is there, or a name with a slash."""
    return ("/" in text and not is_file_name(text)) or Path(text).is_dir()


class _Shard(click.ParamType["tuple[int, int]"]):
    """A share of the chunks of a run."""

    name = "I/N"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """Read two whole numbers, the first one below the second."""
        if isinstance(value, tuple):
            return value
        parts = value.split("/")
        numbers = [int(p) for p in parts if p.isascii() and p.isdecimal() and len(p) <= _DIGITS]
        if not (len(parts) == len(numbers) == 2 and numbers[0] < numbers[1]):
            self.fail(f"'{value}': allowed is I/N with I from 0 to N - 1", param, ctx)
        return numbers[0], numbers[1]


_DIGITS = 18
"""More are refused before they cost time."""

QUANTITY_OR_SPEC = _QuantityOrSpec()
SHOWN = _Shown()
TABLE_OR_RUN = _FolderOrTable()
SHARD = _Shard()
run_argument = click.argument("run", metavar="RUN/", type=options.FILE)


def without_shard(command: str) -> str:
    """Return a command as it says what a folder holds, whichever process filled it.

    Examples
    --------
    >>> from locosweep.cli.run_options import without_shard
    >>> without_shard("locosweep blind-check --shard 1/4 --out 'a b'")
    "locosweep blind-check --out 'a b'"
    """
    words = shlex.split(command)
    found = [
        word for before, word in zip(["", *words], words, strict=False)
        if "--shard" not in (before, word) and not word.startswith("--shard=")
    ]  # fmt: skip
    return shlex.join(found)
