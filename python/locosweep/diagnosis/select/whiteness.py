"""Lack of fit: whether residuals still hold together over more samples than noise does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Problem

__all__ = ["Lack", "blocks_of", "lack_of", "noise_level", "stray_readings", "white"]

BLOCKS = (4, 16, 64, 256)
"""Samples whose mean is looked at."""
LIMIT = 5.0
"""Deviations beyond which means of blocks are not noise.

Five scales, three channels and the tails of chi2 make 5 one in some 3000 runs
of white noise; what is left of an alien cause of size 10 stands at 5 or more.
"""

_STRAY = 8.0
"""Deviations beyond which a single reading is no noise, however long the runs."""
_FEW = 0.02
"""Share of a run's readings up to which they are single ones."""


@dataclass(frozen=True)
class Lack:
    """Worst excess of block means over noise.

    `deviations` says how sure it is, `excess` how large the rest is: its root mean
    square in units of the noise.
    """

    channel: str
    block: int
    deviations: float
    excess: float

    @property
    def is_there(self) -> bool:
        """Whether it is more than noise."""
        return self.deviations > LIMIT


def blocks_of(
    problem: Problem, residual: NDArray[np.float64], runs: Sequence[int] | None = None
) -> Iterator[tuple[str, int, NDArray[np.float64]]]:
    """Yield channel, run and its whitened residuals, samples without weight left out."""
    chosen = problem.fitted if runs is None else list(runs)
    at = 0
    for c in problem.channels:
        for r in chosen:
            n = int(problem.lengths[r])
            a = int(problem.starts_at[r])
            counts = problem.weights[c][a : a + n] > 0.0
            part = residual[at : at + n]
            counts = counts & problem.seen[a : a + n] if runs is None else counts
            yield c, r, part[counts]
            at += n


def white(values: NDArray[np.float64]) -> float:
    """Variance of what differs from sample to sample.

    Of squares, not of ranks: what a coarse quantiser leaves has few values.
    """
    if values.size < 16:
        return 1.0
    third = np.diff(values, 3)
    return float(third @ third) / third.size / 20.0


def noise_level(problem: Problem, residual: NDArray[np.float64]) -> float:
    """Variance of the white part of residuals: 1 where noise is what it is said to be."""
    parts = [values for _, _, values in blocks_of(problem, residual) if values.size >= 32]
    if not parts:
        return 1.0
    counts = np.array([values.size for values in parts])
    levels = np.array([white(values) for values in parts])
    return max(float(np.average(levels, weights=counts)), 0.5)


def lack_of(
    problem: Problem, residual: NDArray[np.float64], runs: Sequence[int] | None = None
) -> Lack:
    """Look at residuals of a fit for what noise would not leave."""
    parts: dict[str, list[NDArray[np.float64]]] = {}
    for c, _, values in blocks_of(problem, residual, runs):
        parts.setdefault(c, []).append(values)
    worst = Lack("x", 1, -np.inf, 0.0)
    for c, runs_of in parts.items():
        total = np.concatenate(runs_of) if runs_of else np.zeros(0)
        if total.size < 32:
            continue
        base = max(white(total), 0.5)
        mean = float(total @ total) / total.size
        excess = float(np.sqrt(max(mean - base, 0.0)))
        for n in BLOCKS:
            sums = [_sums(values, n) for values in runs_of if values.size >= n]
            if not sums:
                continue
            squares = np.concatenate(sums) ** 2 / base
            count = squares.size
            if count < 4:
                continue
            # Wilson and Hilferty make chi2 normal far into its tail.
            z = ((squares.sum() / count) ** (1 / 3) - (1 - 2 / (9 * count))) / np.sqrt(
                2 / (9 * count)
            )
            if z > worst.deviations:
                worst = Lack(c, n, float(z), excess)
    return worst


def _sums(values: NDArray[np.float64], n: int) -> NDArray[np.float64]:
    used = values[: values.size // n * n].reshape(-1, n)
    sums: NDArray[np.float64] = used.sum(axis=1) / np.sqrt(n)
    return sums


def stray_readings(problem: Problem, residual: NDArray[np.float64]) -> list[str]:
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
            # Of a normal deviation, half lie within 0.6745; a coarse reading may repeat itself.
            level = max(float(np.median(values[used])) / 0.6745, 1.0)
            off = np.flatnonzero(used & (values > _STRAY * level))
            if 0 < off.size <= _FEW * used.sum():
                run, last = problem.runs[r], off[-1]
                place = f"a reading of {c} at {run.t[off[0]]:g} s lies"
                if off.size > 1:
                    span = f"between {run.t[off[0]]:g} and {run.t[last]:g} s"
                    place = f"{off.size} readings of {c} {span} lie"
                said.append(
                    f"run {run.label}: {place} more than {_STRAY:g} deviations off what fits the "
                    "rest: frozen, slipped or disturbed?"
                )
    return said
