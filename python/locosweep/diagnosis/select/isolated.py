"""Single readings off what fits their neighbours: too small to stand out of the motion itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from locosweep.diagnosis.data.readings.finding import Finding
from locosweep.diagnosis.estimate.least_squares import evaluate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]

_HALF = 3
"""Readings on either side that a line is laid through."""
_LONGEST = 3
"""Bad readings in a row, at most."""
_OFF = 7.0
"""Deviations off that line from which a reading is none: noise alone reaches it never."""
_REPEATED = 4.5
"""The same for a reading that repeats the one before exactly."""
_CLOSE = 3.5
"""Deviations within which the neighbours themselves lie about their line: elsewhere the model
errs by much from sample to sample, and says nothing about single ones."""
_FAR, _MOSTLY = 2.0, 0.5
"""Mean square of what a fit leaves, in that of noise, from which it is far more; and the share of
what is beyond noise that single readings have to hold there. Not derived."""
_MOST = 0.05
"""Share of a run's readings up to which they are single ones."""


def isolated_readings(problem: Problem, fit: Fit) -> tuple[list[Flags], list[Finding]]:
    """Return which positions of each run stand off the fit alone, and the findings.

    An error of the model grows and fades over many samples, a bad reading comes and goes. There
    are none where a fit leaves far more than noise, most of it elsewhere: without them, it would
    leave as much.
    """
    problem, every = problem.of_all_samples(), list(range(len(problem.runs)))
    (whole,) = evaluate(problem, [fit.unfitted()], every)
    flags = [np.zeros(run.t.size, dtype=bool) for run in problem.runs]
    squares, single = 0.0, 0.0
    findings: list[Finding] = []
    first = problem.channels.index("x") * problem.count
    for r, run in enumerate(problem.runs):
        a, b = int(problem.starts_at[r]), int(problem.starts_at[r + 1])
        used = np.flatnonzero(problem.weights["x"][a:b] > 0.0)
        values = run.channels["x"][used]
        own = whole.residual[first + a : first + b][used]
        off = _off_line(own, values)
        squares += float(own @ own)
        if not 0 < off.sum() <= _MOST * used.size:
            continue
        flags[r][used[off]] = True
        single += float(own[off] @ own[off])
        same = np.append(False, np.diff(values) == 0.0)
        for kind, one in (("spike", off & ~same), ("dropout", off & same)):
            findings += [
                Finding(run.label, float(run.t[i]), float(run.t[i]), "x", kind, 1, masked=True)
                for i in used[one]
            ]
    count = np.count_nonzero(problem.weights["x"])
    if squares > _FAR * count and single < _MOSTLY * (squares - count):
        return [np.zeros_like(one) for one in flags], []
    return flags, findings


def _off_line(residual: Floats, values: Floats) -> Flags:
    """Return which whitened residuals stand off the line through their neighbours."""
    off = np.zeros(residual.size, dtype=bool)
    repeated = np.append(False, np.diff(values) == 0.0)
    limit = np.where(repeated, _REPEATED, _OFF)
    for length in range(1, _LONGEST + 1):
        width = 2 * _HALF + length
        if residual.size < width:
            break
        inside = np.arange(_HALF, _HALF + length)
        around = np.delete(np.arange(width), inside)
        windows = sliding_window_view(residual, width)
        lines = windows[:, around] @ np.linalg.pinv(np.vander(around, 2)).T
        beside = np.abs(windows[:, around] - lines @ np.vander(around, 2).T).max(axis=1)
        away = np.abs(windows[:, inside] - lines @ np.vander(inside, 2).T)
        limits = sliding_window_view(limit, width)[:, inside]
        for first in np.flatnonzero((beside < _CLOSE) & (away > limits).all(axis=1)):
            off[first + inside] = True
    return off
