"""Error of free runs by their length: of the nominal model, and after each cause."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.report.localization import free_run_errors

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.report.comparison import Comparison

    Floats = NDArray[np.float64]

_POINTS = 30
"""Lengths at which the error of whole runs is shown."""
_FIRST = 0.02
"""Shortest length, as a share of the longest run: a run begins at rest."""
_RESTARTED = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
"""Lengths in s of free runs that start anew from the measured state."""


def errors_by_length(
    nominal: Comparison, later: Mapping[str, Comparison], channel: str
) -> dict[str, Any]:
    """Return lengths of free runs in s, and by model the rmse of all samples up to each length.

    `later` are the models with one cause more each, by its name, each before that with all of
    them, from which all take their starts. Whole runs are free from their start; runs that are
    replayed in windows start anew from the measured state every so often. Runs are those kept
    from the fit, else all.
    """
    problem = nominal.problem
    judged = list(problem.held) or list(range(len(problem.runs)))
    names = ["nominal model", *later]
    if nominal.seconds:
        points = [nominal.before, *(one.before for one in later.values())]
        rows = free_run_errors(problem, points, judged, _RESTARTED) if channel == "x" else []
        seconds = [length for length, _ in rows]
        errors = [[row[k] for _, row in rows] for k in range(len(names))]
    else:
        squares = [nominal.squares[0], *(one.squares[0] for one in later.values())]
        times = [problem.runs[r].since_start for r in judged]
        longest = max(float(t[-1]) for t in times)
        seconds = np.linspace(_FIRST * longest, longest, _POINTS).tolist()
        errors = [
            _up_to(seconds, times, [own[channel][r] for r in judged]) if channel in own else []
            for own in squares
        ]
    return {
        "seconds": seconds,
        "errors": dict(zip(names, errors, strict=True)),
        "restarted": bool(nominal.seconds),
    }


def _up_to(
    seconds: Sequence[float], times: Sequence[Floats], squares: Sequence[Floats]
) -> list[float]:
    """Return the root of the mean of all squares up to each time; NaN before the first."""
    t, values = np.concatenate(times), np.concatenate(squares)
    order = np.argsort(t, kind="stable")
    t, values = t[order], values[order]
    known = np.isfinite(values)
    sums, counts = np.cumsum(np.where(known, values, 0.0)), np.cumsum(known)
    at = np.searchsorted(t, np.asarray(seconds) + 1e-9, side="right") - 1
    return [
        float(np.sqrt(sums[i] / counts[i])) if i >= 0 and counts[i] else float("nan") for i in at
    ]
