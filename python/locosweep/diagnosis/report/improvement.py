"""Validation error reduction (`shrink` in the report) with its interval."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.report.localization import horizons
from locosweep.files.channels import CHANNELS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Point, Problem

HORIZONS = (0.1, 0.5, 2.0)
RESAMPLES = 400
_STEPS = 4
"""Steps of a fit of a start speed."""
_FEW = 4
_BLOCKS = 8
"""Blocks of a run that are drawn where there are too few runs to draw whole ones."""
_LEAST_FALL = 0.02
"""Fall of the logarithm of a run's squared error that counts as none."""
_MOST = 300.0
"""Logarithms beyond which squares leave what a double holds."""


def units_of(problem: Problem) -> dict[str, str]:
    """Units of the channels of a rig."""
    rotary = "gravity_torque" in problem.nominal
    return {name: channel.unit_on(rotary=rotary) for name, channel in CHANNELS.items()}


def started(problem: Problem, point: Point) -> Point:
    """Return a model with start speeds fitted in the runs kept from its own fit."""
    speeds = point.speeds.copy()
    for r in (r for r in problem.held if r in problem.starts.moving):
        step = 1e-4 * problem.speed_scale
        for _ in range(_STEPS):
            tried = [speeds, speeds.copy()]
            tried[1][r] += step
            points = [replace(point, speeds=s) for s in tried]
            e, moved = problem.residuals(points, [r])
            slope = (moved - e) / step
            size = float(slope @ slope)
            if size == 0.0 or not np.isfinite(size):
                break
            better = speeds.copy()
            better[r] -= float(slope @ e) / size
            new = problem.residuals([replace(point, speeds=better)], [r])[0]
            if not new @ new < e @ e:
                break
            speeds = better
    return replace(point, speeds=speeds)


def _errors(
    problem: Problem, point: Point, channel: str, offsets: list[float] | None = None
) -> tuple[list[NDArray[np.float64]], list[float]]:
    """Squared errors run by run, and the start offsets taken out of them.

    Without `offsets`, those that the model asks for as far as their noise goes.
    """
    found = problem.replay([point], range(len(problem.runs)))[channel][0]
    e = problem.measured[channel] - found
    if CHANNELS[channel].from_rest:
        e = e - np.repeat(problem.rest_levels[channel], problem.lengths)
    parts = np.split(e, problem.starts_at[1:-1])
    if offsets is None:
        offsets = [0.0] * len(parts)
        if channel in problem.priors and not (channel == "x" and problem.position_matters):
            noise = problem.noise[channel].sd
            for r, part in enumerate(parts):
                worth = np.isfinite(part).sum() / noise**2
                prior = problem.priors[channel][r]
                offsets[r] = float(np.nansum(part) / noise**2 / (worth + prior**-2.0))
    return [(part - offset) ** 2 for part, offset in zip(parts, offsets, strict=True)], offsets


def _rms(squares: list[NDArray[np.float64]]) -> float:
    values = np.concatenate(squares) if squares else np.zeros(0)
    values = values[np.isfinite(values)]
    return float(np.sqrt(values.mean())) if values.size else float("nan")


def _fall(old: list[NDArray[np.float64]], new: list[NDArray[np.float64]]) -> float:
    """Root mean square that an explanation takes away."""
    return float(np.sqrt(max(_rms(old) ** 2 - _rms(new) ** 2, 0.0)))


