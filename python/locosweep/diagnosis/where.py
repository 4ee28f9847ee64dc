"""Where the gap lies: channels, runs, windows, kinds of motion, and in which variable."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import savgol_filter

from locosweep.diagnosis.result import REGIMES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.problem import Point, Problem

__all__ = [
    "force_view",
    "free_errors",
    "horizons",
    "measured_motion",
    "origin",
    "regimes_of",
    "shares",
    "windows",
]

WINDOWS = 20
"""Windows that a run is cut into."""
_SHOWN = 10
_SMOOTHED = 100
"""Parts of a run over which its residual is smoothed."""
_AFTER = 5
"""Samples after a break-away, and around a reversal, that belong to it."""


def measured_motion(
    problem: Problem, run: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Smooth position and speed of a run, and the deviation of that speed."""
    if run not in problem.motions:
        problem.motions[run] = _motion(problem, run)
    return problem.motions[run]


def _motion(problem: Problem, run: int) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    record = problem.runs[run]
    t, x = record.t, record.channels["x"]
    ok = np.isfinite(x)
    x = np.interp(t, t[ok], x[ok]) if ok.any() else np.zeros_like(t)
    step = float(np.median(np.diff(t)))
    noise = problem.noise["x"].sd
    # As wide as noise asks for: slopes to a hundredth of the run's largest.
    fast = max(float(np.ptp(x)) / max(t[-1] - t[0], 1e-12), 1e-12)
    width = int(np.ceil((3.5 * noise / (0.05 * fast * step)) ** (2.0 / 3.0)))
    width = int(np.clip(width | 1, 5, max(5, (t.size // 8) | 1)))
    even = np.linspace(t[0], t[-1], t.size)
    smooth = savgol_filter(np.interp(even, t, x), width, 2)
    speed = savgol_filter(np.interp(even, t, x), width, 2, deriv=1, delta=even[1] - even[0])
    deviation = noise * np.sqrt(12.0 / width**3) / step
    return np.interp(t, even, smooth), np.interp(t, even, speed), float(deviation)


def regimes_of(problem: Problem, run: int) -> NDArray[np.int64]:
    """Say for every sample what kind of motion it belongs to (`REGIMES`)."""
    _, v, deviation = measured_motion(problem, run)
    limit = 3.0 * deviation + 0.01 * float(np.abs(v).max(initial=0.0))
    sign = np.where(np.abs(v) <= limit, 0, np.sign(v)).astype(int)
    kind = np.where(sign == 0, 0, np.where(sign > 0, 2, 3))
    found = kind.copy()
    for i in np.flatnonzero(np.diff(sign) != 0):
        if sign[i] == 0:
            before = sign[max(0, i - 4 * _AFTER) : i]
            moved = before[before != 0]
            turned = moved.size > 0 and moved[-1] != sign[i + 1]
            found[i + 1 : i + 1 + _AFTER] = 4 if turned else 1
        elif sign[i + 1] != 0:
            found[max(0, i + 1 - _AFTER) : i + 1 + _AFTER] = 4
    return found.astype(np.int64)


def shares(parts: dict[str, float]) -> dict[str, float]:
    """Turn sums into shares of their total."""
    total = sum(parts.values())
    return {key: value / total if total > 0.0 else 0.0 for key, value in parts.items()}


def gap_squares(
    problem: Problem,
    channel: str,
    nominal: dict[str, NDArray[np.float64]],
    explained: dict[str, NDArray[np.float64]] | None,
) -> list[NDArray[np.float64]]:
    """Return the square of the gap at every sample, run by run, without the noise's part.

    It is what an explanation adds to the nominal model; without one, what is left of
    the residual when it is smoothed.
    """
    if explained is not None:
        change = explained[channel][0] - nominal[channel][0]
        change = np.where(np.isfinite(problem.measured[channel]), change, 0.0)
        return np.split(change**2, problem.starts_at[1:-1])
    e = problem.measured[channel] - nominal[channel][0]
    if channel == "x_rear":
        e = e - np.repeat(problem.rest[channel], problem.lengths)
    found = []
    for part in np.split(e, problem.starts_at[1:-1]):
        known = np.isfinite(part)
        width = max(1, part.size // _SMOOTHED)
        count = uniform_filter1d(known.astype(float), width)
        mean = uniform_filter1d(np.where(known, part, 0.0), width) / np.maximum(count, 1e-9)
        noise = problem.noise[channel].sd ** 2 / np.maximum(width * count, 1.0)
        found.append(np.where(known, np.maximum(mean**2 - noise, 0.0), 0.0))
    return found


def windows(problem: Problem, squares: list[NDArray[np.float64]]) -> list[dict[str, Any]]:
    """Return the windows that hold most of some squares, run by run, largest first."""
    total = float(sum(s.sum() for s in squares))
    found: list[tuple[float, int, int, int]] = []
    for r, values in enumerate(squares):
        edges = np.linspace(0, values.size, WINDOWS + 1).astype(int)
        for a, b in pairwise(edges):
            if b > a:
                found.append((float(values[a:b].sum()), r, int(a), int(b)))
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


def _restarted(
    problem: Problem, point: Point, cuts: list[tuple[int, int, int]]
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Replay windows (run, first, one beyond last) from their measured state.

    Returns for each its times and the residual of the position in m.
    """
    motion = {r: measured_motion(problem, r) for r in {cut[0] for cut in cuts}}
    starts = []
    for r, a, _ in cuts:
        x, v, deviation = motion[r]
        # A head that rests starts at rest: noise of its speed would break it away.
        still = abs(v[a]) < 4.0 * deviation + 0.01 * float(np.abs(v).max(initial=0.0))
        starts.append((x[a], 0.0 if still else v[a]))
    columns = [(r, a, b, list(point.names)) for r, a, b in cuts]
    count = len(cuts)
    read = problem.job.run(
        columns,
        np.tile(point.values, (count, 1)),
        np.tile(point.shares, (count, 1)),
        np.array(starts),
        problem.threads,
    )[0]
    found, at = [], 0
    for r, a, b in cuts:
        x = problem.runs[r].channels["x"][a:b]
        found.append((problem.runs[r].t[a:b], x - read[at : at + b - a]))
        at += b - a
    return found


def free_errors(
    problem: Problem, point: Point, cuts: list[tuple[int, int, int]]
) -> list[NDArray[np.float64]]:
    """Return measured minus simulated positions in windows, each from its measured state."""
    return [e for _, e in _restarted(problem, point, cuts)]


def _cuts(problem: Problem, count: int) -> list[tuple[int, int, int]]:
    cuts: list[tuple[int, int, int]] = []
    for r in range(len(problem.runs)):
        edges = np.linspace(0, int(problem.lengths[r]), count + 1).astype(int)
        cuts.extend((r, int(a), int(b)) for a, b in pairwise(edges) if b - a >= 5)
    return cuts


def origin(problem: Problem, point: Point) -> list[dict[str, Any]]:
    """Return the windows in which the gap arises: the model restarted at each one's start."""
    squares = [np.zeros(int(n)) for n in problem.lengths]
    cuts = _cuts(problem, WINDOWS)
    for (r, a, b), (t, e) in zip(cuts, _restarted(problem, point, cuts), strict=True):
        ok = np.isfinite(e)
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
        both = []
        for point in (before, after):
            e = np.concatenate([e for _, e in _restarted(problem, point, cuts)])
            both.append(float(np.sqrt(np.nanmean(e**2))))
        rows.append({"seconds": horizon, "before": both[0], "after": both[1]})
    return rows


def regime_shares(
    squares: list[NDArray[np.float64]], regimes: list[NDArray[np.int64]]
) -> list[dict[str, Any]]:
    """Shares of squares by kind of motion, largest first."""
    parts = dict.fromkeys(REGIMES, 0.0)
    for values, kinds in zip(squares, regimes, strict=True):
        for k, name in enumerate(REGIMES):
            parts[name] += float(values[kinds == k].sum())
    found = sorted(shares(parts).items(), key=lambda item: -item[1])
    return [{"regime": name, "share": share} for name, share in found if share > 0.0]


def _swept(x: NDArray[np.float64], v: NDArray[np.float64], deviation: float) -> NDArray[np.float64]:
    """Return the distance swept forward since the head last rested or turned."""
    forward = v > 3.0 * deviation + 0.01 * float(np.abs(v).max(initial=0.0))
    starts = np.where(forward, np.nan, x)
    last = np.maximum.accumulate(np.where(forward, 0, np.arange(x.size)))
    base = np.where(np.isnan(starts[last]), x[0], starts[last])
    swept: NDArray[np.float64] = np.where(forward, x - base, 0.0)
    return swept


def force_view(problem: Problem, point: Point, mass: float) -> dict[str, Any]:
    """Return the force that the model lacks, over each variable it may depend on.

    Each window gives the constant force that its residual bends by; bins of equal
    count give centres, means and half widths of their 95 % intervals.
    """
    count = int(np.clip(problem.count / (len(problem.runs) * 25), 10, 60))
    cuts = _cuts(problem, count)
    swept = {r: _swept(*measured_motion(problem, r)) for r in range(len(problem.runs))}
    rows = []
    for (r, a, b), (t, e) in zip(cuts, _restarted(problem, point, cuts), strict=True):
        x, v, deviation = measured_motion(problem, r)
        ok = np.isfinite(e)
        if ok.sum() < 8 or np.abs(v[a:b]).min() < 3.0 * deviation:
            continue
        base = np.vander(t[ok] - t[0], 3)
        bend = np.linalg.lstsq(base, e[ok], rcond=None)[0][0]
        run = problem.runs[r]
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
        halves = np.array([1.96 * table[b, 0].std(ddof=1) / np.sqrt(b.size) for b in bins])
        view[name] = (centres, means, halves)
    return view
