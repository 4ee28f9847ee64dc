"""Location of the gap: channels, runs, windows, kinds of motion, variables."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from locosweep.diagnosis.data.regimes import REGIMES, regimes_of
from locosweep.diagnosis.estimate.free_run import equal_cuts, free_errors
from locosweep.diagnosis.report.units import WIDE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Point, Problem
    from locosweep.diagnosis.report.comparison import Comparison

    Floats = NDArray[np.float64]

WINDOWS = 20
"""Windows that a run is cut into."""
_SHOWN = 10
_SMOOTHED = 100
"""Parts of a run over which its residual is smoothed."""


def shares(parts: dict[str, float]) -> dict[str, float]:
    """Turn sums into shares of their total."""
    total = sum(parts.values())
    return {key: value / total if total > 0.0 else 0.0 for key, value in parts.items()}


def where_of(comparison: Comparison, channel: str, *, explained: bool) -> dict[str, Any]:
    """Return the report's `where` but for its site; `explained` if the second model explains it."""
    problem = comparison.problem
    squares = comparison.gap_squares(channel, explained=explained)
    largest = windows(problem, squares)
    regimes = [regimes_of(motion) for motion in problem.motions]
    return {
        "channels": _by_channel(comparison),
        "runs": by_run(comparison, channel),
        "windows": largest,
        # Windows start anew: where a gap shows is where it arises.
        "origin": [dict(row) for row in largest]
        if comparison.seconds
        else origin(problem, comparison.before),
        "regimes": regime_shares(squares, regimes),
    }


def _by_channel(comparison: Comparison) -> list[dict[str, Any]]:
    before, after = comparison.squares
    sums = {
        c: float(np.nansum(np.concatenate(squares))) / comparison.noise[c].sd ** 2
        for c, squares in before.items()
    }
    return [
        {
            "channel": c,
            "before": rms(before[c]),
            "after": rms(after[c]),
            "unit": comparison.unit(c),
            "share": share,
        }
        for c, share in shares(sums).items()
    ]


def by_run(comparison: Comparison, channel: str) -> list[dict[str, Any]]:
    """Return the error of both models in every run."""
    before, after = (squares[channel] for squares in comparison.squares)
    return [
        {"run": run.label, "before": rms([a]), "after": rms([b])}
        for run, a, b in zip(comparison.problem.runs, before, after, strict=True)
    ]


def rms(squares: Sequence[Floats]) -> float | None:
    """Return the root of the mean of what is known; None where nothing is."""
    values = np.concatenate(squares)
    values = values[np.isfinite(values)]
    return float(np.sqrt(values.mean())) if values.size else None


