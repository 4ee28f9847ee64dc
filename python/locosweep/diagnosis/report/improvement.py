"""Validation error reduction (`shrink` in the report) with its interval."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.report.localization import horizons

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.report.comparison import Comparison

    Floats = NDArray[np.float64]

_HORIZONS = (0.1, 0.5, 2.0)
"""Lengths of free runs, s."""
_RESAMPLES = 400
_FEW = 4
"""Fewest runs of which whole ones are drawn."""
_FEWEST = 3
"""Fewest runs that say how much runs differ."""
_BLOCKS = 8
"""Blocks of a run that are drawn where there are too few runs to draw whole ones."""
_LEAST_FALL = 0.02
"""Fall of the logarithm of a run's squared error that counts as none."""
_MOST = 300.0
"""Logarithms beyond which squares leave what a double holds."""
_SHOWN, _EXPLAINED = 1.05, 1.2
"""Error over the noise floor, and its square, from which a reduction and an explained part of
the gap are stated."""


def gap_of(comparison: Comparison, seed: int) -> dict[str, Any]:
    """Return the report's `gap`, in the channel in which it is most prominent."""
    problem = comparison.problem
    prominence = comparison.prominence
    channel = max(prominence, key=lambda c: prominence[c], default="x")
    span = comparison.seconds
    horizon = f" over {span:.3g} s from the measured state" if span else ""
    data = "last part of the run"
    if problem.train_fraction == 1.0:
        data = "held-out runs" if problem.held else "fitted runs"
    labels = [run.label for run in problem.runs]
    judged = list(problem.held) or list(range(len(labels)))
    points = (comparison.before, comparison.after)
    return {
        "channel": channel,
        "unit": comparison.unit(channel),
        "metric": f"rmse, free-running simulation{horizon}, {data}",
        **reduction(comparison, channel, seed),
        "horizons": horizons(problem, *points, judged, _HORIZONS) if channel == "x" else [],
        "held_out": [labels[r] for r in problem.held],
        "used_for_fit": [labels[r] for r in problem.fitted],
    }


def reduction(comparison: Comparison, channel: str, seed: int) -> dict[str, Any]:
    """Return the validation error before and after, and its fall where validation data show it."""
    floor = float(comparison.noise[channel].sd)
    found: dict[str, Any] = {"before": None, "after": None, "noise_floor": floor}
    found |= {"shrink": None, "shrink_ci": None, "explained": None}
    if channel not in comparison.validation_rms:
        return found
    before, after = found["before"], found["after"] = comparison.validation_rms[channel]
    if comparison.validates and before > _SHOWN * floor:
        same = comparison.same
        found["shrink"] = shrink = 0.0 if same else 1.0 - after / before
        drawn = comparison.draws(channel, np.random.default_rng(seed))
        found["shrink_ci"] = [0.0, 0.0] if same else interval_of(drawn, shrink)
        if before**2 > _EXPLAINED * floor**2:
            part = (after**2 - floor**2) / (before**2 - floor**2)
            found["explained"] = 0.0 if same else 1.0 - part
    return found


def interval_of_difference(
    before: Comparison | None, after: Comparison, channel: str, seed: int
) -> list[float] | None:
    """90 % interval of how much further an error falls with a second model than with a first one.

    Both are drawn from the same runs. Without a first one, of the whole fall.
    """
    found = reduction(after, channel, seed)
    if before is None or found["shrink"] is None:
        return None if found["shrink_ci"] is None else list(found["shrink_ci"])
    pairs = zip(
        before.draws(channel, np.random.default_rng(seed)),
        after.draws(channel, np.random.default_rng(seed)),
        strict=True,
    )
    first = reduction(before, channel, seed)["shrink"] or 0.0
    return _over_all([_fall(new) - _fall(old) for old, new in pairs], found["shrink"] - first)


