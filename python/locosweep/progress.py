"""Progress of a sweep: a protocol and a line on the terminal."""

from __future__ import annotations

import sys
from typing import Protocol, TextIO

__all__ = ["Meter", "Progress"]


class Progress(Protocol):
    """What ``progress=`` takes: called at most ten times a second and at the end."""

    def __call__(self, done: int, total: int, rate: float, /) -> object:
        """Take finished and total evaluations and evaluations per second."""


class Meter:
    """One line on standard error that is written over."""

    def __init__(self, label: str = "", stream: TextIO | None = None) -> None:
        self.label = label
        self.stream = stream or sys.stderr

    def __call__(self, done: int, total: int, rate: float, /) -> None:
        """Write the line; end it when all is done."""
        left = (total - done) / rate if rate > 0 else float("inf")
        share = done / total if total else 1.0
        text = f"{self.label} {share:4.0%}  {rate:.2e} evaluations/s"
        text += "" if done >= total else f"  {left:.0f} s left"
        self.stream.write(f"\r{text:<72}" + ("\n" if done >= total else ""))
        self.stream.flush()
