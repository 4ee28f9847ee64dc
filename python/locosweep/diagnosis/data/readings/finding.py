"""Findings about readings: where they are, what kind, and a sentence for each group of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

_WORDS = {
    "spike": ("lies far off its neighbours", "lie far off their neighbours"),
    "dropout": ("dropped out", "dropped out"),
    "frozen": ("is frozen", "are frozen"),
}
"""Words for one reading and for several, by kind of fault."""
_SHOWN = 4
"""Significant digits of times and lengths in sentences."""


@dataclass(frozen=True)
class Finding:
    """One fault of a column of one run, from `t0` to `t1` in s."""

    run: str
    t0: float
    t1: float
    column: str
    kind: str
    """spike, dropout, frozen, slip, unit, sign, swapped or clock."""
    samples: int
    """Readings that the fault spoils."""
    masked: bool
    """True if these readings take no part in the diagnosis."""
    note: str = ""
    """What a person should know beside, for instance how far a slip went."""
    likely: str = ""
    """Likely unit, or the column that this one was swapped with."""

    def row(self) -> dict[str, Any]:
        """Return the finding as an entry of the report."""
        found: dict[str, Any] = {
            "run": self.run,
            "t0": self.t0,
            "t1": self.t1,
            "column": self.column,
            "kind": self.kind,
            "samples": self.samples,
            "masked": self.masked,
        }
        return found | ({"likely": self.likely} if self.likely else {})


def stretches_of(bad: NDArray[np.bool_], gap: int = 1) -> list[tuple[int, int]]:
    """Return first and last index of each stretch of bad samples; stretches `gap` apart are one."""
    at = np.flatnonzero(bad)
    if at.size == 0:
        return []
    cuts = np.flatnonzero(np.diff(at) > gap)
    firsts = np.concatenate([at[:1], at[cuts + 1]])
    lasts = np.concatenate([at[cuts], at[-1:]])
    return list(zip(firsts.tolist(), lasts.tolist(), strict=True))


def sentences(findings: Sequence[Finding]) -> list[str]:
    """Return a sentence for each group of findings of one run, or column, and kind."""
    groups: dict[tuple[str, str, str, str], list[Finding]] = {}
    for found in findings:
        # What is wrong with a column is wrong in all runs.
        run = found.run if found.masked else ""
        groups.setdefault((run, found.column, found.kind, found.note), []).append(found)
    return [_sentence(group) for group in groups.values()]


def _sentence(group: Sequence[Finding]) -> str:
    first = group[0]
    if not first.masked:
        return first.note
    if first.kind not in _WORDS:
        return f"run {first.run}: {first.note}"
    count = sum(found.samples for found in group)
    low, high = min(found.t0 for found in group), max(found.t1 for found in group)
    one, several = _WORDS[first.kind]
    if count == 1:
        said = f"a reading of {first.column} at {low:.{_SHOWN}g} s {one}"
    else:
        said = f"{count} readings of {first.column} between {low:.{_SHOWN}g} and "
        said += f"{high:.{_SHOWN}g} s {several}"
    note = f" ({first.note})" if first.note else ""
    done = "" if first.column == "drive" else ": left out"
    return f"run {first.run}: {said}{note}{done}"