def share_interval(
    table: Floats, share: float, generator: np.random.Generator
) -> list[float] | None:
    """90 % interval of the share that a cause takes away of the error of new runs.

    `table` has mean squared errors, a row a run: of the nominal model, of the model before the
    cause if that is another one, and of that with the cause. As many runs are drawn again, and runs
    like them. None of fewer than three runs, which say nothing of others.
    """
    if len(table) < _FEWEST:
        return None
    picks = generator.integers(0, len(table), size=(_RESAMPLES, len(table)))
    runs = np.maximum(table, 1e-300)
    drawn = table[picks].sum(axis=1), _like(runs, len(table), generator)
    errors = [np.sqrt(squares) for squares in drawn]
    return _over_all([(e[:, -2] - e[:, -1]) / np.maximum(e[:, 0], 1e-300) for e in errors], share)


def _fall(sums: Floats) -> Floats:
    """Return the fall of the error in each draw of squares before and after."""
    falls: Floats = 1.0 - np.sqrt(sums[:, 1] / np.maximum(sums[:, 0], 1e-300))
    return falls


def interval_of(drawn: Sequence[Floats], shrink: float) -> list[float]:
    """90 % interval of the reduction over all draws of squared errors, each of shape (draws, 2)."""
    return _over_all([_fall(sums) for sums in drawn], shrink)


def _over_all(drawn: Sequence[Floats], middle: float) -> list[float]:
    """90 % interval that holds those of all draws, and `middle`."""
    ends = [np.quantile(values, [0.05, 0.95]) for values in drawn]
    low, high = np.min(ends, axis=0)[0], np.max(ends, axis=0)[1]
    return [float(min(low, middle)), float(max(high, middle))]


def draws_of_runs(
    before: Sequence[Floats], after: Sequence[Floats], kept: int, generator: np.random.Generator
) -> list[Floats]:
    """Draw `kept` runs as they are and runs like them: few known ones span too little."""
    blocks = _BLOCKS if len(before) < _FEW else 1
    table = np.array([
        (np.nansum(a[c]), np.nansum(b[c]))
        for a, b in zip(before, after, strict=True)
        for c in np.array_split(np.arange(a.size), blocks)
    ])  # fmt: skip
    picks = generator.integers(0, len(table), size=(_RESAMPLES, kept * blocks))
    drawn = [table[picks].sum(axis=1)]
    runs = table.reshape(len(before), -1, 2).sum(axis=1)
    runs = runs[(runs > 0.0).all(axis=1)]
    if len(runs) > 2:
        drawn.append(_like(runs, kept, generator))
    return drawn


def draws_of_windows(table: Floats, generator: np.random.Generator) -> list[Floats]:
    """Draw as many windows as there are; `table` has their squared errors, shape (2, windows)."""
    picks = generator.integers(0, table.shape[1], size=(_RESAMPLES, table.shape[1]))
    return [table[:, picks].sum(axis=2).T]


def _like(runs: Floats, count: int, generator: np.random.Generator) -> Floats:
    """Draw sums of squared errors, model by model, of `count` runs like these.

    Shape (draws, models), as that of `runs`. The logarithms of the error of the last model and of
    how far it falls from each to the next are taken for normal with unknown mean and spread: what
    comes next is distributed like Student's t.
    """
    n, models = runs.shape
    logs = np.log(runs)
    falls = np.maximum(logs[:, :-1] - logs[:, 1:], _LEAST_FALL)
    points = np.hstack([logs[:, -1:], np.log(falls)])
    spread = np.cov(points, rowvar=False)
    wider = np.sqrt((n - 1.0) / generator.chisquare(n - 1.0, _RESAMPLES))[:, None, None]
    middle, each = (
        generator.multivariate_normal(np.zeros(models), spread / m, size)
        for m, size in ((n, (_RESAMPLES, 1)), (1, (_RESAMPLES, count)))
    )
    drawn = points.mean(axis=0) + wider * (middle + each)
    last = np.exp(np.clip(drawn[..., :1], -_MOST, _MOST))
    fallen = np.exp(np.minimum(drawn[..., 1:], np.log(_MOST)))
    # From the last model back to the first.
    grown = np.cumsum(fallen[..., ::-1], axis=-1)[..., ::-1]
    before = last * np.exp(np.minimum(grown, _MOST))
    found: Floats = np.concatenate([before, last], axis=-1).sum(axis=1)
    return found
