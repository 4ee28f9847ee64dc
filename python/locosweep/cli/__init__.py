"""The command ``locosweep``.

Exit codes: 0 done, 1 internal or solver error, 2 bad input, 129 hung up, 130 Ctrl-C,
143 terminated.
Results go to standard output, everything else to standard error.
"""

from __future__ import annotations

import errno
import gc
import os
import sys
from typing import TYPE_CHECKING

import click

from locosweep.cli.commands import Commands
from locosweep.cli.signals import (
    INTERRUPTED,
    end_at_once,
    leave,
    listen,
    pressed,
    rest,
    terminated,
)
from locosweep.errors import Cancelled, InputError, SolveError, printable

if TYPE_CHECKING:
    from collections.abc import Sequence

_INTERNAL, _INPUT = 1, 2


def _show_version(ctx: click.Context, _: click.Parameter, value: bool) -> None:
    if value and not ctx.resilient_parsing:
        from locosweep import _core

        click.echo(f"locosweep {_core.version()}")
        ctx.exit()


@click.group(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_show_version,
    help="Show the version and exit.",
)  # fmt: skip
def group() -> None:
    """Parameter sweeps for rectilinear locomotion of snake and in-pipe robots."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the command's name; default ``sys.argv``.
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    listen()
    try:
        return _main(given, process=arguments is None)
    finally:
        leave()


def _main(given: list[str], *, process: bool) -> int:
    """Run the command; with `process`, this process ends with it."""
    try:
        code = _run(given)
        sys.stdout.flush()
    except OSError as error:
        _silence()
        # The reader of a pipe has seen enough: that is no error.
        if error.errno == errno.EPIPE:
            return 0
        what = "cannot write the output" if error.filename is None else error.filename
        return _fail(f"{what}: {error.strerror or error}", _INPUT)
    if process and code == INTERRUPTED:
        end_at_once(code)
    if process:
        # The process ends here: searching matplotlib for cycles takes 0.1 s.
        gc.freeze()
    return code


def _run(given: list[str]) -> int:
    if "_LOCOSWEEP_COMPLETE" in os.environ:
        group.main(given, prog_name="locosweep")
    # Not group.main: it would turn Ctrl-C and errors into its own messages.
    try:
        with group.make_context("locosweep", given or ["--help"], obj=given) as context:
            group.invoke(context)
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.ClickException as error:
        return _fail(error.format_message(), _INPUT)
    except InputError as error:
        return _fail(str(error), _INPUT)
    except MemoryError:
        return _fail("not enough memory: reduce an axis, or use --dtype float32", _INPUT)
    except (KeyboardInterrupt, click.Abort, Cancelled):
        rest()
        return _fail("interrupted", INTERRUPTED)
    except SolveError as error:
        return _fail(str(error), _INTERNAL)
    except OSError:
        raise
    except Exception as error:
        if os.environ.get("LOCOSWEEP_DEBUG") == "1":
            raise
        ended = terminated()
        rest()
        if ended is not None:
            return ended
        if pressed():
            # Imports turn Ctrl-C into errors of their own.
            return _fail("interrupted", INTERRUPTED)
        text = f"internal error, please report it: {type(error).__name__}: {error}"
        return _fail(f"{text} (LOCOSWEEP_DEBUG=1 shows where)", _INTERNAL)
    return 0


def _fail(message: str, code: int) -> int:
    """Write one line to standard error."""
    # On a terminal a half-written progress line may stand there.
    start = "\r\x1b[K" if sys.stderr.isatty() else ""
    try:
        click.echo(f"{start}locosweep: {printable(' '.join(message.split()))}", err=True)
    except OSError:
        _silence()
    return code


def _silence() -> None:
    """Keep the interpreter from failing once more when it flushes at its end."""
    null = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(null, stream.fileno())
    os.close(null)
