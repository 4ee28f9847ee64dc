"""The set of effects that comes nearest to a gap which none accounts for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.fit import point_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.fit import Fit
    from locosweep.diagnosis.search import Search

    Floats = NDArray[np.float64]

__all__ = ["Nearest", "nearest"]

_SURE = 2.5
"""Deviations by which more effects have to be better, over the windows' own scatter."""
_TIED = 2.0
"""Deviations below which two sets of as many effects are as good."""
_WORTH = 0.1
"""Part of what a window leaves that a further effect has to take, in windows that fits saw and
in those that they did not: what a model lacks bends every effect a little."""
_LISTED = 6
_COMPARED = 24


@dataclass
class Nearest:
    """The set, and the others of as many effects that do as well; all best first."""

    fit: Fit
    fits: list[Fit]

    def told(self) -> dict[str, Any]:
        """Return what the report says of it."""
        return {
            "effects": list(self.fit.model.names),
            "as_near": [list(fit.model.names) for fit in self.fits[1:]],
        }


def nearest(search: Search) -> Nearest | None:
    """Find the smallest set that no larger one betters; None where none helps at all.

    Where a model lacks something, differences in chi2 count for less than noise would
    have it, and a push in one window outweighs all others. So windows are compared one
    by one, each by the factor in its chi2; their scatter says how sure a difference is.
    """
    groups: dict[int, list[Fit]] = {}
    for key, fit in search.fits.items():
        if np.isfinite(fit.chi2) and fit.residual.size:
            groups.setdefault(len(key), []).append(fit)
    best: Fit | None = None
    seen = len(search.problem.fitted)
    known = _windows(search, [search.none])[0]
    near: list[Fit] = []
    for size in sorted(set(groups) - {0}):
        fits = sorted(groups[size], key=lambda fit: fit.chi2)[:_COMPARED]
        rows = _windows(search, fits)
        order = sorted(range(len(fits)), key=lambda i: _mean(rows[i], seen))
        first = order[0]
        if not _better(known - rows[first], seen):
            break
        best, known = fits[first], rows[first]
        close = [i for i in order if _deviations(rows[i] - known) < _TIED]
        near = [fits[i] for i in [first, *(i for i in close if i != first)]][:_LISTED]
    return Nearest(best, near) if best else None


def _windows(search: Search, fits: Sequence[Fit]) -> Floats:
    """Logarithm of chi2 of every window, those of the fit first; a row a fit."""
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
        # Below what noise leaves no window is better than another.
        parts.append(np.log(np.add.reduceat(summed, edges, axis=1) + lengths))
    return np.concatenate(parts, axis=1)


def _mean(row: Floats, seen: int) -> float:
    """Mean over windows, those of the fit and those of the check counting as much."""
    parts = [part for part in (row[:seen], row[seen:]) if part.size]
    return float(np.mean([part.mean() for part in parts]))


def _better(fall: Floats, seen: int) -> bool:
    parts = [part for part in (fall[:seen], fall[seen:]) if part.size]
    return _deviations(fall) > _SURE and all(part.mean() > _WORTH for part in parts)


def _deviations(differences: Floats) -> float:
    """Sum of differences over its standard deviation."""
    spread = float(np.sqrt(np.sum((differences - differences.mean()) ** 2)))
    return float(differences.sum()) / max(spread, 1e-12)
