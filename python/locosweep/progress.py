"""Progress of long calls: the protocol of callables, and a bar for terminals and notebooks."""

from __future__ import annotations

from typing import Any, Protocol


class Progress(Protocol):
    """A callable for ``progress=``, called at most ten times a second and at the end."""

    def __call__(self, done: int, total: int, rate: float, /) -> object:
        """Take finished and total evaluations and evaluations per second."""


class Meter:
    """A bar on standard error, or in the cell of a notebook; drawn when first called.

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
        self._bar: Any = None

    def __call__(self, done: int, total: int, rate: float = 0.0, /) -> None:
        """Draw the bar; end its line when all is done."""
        new = self._bar is None
        bar = self._drawn(total)
        if new and rate > 0:
            # Its clock began with the work, not with the first call.
            bar.start_t -= done / rate
        bar.update(done - bar.n)
        if done >= total:
            bar.leave = True
            self.close()

    def say(self, text: str) -> None:
        """Show a text in place of a bar, where no count is known."""
        self._drawn(None, "{desc}").set_description_str(f"{self.label}: {text}")

    def close(self) -> None:
        """Erase what is not finished."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None

    def _drawn(self, total: int | None, form: str | None = None) -> Any:
        if self._bar is None:
            # Takes longer to import than most sweeps run.
            from tqdm.auto import tqdm

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