def gap_of(
    problem: Problem,
    before: Point,
    after: Point,
    seed: int,
    warnings: list[str],
    *,
    channel: str | None = None,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the report's `gap`, and its tables by channel and by run.

    Both models start where the second one says that the head did: a start fitted to the
    first would hide part of the gap.
    """
    units = units_of(problem)
    one = problem.train_fraction < 1.0
    held = list(problem.held) or list(range(len(problem.runs)))
    same = before.names == after.names
    if not same:
        before = replace(before, speeds=after.speeds, start_offsets=after.start_offsets)
    errors = {}
    for c in problem.channels:
        new, offsets = _errors(problem, after, c)
        errors[c] = _errors(problem, before, c, None if same else offsets)[0], new

    def judged(squares: list[NDArray[np.float64]]) -> list[NDArray[np.float64]]:
        if one:
            seen = np.split(problem.seen, problem.starts_at[1:-1])
            return [s[~k] for s, k in zip(squares, seen, strict=True)]
        return [squares[r] for r in held]

    # All runs say which channel shows the gap: those kept may hold little of it.
    ratios = {c: _rms(e[0]) / problem.noise[c].sd for c, e in errors.items()}
    if not same:
        ratios = {c: _fall(*e) / problem.noise[c].sd for c, e in errors.items()}
    known = {c: ratio for c, ratio in ratios.items() if np.isfinite(ratio)}
    channel = channel or (max(known, key=lambda c: known[c]) if known else "x")
    old, new = errors[channel]
    gap_before, gap_after = _rms(judged(old)), _rms(judged(new))
    floor = problem.noise[channel].sd
    shrink = explained = None
    interval: list[float] | None = None
    unseen = one or bool(problem.held)
    if unseen and gap_before > 0.0 and np.isfinite(gap_before) and gap_before > 1.05 * floor:
        shrink = 0.0 if same else 1.0 - gap_after / gap_before
        if gap_before**2 > 1.2 * floor**2:
            part = (gap_after**2 - floor**2) / (gap_before**2 - floor**2)
            explained = 0.0 if same else 1.0 - part
        interval = [0.0, 0.0] if same else _interval(problem, (old, new), shrink, seed)
    elif unseen and not same:
        warnings.append(
            "the runs kept from the fit show no gap beyond the noise: "
            "how far it shrinks there is not known"
        )
    rows = []
    for c, (a, b) in errors.items():
        total = float(np.nansum(np.concatenate(a))) / problem.noise[c].sd ** 2
        rows.append((total, {"channel": c, "before": _rms(a), "after": _rms(b), "unit": units[c]}))
    whole = sum(total for total, _ in rows)
    channels = [{**row, "share": total / whole if whole else 0.0} for total, row in rows]
    labels = [run.label for run in problem.runs]
    gap = {
        "channel": channel,
        "unit": units[channel],
        "metric": "rmse, free-running simulation, "
        + ("last part of the run" if one else "held-out runs" if unseen else "fitted runs"),
        "before": gap_before,
        "after": gap_after,
        "noise_floor": floor,
        "shrink": shrink,
        "shrink_ci": interval,
        "explained": explained,
        "horizons": horizons(problem, before, after, held, HORIZONS) if channel == "x" else [],
        "held_out": [labels[r] for r in problem.held],
        "used_for_fit": [labels[r] for r in problem.fitted],
    }
    runs = [
        {"run": label, "before": _rms([a]), "after": _rms([b])}
        for label, a, b in zip(labels, old, new, strict=True)
    ]
    return gap, {"channels": channels, "runs": runs}


def _interval(
    problem: Problem,
    errors: tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]],
    shrink: float,
    seed: int,
) -> list[float]:
    """90 % interval of the shrink on as many runs as were kept, drawn from all of them.

    It spans what the runs as they are give and what runs like them do: the next run lies
    beyond a few more often than in one of ten cases.
    """
    generator = np.random.default_rng(seed)
    few = len(problem.runs) < _FEW
    blocks: list[tuple[float, float]] = []
    for a, b in zip(*errors, strict=True):
        cuts = np.array_split(np.arange(a.size), _BLOCKS if few else 1)
        blocks += [(float(np.nansum(a[c])), float(np.nansum(b[c]))) for c in cuts]
    table = np.array(blocks)
    kept = max(1, len(problem.held))
    picks = generator.integers(0, len(table), size=(RESAMPLES, kept * (_BLOCKS if few else 1)))
    drawn = [table[picks].sum(axis=1)]
    runs = table.reshape(len(errors[0]), -1, 2).sum(axis=1)
    runs = runs[(runs > 0.0).all(axis=1)]
    if len(runs) > 2:
        drawn.append(_like(runs, kept, generator))
    ends = [
        np.quantile(1.0 - np.sqrt(sums[:, 1] / np.maximum(sums[:, 0], 1e-300)), [0.05, 0.95])
        for sums in drawn
    ]
    low, high = np.min(ends, axis=0)[0], np.max(ends, axis=0)[1]
    return [float(min(low, shrink)), float(max(high, shrink))]


def _like(
    runs: NDArray[np.float64], count: int, generator: np.random.Generator
) -> NDArray[np.float64]:
    """Draw sums of squared errors, before and after, of `count` runs like these.

    Shape (draws, 2). The logarithms of the error after and of how far it falls are taken
    for normal with unknown mean and spread: what comes next is distributed like Student's t.
    """
    n = len(runs)
    fall = np.log(runs[:, 0] / runs[:, 1])
    points = np.stack([np.log(runs[:, 1]), np.log(np.maximum(fall, _LEAST_FALL))], axis=1)
    wider = np.sqrt((n - 1.0) / generator.chisquare(n - 1.0, RESAMPLES))[:, None, None]
    middle, each = (
        generator.multivariate_normal([0.0, 0.0], np.cov(points, rowvar=False) / m, size)
        for m, size in ((n, (RESAMPLES, 1)), (1, (RESAMPLES, count)))
    )
    drawn = points.mean(axis=0) + wider * (middle + each)
    after = np.exp(np.clip(drawn[..., 0], -_MOST, _MOST))
    before = after * np.exp(np.exp(np.minimum(drawn[..., 1], np.log(_MOST))))
    return np.stack([before.sum(axis=1), after.sum(axis=1)], axis=1)
