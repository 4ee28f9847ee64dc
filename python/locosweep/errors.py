"""Everything that locosweep raises."""

import re

_UNSEEN = re.compile(
    "[\x00-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff\ud800-\udfff]"
)
"""Characters that move a cursor, turn a line round or do not show: names in files may hold them."""


def printable(text: str) -> str:
    r"""Return a text in one line, with control characters as escapes.

    Examples
    --------
    >>> from locosweep.errors import printable
    >>> print(printable("run \x1b[2J\n7"))
    run \x1b[2J 7
    """
    return _UNSEEN.sub(_escaped, text)


def _escaped(found: re.Match[str]) -> str:
    char = found[0]
    if char in "\t\n\r":
        return " "
    code = ord(char)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


def first_line(error: BaseException) -> str:
    r"""Return the first line of what an error of a library says; its kind where it says nothing.

    Examples
    --------
    >>> from locosweep.errors import first_line
    >>> first_line(ValueError("no number\nat row 7")), first_line(KeyError())
    ('no number', 'KeyError')
    """
    return next(iter(str(error).splitlines()), "") or type(error).__name__


class LocosweepError(Exception):
    """Base of all errors of this package; what a file says cannot steer a terminal."""

    def __str__(self) -> str:
        return printable(super().__str__())


class InputError(LocosweepError, ValueError):
    """An argument is not allowed; the message names it, its value and what is."""


class DataFileError(InputError):
    """A file is not what it should be; the message names file, position and reason."""


class SolveError(LocosweepError, RuntimeError):
    """The motion asked for could not be computed: events too close, or without bounds."""


class Cancelled(LocosweepError):
    """A sweep was stopped through its token."""


class InternalError(LocosweepError):
    """A fault of locosweep itself, never of its input. Please report it."""
