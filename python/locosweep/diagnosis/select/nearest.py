"""The set of effects that comes nearest to a gap which none accounts for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import point_of
from locosweep.diagnosis.select.extension import extend
from locosweep.diagnosis.select.thresholds import NEAREST_FALL, NEAREST_SURE, NEAREST_TIED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.select.search import Collection, Search

    Floats = NDArray[np.float64]

_LISTED = 6
_COMPARED = 24


@dataclass(frozen=True)
class Nearest:
    """The set, and the others of as many effects that do as well; all best first."""

    fit: Fit
    fits: list[Fit]

    def weighed(self, others: Sequence[Fit], windows: int) -> list[tuple[Fit, float]]:
        """Weigh these and other fits; a window that is left with more counts for one sample."""
        fits = [*self.fits, *(f for f in others if all(f is not mine for mine in self.fits))]
        chi2 = np.array([fit.chi2 for fit in fits])
        scale = max(float(chi2.min()) / max(windows, 1), 1.0)
        weights = np.exp(-0.5 * (chi2 - chi2.min()) / scale)
        return list(zip(fits, (weights / weights.sum()).tolist(), strict=True))


def nearest(search: Search, known: Collection) -> Nearest | None:
    """Find the smallest set that no larger one betters; None where none helps at all.

    A model that lacks something has too large differences in chi2, and a push in one window
    outweighs all others. So root mean squares of windows are compared one by one.
    """
    groups: dict[int, list[Fit]] = {}
    for key, fit in _with_exchanges(search, known).fits.items():
        if np.isfinite(fit.chi2) and fit.residual.size:
            groups.setdefault(len(key), []).append(fit)
    best: Fit | None = None
    seen = len(search.problem.fitted)
    none = level = _windows(search, [search.none])[0]
    near: list[Fit] = []
    for size in sorted(set(groups) - {0}):
        fits = sorted(groups[size], key=lambda fit: fit.chi2)[:_COMPARED]
        rows = _windows(search, fits)
        order = sorted(range(len(fits)), key=lambda i: _size(rows[i], none, seen))
        first = order[0]
        if not _better(level, rows[first], seen):
            # Two causes may each do nothing alone.
            continue
        best, level = fits[first], rows[first]
        close = [i for i in order if _deviations(rows[i] - level) < NEAREST_TIED]
        near = [fits[i] for i in [first, *(i for i in close if i != first)]][:_LISTED]
    return Nearest(best, near) if best else None


def _with_exchanges(search: Search, known: Collection) -> Collection:
    """Fit the exchange of each part of the best pair: no other step does."""
    pairs = [fit for key, fit in known.fits.items() if len(key) == 2]
    for name in min(pairs, key=lambda fit: fit.chi2).model.names if pairs else ():
        if name in search.names:
            known = known.adding(extend(search, known, known.single(name), search.names))
    return known


def _windows(search: Search, fits: Sequence[Fit]) -> Floats:
    """Root of chi2 of every window, those of the fit first; a row a fit."""
    problem = search.problem
    points = [point_of(problem, fit) for fit in fits]
    parts = []
    for chosen in (problem.fitted, list(problem.held)):
        if not chosen:
            continue
        e = problem.residuals(points, chosen) ** 2
        lengths = problem.lengths[chosen]
        samples = int(lengths.sum())
        edges = np.concatenate([[0], np.cumsum(lengths)])[:-1]
        of_channels = e[:, : len(problem.channels) * samples]
        summed = of_channels.reshape(len(fits), -1, samples).sum(axis=1)
        parts.append(np.sqrt(np.add.reduceat(summed, edges, axis=1)))
    return np.concatenate(parts, axis=1)


def _size(row: Floats, none: Floats, seen: int) -> float:
    """Part that is left, windows of the fit and those of the check counting as much."""
    parts = [part for part in (slice(0, seen), slice(seen, row.size)) if row[part].size]
    return float(np.mean([row[part].sum() / none[part].sum() for part in parts]))


def _better(old: Floats, new: Floats, seen: int) -> bool:
    """Return whether more effects are surely better, and no worse in validation windows."""
    fall = old - new
    enough = fall[:seen].sum() > NEAREST_FALL * old[:seen].sum()
    return bool(_deviations(fall) > NEAREST_SURE and enough and fall[seen:].sum() >= 0.0)


def _deviations(differences: Floats) -> float:
    """Sum of differences over its standard deviation."""
    spread = float(np.sqrt(np.sum((differences - differences.mean()) ** 2)))
    return float(differences.sum()) / max(spread, 1e-12)
