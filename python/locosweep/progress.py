"""Progress of long calls: what ``progress=`` takes, and what True shows.

Every long call has ``progress=``. None and False show nothing. True shows a bar on a terminal or
below the cell of a notebook, and elsewhere, in a log for instance, plain lines on standard error.
A callable receives numbers (`Progress`); if it has a method ``say``, that receives the name
of each step of a call that goes through steps, and a method ``fail`` receives how many cells or
cases have failed so far, where a call counts them. `JsonLines` is such a callable for programs.
"""

from __future__ import annotations

import json
import sys
import time
from typing import TYPE_CHECKING, Any, Protocol

from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

_PAUSE = 10.0
"""Seconds between lines of a log, so that an hour of work leaves some hundreds."""


_LEAST_PAUSE = 0.1
"""Seconds between lines for programs, those of ten calls a second."""


class Progress(Protocol):
    """A callable for ``progress=``, called at most ten times a second and at the end."""

    def __call__(self, done: int, total: int, rate: float, /) -> object:
        """Take what is done and what there is (evaluations, fits, steps), and how many a second."""


def progress_of(
    given: bool | Progress | None, label: str, unit: str = "evaluations"
) -> Progress | None:
    """Return what ``progress=`` asks for: a meter for True, None for nothing.

    Examples
    --------
    >>> from locosweep.progress import progress_of
    >>> progress_of(False, "sweep") is None
    True
    >>> progress_of(print, "sweep") is print
    True
    """
    if given is True:
        return Meter(label, unit)
    if given is None or given is False:
        return None
    if not callable(given):
        raise InputError(f"progress is {given!r}: allowed are True, False, None and a callable")
    return given


class Steps:
    """Progress of a call through steps, of which each may take any time; call it with a name.

    Parameters
    ----------
    progress : Progress or None
        Receives how many steps lie behind, and by ``say``, if it has that, the name of the step.
    names : sequence of str
        The steps in their order; some may be left out or come again.

    Examples
    --------
    >>> from locosweep.progress import Steps
    >>> step = Steps(lambda done, total, rate: print(done, "of", total), ["read", "fit", "draw"])
    >>> step("read"), step("draw"), step("fit"), step.end()
    0 of 3
    2 of 3
    2 of 3
    3 of 3
    (None, None, None, None)
    """

    def __init__(self, progress: Progress | None, names: Sequence[str]) -> None:
        self.progress = progress
        self.names = list(names)
        self.done = 0
        self._begun = time.perf_counter()

    def __call__(self, name: str) -> None:
        """Say which step begins."""
        if name in self.names:
            self.done = max(self.done, self.names.index(name))
        say = getattr(self.progress, "say", None)
        if say is not None:
            say(name)
        self._tell()

    def end(self) -> None:
        """Say that all steps are done."""
        self.done = len(self.names)
        self._tell()

    def _tell(self) -> None:
        if self.progress is not None:
            rate = self.done / max(time.perf_counter() - self._begun, 1e-9)
            self.progress(self.done, len(self.names), rate)


