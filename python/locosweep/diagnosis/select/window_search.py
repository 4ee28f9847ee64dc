"""Fits to short windows of runs, from which fits to whole runs may start.

Along a whole run a stick-slip moves by a sample at a time, and errors add up. Windows that
begin at the measured state keep errors in proportion to their cause, and are few samples.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from locosweep.diagnosis.effects.catalogue import starts_of
from locosweep.diagnosis.estimate.least_squares import Fit, Nuisances, chi2_of, fit_all, start_fits
from locosweep.diagnosis.estimate.shooting import WindowProblem
from locosweep.diagnosis.estimate.window_plan import WindowPlan, problem_of
from locosweep.diagnosis.select.extension import extend_each, refit_from, singles
from locosweep.diagnosis.select.search import Collection, Found, Search, ranked
from locosweep.errors import DataFileError

if TYPE_CHECKING:
    from collections.abc import Sequence

_LENGTHS = (1.0 / 12.0, 1.0 / 25.0)
"""Lengths of windows, in those of a run."""
_FOLLOWED = 4
"""Sets of each length that are followed along whole runs."""
_THOROUGH = 3
"""Effects that are fitted from up to `_ROWS` starts, in up to `_STEPS`."""
_ROWS = 24
_STEPS = 20


@dataclass(frozen=True)
class WindowSearch:
    """A search over windows of one length, and what it has found."""

    search: Search
    known: Collection

    @property
    def singles(self) -> list[Fit]:
        """Fits of single effects; best first."""
        return ranked({key: fit for key, fit in self.known.fits.items() if len(key) == 1})


def search_windows(whole: Search) -> list[WindowSearch]:
    """Fit the single effects in windows of the runs that a search replays whole."""
    problem, scale = whole.problem, whole.scale
    if isinstance(problem, WindowProblem):
        return []
    found = []
    for share in _LENGTHS:
        plan = WindowPlan(share * scale.duration, "", dict(problem.noise))
        try:
            windows, _ = problem_of(problem, plan)
        except DataFileError:
            # Too little is measured for windows this short.
            continue
        if len(windows.fitted) > 1:
            nuisances = Nuisances((), whole.nuisances.spread, scale.speed)
            search = Search(windows, nuisances, scale, whole.names, judges=False, jumps=False)
            found.append(_with_singles(search))
    return found


def _with_singles(search: Search) -> WindowSearch:
    own = WindowSearch(search, singles(search))
    if search.leaves_much(own.singles[0]):
        better = _from_everywhere(search, own.singles[:_THOROUGH])
        return WindowSearch(search, own.known.adding(better))
    return own


def singles_in_windows(whole: Search, known: Collection, windows: Sequence[WindowSearch]) -> Found:
    """Follow along whole runs the single effects that are best in windows."""
    return _followed(whole, known, [one.singles for one in windows])


def best_in_windows(
    whole: Search, known: Collection, windows: Sequence[WindowSearch], seeds: Sequence[Fit]
) -> Found:
    """Add an effect to each of the seeds in windows, and follow the best sets along whole runs."""
    levels = []
    for one in windows:
        held = [one.known.fits.get(frozenset(seed.model.names)) for seed in seeds]
        bases = [fit for fit in held if fit is not None]
        levels.append(ranked(extend_each(one.search, one.known, bases)))
    return _followed(whole, known, levels)


def _followed(whole: Search, known: Collection, levels: Sequence[Sequence[Fit]]) -> Found:
    best = [fit for level in levels for fit in level[:_FOLLOWED]]
    return refit_from(whole, known, best) if best else {}


def _from_everywhere(search: Search, fits: Sequence[Fit]) -> Found:
    """Fit effects alone from all their starts, not only those that look best there."""
    starts: list[Fit] = []
    for fit in fits:
        rows = starts_of(fit.model.names[0], search.scale)
        starts += start_fits(search.nuisances, fit.model, rows[:: -(-len(rows) // _ROWS)])
    ends = fit_all(search.problem, starts, steps=_STEPS)
    found: Found = {}
    for fit in fits:
        best = min((end for end in ends if end.model is fit.model), key=chi2_of)
        if best.chi2 < fit.chi2:
            found[frozenset(fit.model.names)] = best
    return found
