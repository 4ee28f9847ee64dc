"""Residual whiteness test: means of blocks of residuals against those of white noise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.select.thresholds import STRAY_DEVIATIONS, STRAY_SHARE, WHITENESS_LIMIT

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

BLOCKS = (4, 16, 64, 256)
"""Samples of a block, whose mean is tested: from what a break-away takes to what a drift does."""
_FEWEST, _FEWEST_BLOCKS = 32, 4
"""Samples, and blocks of a length, that a test needs at least."""
LEAST_NOISE = 0.5
"""Least variance of noise, in the stated one: a smaller rest is taken for noise that was stated too
large, so that nothing in it counts as a gap."""


@dataclass(frozen=True)
class WhitenessTest:
    """Largest excess of block means over noise, among channels and block lengths."""

    channel: str
    block: int
    """Samples of a block."""
    deviations: float
    """Normal deviate of the sum of squared means."""
    excess: float
    """Root mean square of the residual beyond noise, in units of the noise."""

    @property
    def rejected(self) -> bool:
        """True if the residuals are more than white noise."""
        return self.deviations > WHITENESS_LIMIT


def counted(problem: Problem, channel: str, run: int, *, all_of: bool = False) -> NDArray[np.bool_]:
    """Return which samples of a run have a reading of a channel that counts.

    Those that fits see, or `all_of` them.
    """
    own = slice(int(problem.starts_at[run]), int(problem.starts_at[run] + problem.lengths[run]))
    counts: NDArray[np.bool_] = problem.weights[channel][own] > 0.0
    return counts if all_of else counts & problem.seen[own]


def residuals_by_run(
    problem: Problem, residual: Floats, runs: Sequence[int] | None = None
) -> Iterator[tuple[str, int, Floats]]:
    """Yield channel, run and its whitened residuals, samples without weight left out."""
    chosen = problem.fitted if runs is None else list(runs)
    at = 0
    for c in problem.channels:
        for r in chosen:
            n = int(problem.lengths[r])
            yield c, r, residual[at : at + n][counted(problem, c, r, all_of=runs is not None)]
            at += n


def white_variance(values: Floats) -> float:
    """Return the variance of the white part of values, from squares of third differences."""
    if values.size < 16:
        return 1.0
    third = np.diff(values, 3)
    return float(third @ third) / third.size / 20.0


def noise_level(problem: Problem, residual: Floats) -> float:
    """Return the variance of the white part of residuals, 1 where the stated noise is right."""
    parts = [
        values for _, _, values in residuals_by_run(problem, residual) if values.size >= _FEWEST
    ]
    if not parts:
        return 1.0
    counts = np.array([values.size for values in parts])
    levels = np.array([white_variance(values) for values in parts])
    return max(float(np.average(levels, weights=counts)), LEAST_NOISE)


def whiteness_test(
    problem: Problem, residual: Floats, runs: Sequence[int] | None = None
) -> WhitenessTest:
    """Test whitened residuals of a fit for what white noise would not leave.

    They belong to `runs`, or to those that are fitted, in the form of `Problem.residuals`.
    """
    parts: dict[str, list[Floats]] = {}
    for c, _, values in residuals_by_run(problem, residual, runs):
        parts.setdefault(c, []).append(values)
    worst = WhitenessTest("x", 1, -np.inf, 0.0)
    for c, runs_of in parts.items():
        total = np.concatenate(runs_of) if runs_of else np.zeros(0)
        if total.size < _FEWEST:
            continue
        base = max(white_variance(total), LEAST_NOISE)
        mean = float(total @ total) / total.size
        excess = float(np.sqrt(max(mean - base, 0.0)))
        for n in BLOCKS:
            sums = [_sums(values, n) for values in runs_of if values.size >= n]
            if not sums:
                continue
            squares = np.concatenate(sums) ** 2 / base
            count = squares.size
            if count < _FEWEST_BLOCKS:
                continue
            # Wilson and Hilferty make chi2 normal far into its tail.
            z = ((squares.sum() / count) ** (1 / 3) - (1 - 2 / (9 * count))) / np.sqrt(
                2 / (9 * count)
            )
            if z > worst.deviations:
                worst = WhitenessTest(c, n, float(z), excess)
    return worst


def inflation(problem: Problem, residual: Floats) -> float:
    """Return by how much chi2 overstates what residuals say, that are correlated: 1 or more.

    It is the largest ratio of the variance of sums over blocks to that of white noise.
    """
    worst = 1.0
    parts: dict[str, list[Floats]] = {}
    for c, _, values in residuals_by_run(problem, residual):
        parts.setdefault(c, []).append(values)
    for runs_of in parts.values():
        total = np.concatenate(runs_of)
        if total.size < 32:
            continue
        level = max(float(total @ total) / total.size, 1e-300)
        for n in BLOCKS:
            sums = [_sums(values, n) for values in runs_of if values.size >= n]
            squares = np.concatenate(sums) ** 2 if sums else np.zeros(0)
            if squares.size >= 4:
                worst = max(worst, float(squares.mean()) / level)
    return worst


def _sums(values: Floats, n: int) -> Floats:
    used = values[: values.size // n * n].reshape(-1, n)
    sums: Floats = used.sum(axis=1) / np.sqrt(n)
    return sums


def stray_readings(problem: Problem, residual: Floats) -> list[str]:
    """Tell of single readings far off what fits the others: no mean over samples shows them."""
    said, at = [], 0
    for c in problem.channels:
        for r in problem.fitted:
            n, a = int(problem.lengths[r]), int(problem.starts_at[r])
            values = np.abs(residual[at : at + n])
            at += n
            used = (problem.weights[c][a : a + n] > 0.0) & problem.seen[a : a + n]
            if used.sum() < 32:
                continue
            # Half of normal deviations lie within 0.6745; a coarse reading may repeat itself.
            level = max(float(np.median(values[used])) / 0.6745, 1.0)
            off = np.flatnonzero(used & (values > STRAY_DEVIATIONS * level))
            if 0 < off.size <= STRAY_SHARE * used.sum():
                run, last = problem.runs[r], off[-1]
                text = f"a reading of {c} at {run.t[off[0]]:g} s lies"
                if off.size > 1:
                    span = f"between {run.t[off[0]]:g} and {run.t[last]:g} s"
                    text = f"{off.size} readings of {c} {span} lie"
                said.append(
                    f"run {run.label}: {text} more than {STRAY_DEVIATIONS:g} deviations "
                    "off what fits the rest: frozen, slipped or disturbed?"
                )
    return said