class Meter:
    """A bar on a terminal or in a notebook, lines elsewhere; drawn when first called.

    Parameters
    ----------
    label : str
        Text before the bar.
    unit : str
        Plural of what is counted.
    """

    def __init__(self, label: str = "", unit: str = "evaluations") -> None:
        self.label = label
        self.unit = unit
        self._begun = time.perf_counter()
        self._written = self._begun
        self._step = ""
        self._bar: Any = None

    def __call__(self, done: int, total: int, rate: float = 0.0, /) -> None:
        """Draw the bar; end its line when all is done."""
        if not _draws():
            self._write(done, total)
            return
        new = self._bar is None
        bar = self._drawn(total)
        if new:
            # Its clock began with the work, not with the first call.
            since = done / rate if rate > 0 else time.perf_counter() - self._begun
            bar.start_t -= since
        bar.total = total
        bar.update(done - bar.n)
        if self._step:
            bar.set_description_str(f"{self.label}: {self._step}, {done} of {total} steps done")
        if done >= total:
            bar.leave = not self._step
            self.close()

    def say(self, text: str) -> None:
        """Show the name of the step that begins."""
        self._step = text
        if _draws():
            self._drawn().set_description_str(f"{self.label}: {text}")
        else:
            self._line(text)

    def note(self, text: str) -> None:
        """Show a text behind the numbers of the bar, from its next drawing on."""
        if self._bar is not None:
            self._bar.set_postfix_str(text, refresh=False)

    def fail(self, failures: int) -> None:
        """Show how many have failed, if any."""
        if failures:
            self.note(f"{failures} failed")

    def close(self) -> None:
        """Erase what is not finished."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None

    def _drawn(self, total: int = 0) -> Any:
        if self._bar is None:
            # Takes longer to import than most sweeps run.
            from tqdm.auto import tqdm

            # Steps take unlike times: what is left of them cannot be told.
            form = "{desc} [{elapsed}]" if self._step else None
            # Not left where an error ends the call: its message takes the line.
            self._bar = tqdm(
                total=total, desc=self.label or None, unit=f" {self.unit}",
                unit_scale=self.unit == "evaluations", leave=False, mininterval=0.0, miniters=1,
                smoothing=0.0, bar_format=form,
            )  # fmt: skip
            if (self._bar.ncols or 1) < 1:
                # A terminal that does not know its size would show nothing.
                self._bar.ncols = self._bar.nrows = None
        return self._bar

    def _write(self, done: int, total: int) -> None:
        """Write a line for a log, now and then and at the end; steps have theirs."""
        now = time.perf_counter()
        ends = done >= total
        if self._step or not (ends or now - self._written > _PAUSE):
            return
        self._written = now
        taken = now - self._begun
        left = "" if ends or not done else f", {taken * (total - done) / done:.0f} s left"
        share = 100 * done // total if total else 100
        self._line(f"{share}% of {total} {self.unit}, {taken:.1f} s{left}")

    def _line(self, text: str) -> None:
        sys.stderr.write(f"{self.label}: {text}\n")
        sys.stderr.flush()


class JsonLines:
    """A line of JSON on standard error for each event, ten a second at most, for programs.

    Each line has ``event`` (progress or step), ``what``, ``unit``, ``step``, ``done``,
    ``total``, ``rate`` (in 1/s), ``eta_s`` (in s) and ``failures``; null is what is not known.

    Parameters
    ----------
    what : str
        What is done.
    unit : str
        Plural of what is counted; of steps, which take unlike times, no time left is told.

    Examples
    --------
    >>> import contextlib, io, json
    >>> from locosweep.progress import JsonLines
    >>> with contextlib.redirect_stderr(io.StringIO()) as told:
    ...     JsonLines("sweep")(30, 90, 20.0)
    >>> line = json.loads(told.getvalue())
    >>> line["event"], line["done"], line["total"], line["rate"], line["eta_s"]
    ('progress', 30, 90, 20.0, 3.0)
    """

    def __init__(self, what: str, unit: str = "evaluations") -> None:
        self.what = what
        self.unit = unit
        self._begun = time.perf_counter()
        self._written = -_LEAST_PAUSE
        self._step: str | None = None
        self._failures: int | None = None
        self._state: tuple[int | None, int | None, float | None] = (None, None, None)

    def __call__(self, done: int, total: int, rate: float = 0.0, /) -> None:
        """Write what is done; without a rate it is that since the begin."""
        rate = rate or done / max(time.perf_counter() - self._begun, 1e-9)
        self._state = (int(done), int(total), float(rate))
        now = time.perf_counter()
        if done >= total or now - self._written >= _LEAST_PAUSE:
            self._written = now
            self._write("progress")

    def say(self, text: str) -> None:
        """Write the name of the step that begins."""
        self._step = text
        self._write("step")

    def fail(self, failures: int) -> None:
        """Take how many have failed, for the next line."""
        self._failures = failures

    def close(self) -> None:
        """End; every line is whole."""

    def _write(self, event: str) -> None:
        done, total, rate = self._state
        left = None
        if done is not None and total is not None and (done >= total or self.unit != "steps"):
            left = 0.0 if done >= total else (total - done) / rate if rate else None
        line = {
            "event": event, "what": self.what, "unit": self.unit, "step": self._step,
            "done": done, "total": total, "rate": _digits(rate), "eta_s": _digits(left),
            "failures": self._failures,
        }  # fmt: skip
        sys.stderr.write(json.dumps(line, separators=(",", ":")) + "\n")
        sys.stderr.flush()


def _digits(value: float | None) -> float | None:
    """Return six digits, more than a clock is worth."""
    return None if value is None else float(f"{value:.6g}")


def _draws() -> bool:
    """Return whether a bar can be redrawn: on a terminal and in a notebook."""
    if sys.stderr.isatty():
        return True
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell is not None and "IPKernelApp" in getattr(shell, "config", {})