def smooth_square(residual: Floats, deviation: float) -> Floats:
    """Return the square of a smoothed residual, without the part that noise has in it."""
    known = np.isfinite(residual)
    width = max(1, residual.size // _SMOOTHED)
    count = uniform_filter1d(known.astype(float), width)
    mean = uniform_filter1d(np.where(known, residual, 0.0), width) / np.maximum(count, 1e-9)
    noise = deviation**2 / np.maximum(width * count, 1.0)
    return np.where(known, np.maximum(mean**2 - noise, 0.0), 0.0)


def windows(problem: Problem, squares: list[Floats]) -> list[dict[str, Any]]:
    """Return the windows that hold most of some squares, run by run, largest first."""
    total = float(sum(s.sum() for s in squares))
    cuts = equal_cuts(problem, WINDOWS, least=1)
    found = [(float(squares[r][a:b].sum()), r, a, b) for r, a, b in cuts]
    found.sort(key=lambda f: (-f[0], f[1], f[2]))
    rows = []
    for value, r, a, b in found[:_SHOWN]:
        if total <= 0.0 or value <= 0.0:
            break
        run = problem.runs[r]
        end = run.t[b] if b < run.t.size else run.t[-1]
        rows.append(
            {"run": run.label, "t0": float(run.t[a]), "t1": float(end), "share": value / total}
        )
    return rows


def origin(problem: Problem, point: Point) -> list[dict[str, Any]]:
    """Return the windows in which the gap arises: the model restarted at each one's start."""
    squares = [np.zeros(int(n)) for n in problem.lengths]
    cuts = equal_cuts(problem, WINDOWS)
    for (r, a, b), e in zip(cuts, free_errors(problem, point, cuts), strict=True):
        t, ok = problem.runs[r].t[a:b], np.isfinite(e)
        if ok.sum() < 4:
            continue
        base = np.vander(t[ok] - t[0], 2)
        left = e[ok] - base @ np.linalg.lstsq(base, e[ok], rcond=None)[0]
        floor = problem.noise["x"].sd ** 2 * ok.sum()
        squares[r][a:b] = max(float(left @ left) - floor, 0.0) / (b - a)
    return windows(problem, squares)


def horizons(
    problem: Problem, before: Point, after: Point, runs: list[int], seconds: tuple[float, ...]
) -> list[dict[str, float]]:
    """Errors of free runs that start anew from the measured state every so many seconds."""
    return [
        {"seconds": horizon, "before": errors[0], "after": errors[1]}
        for horizon, errors in free_run_errors(problem, [before, after], runs, seconds)
    ]


def free_run_errors(
    problem: Problem, points: Sequence[Point], runs: Sequence[int], seconds: Sequence[float]
) -> list[tuple[float, list[float]]]:
    """Return lengths of free runs in s, and the error of each model in runs of that length.

    Runs start anew from the measured state; lengths beyond the longest run are left out.
    """
    rows = []
    for horizon in seconds:
        cuts: list[tuple[int, int, int]] = []
        for r in runs:
            t = problem.runs[r].since_start
            marks = np.searchsorted(t, np.arange(0.0, t[-1], horizon))
            edges = np.unique(np.append(marks, t.size))
            cuts.extend((r, int(a), int(b)) for a, b in pairwise(edges) if b - a >= 2)
        if not cuts or all(problem.runs[r].since_start[-1] < horizon for r in runs):
            continue
        errors = []
        for point in points:
            e = np.concatenate(free_errors(problem, point, cuts))
            errors.append(float(np.sqrt(np.nanmean(e**2))))
        rows.append((horizon, errors))
    return rows


def regime_shares(squares: list[Floats], regimes: list[NDArray[np.int64]]) -> list[dict[str, Any]]:
    """Shares of squares by kind of motion, largest first."""
    parts = dict.fromkeys(REGIMES, 0.0)
    for values, kinds in zip(squares, regimes, strict=True):
        for k, name in enumerate(REGIMES):
            parts[name] += float(values[kinds == k].sum())
    found = sorted(shares(parts).items(), key=lambda item: -item[1])
    return [{"regime": name, "share": share} for name, share in found if share > 0.0]


def force_view(problem: Problem, point: Point, mass: float) -> dict[str, Any]:
    """Return the force that the model lacks, over each variable it may depend on.

    Each window gives the constant force that its residual bends by; bins of equal
    count give centres, means and half widths of their 95 % intervals.
    """
    count = int(np.clip(problem.count / (len(problem.runs) * 25), 10, 60))
    cuts = equal_cuts(problem, count)
    swept = [
        motion.sliding_distance(run.sliding_distance)
        for motion, run in zip(problem.motions, problem.runs, strict=True)
    ]
    rows = []
    for (r, a, b), e in zip(cuts, free_errors(problem, point, cuts), strict=True):
        run, x, v = problem.runs[r], problem.motions[r].x, problem.motions[r].v
        t, ok = run.t[a:b], np.isfinite(e)
        if ok.sum() < 8 or np.abs(v[a:b]).min() < problem.motions[r].resting_speed:
            continue
        base = np.vander(t[ok] - t[0], 3)
        bend = np.linalg.lstsq(base, e[ok], rcond=None)[0][0]
        rows.append(
            (
                2.0 * mass * bend,
                float(v[a:b].mean()),
                float(x[a:b].mean()),
                float(run.since_start[a:b].mean()),
                float(run.drive[a:b].mean() * problem.nominal["gain"]),
                float(swept[r][a:b].mean()),
            )
        )
    if len(rows) < 8:
        return {}
    table = np.array(rows)
    view: dict[str, Any] = {}
    for k, name in enumerate(("v", "x", "t", "drive", "distance"), start=1):
        order = np.argsort(table[:, k], kind="stable")
        bins = np.array_split(order, min(12, max(3, order.size // 6)))
        centres = np.array([table[b, k].mean() for b in bins])
        means = np.array([table[b, 0].mean() for b in bins])
        halves = np.array([WIDE * table[b, 0].std(ddof=1) / np.sqrt(b.size) for b in bins])
        view[name] = (centres, means, halves)
    return view
