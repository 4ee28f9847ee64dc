"""Clocks of measured runs: packets of rows with one stamp, jittered stamps, rows that miss."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.missing_rows import with_missing_rows
from locosweep.diagnosis.data.ticks import evidence, spread_packets, times_of_ticks

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

_SURE = 7.0
"""Log likelihood by which x has to be smoother over ticks than over stamps: 1000 to one."""
_SHOWN = 5
"""Runs that a sentence names, at most."""


@dataclass(frozen=True)
class Finding:
    """What was found about the clock of one run."""

    run: str
    t0: float
    """First and last time that it concerns, s."""
    t1: float
    column: str
    kind: str
    samples: int
    """Samples that it concerns."""
    masked: bool
    """True if they take no part in fits."""
    what: str = ""
    """In words, for a sentence that counts the samples of all runs."""


_PACKETS = "rows came in packets with one time stamp: they are spread evenly"
_JITTER = "rows have stamps that jump about an even clock, over which x is smoother: it is taken"
_MISSING = (
    "rows are missing: the drive there is known only within bounds, and what it may have "
    "changed counts as noise"
)


def packets_spread(findings: list[Finding]) -> Callable[[str, Floats], Floats]:
    """Return a function that spreads the packets in the stamps of a run, given its label.

    What it finds is appended to `findings`. Stamps in which it sees no packets stay.
    """

    def spread(label: str, t: Floats) -> Floats:
        even = spread_packets(t)
        if even is None:
            return t
        repeated = int((np.diff(t) == 0.0).sum())
        findings.append(_over(label, t, repeated, _PACKETS))
        return even

    return spread


def on_their_clocks(runs: Sequence[Run]) -> tuple[list[Run], list[Finding]]:
    """Return runs at the ticks of their clocks, with a row for each tick, and what was found.

    Rows that missed have no readings, and a drive within bounds (`Run.drive_deviation`).
    """
    found: list[Finding] = []
    even = [times_of_ticks(run.t) for run in runs]
    known = [(run, t) for run, t in zip(runs, even, strict=True) if t is not None]
    # One logger wrote them all, and a run that rests does not tell.
    jittered = sum(evidence(run.channels["x"], t, run.t) for run, t in known) > _SURE
    mended = []
    for run, t in zip(runs, even, strict=True):
        ticking = run
        if t is not None and jittered:
            found.append(_over(run.label, run.t, run.t.size, _JITTER))
            ticking = replace(run, t=t)
        whole, gaps = with_missing_rows(ticking)
        found += [
            Finding(run.label, t0, t1, "t", "clock", count, masked=True, what=_MISSING)
            for t0, t1, count in gaps
        ]
        mended.append(whole)
    return mended, found


def _over(label: str, t: Floats, samples: int, what: str) -> Finding:
    """Return a finding over a whole run, of samples that stay in the fit."""
    return Finding(label, float(t[0]), float(t[-1]), "t", "clock", samples, masked=False, what=what)


def in_words(findings: Sequence[Finding]) -> list[str]:
    """Return a sentence for each kind of finding, with the runs and samples that it concerns."""
    sentences = []
    for what in dict.fromkeys(finding.what for finding in findings):
        own = [finding for finding in findings if finding.what == what]
        labels = list(dict.fromkeys(finding.run for finding in own))
        shown = ", ".join(labels[:_SHOWN])
        more = f" and {len(labels) - _SHOWN} others" if len(labels) > _SHOWN else ""
        runs = f"run {shown}" if len(labels) == 1 else f"runs {shown}{more}"
        sentences.append(f"{runs}: {sum(finding.samples for finding in own)} {what}")
    return sentences
