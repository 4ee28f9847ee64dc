"""Fits to short windows of runs: where those to whole runs may start.

Along a whole run a stick-slip moves by a sample at a time, and errors add up: the valley
that chi2 has there is narrow, bent and full of steps. Windows that begin at the measured
state keep errors in proportion to their cause (multiple shooting), and are few samples.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.diagnosis.effects.catalogue import starts_of
from locosweep.diagnosis.estimate.least_squares import Fit, Nuisances, chi2_of, fit_all, start_fits
from locosweep.diagnosis.estimate.shooting import ShotProblem
from locosweep.diagnosis.estimate.window_plan import Plan, problem_of
from locosweep.diagnosis.select.search import Search
from locosweep.errors import DataFileError

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["WindowSearches"]

_LENGTHS = (1.0 / 12.0, 1.0 / 25.0)
"""Lengths of windows, in those of a run."""
_FOLLOWED = 4
"""Sets of each length that are followed along whole runs."""
_THOROUGH = 3
"""Effects that are fitted from up to `_ROWS` starts, in up to `_STEPS`."""
_ROWS = 24
_STEPS = 20


class WindowSearches:
    """Searches over windows of the runs that another search replays whole."""

    def __init__(self, whole: Search) -> None:
        self.whole = whole
        self.searches: list[Search] = []
        problem, scale = whole.problem, whole.scale
        if isinstance(problem, ShotProblem):
            return
        for share in _LENGTHS:
            plan = Plan(share * scale.duration, "", dict(problem.noise))
            try:
                windows = problem_of(problem, plan, [])
            except DataFileError:
                # Too little is measured for windows this short.
                continue
            nuisances = Nuisances((), whole.nuisances.spread, scale.speed)
            if len(windows.fitted) > 1:
                self.searches.append(
                    Search(
                        windows, nuisances, scale, whole.names, lambda _: None,
                        judges=False, leaps=False,
                    )
                )  # fmt: skip

    def singles(self) -> list[Fit]:
        """Follow along whole runs the single effects that are best in windows."""
        levels = []
        for search in self.searches:
            level = search.singles()
            if search.leaves_much(level[0]):
                level = [*level, *_from_everywhere(search, level[:_THOROUGH])]
            levels.append(level)
        return self._followed(levels)

    def deepened(self, seeds: Sequence[Fit]) -> list[Fit]:
        """Add an effect to each of the seeds in windows, and follow the best sets; best first."""
        levels = []
        for search in self.searches:
            known = [search.fits.get(frozenset(seed.model.names)) for seed in seeds]
            held = [fit for fit in known if fit is not None]
            levels.append(search.deepen(held, len(held)))
        return self._followed(levels)

    def _followed(self, levels: Sequence[Sequence[Fit]]) -> list[Fit]:
        best: list[Fit] = []
        for level in levels:
            # Of each set the last one is the best.
            sets = {fit.model.names: fit for fit in sorted(level, key=chi2_of, reverse=True)}
            best += sorted(sets.values(), key=chi2_of)[:_FOLLOWED]
        return self.whole.follow(best) if best else []


def _from_everywhere(search: Search, fits: Sequence[Fit]) -> list[Fit]:
    """Fit effects alone from all their starts, not only those that look best there."""
    starts: list[Fit] = []
    for fit in fits:
        rows = starts_of(fit.model.names[0], search.scale)
        starts += start_fits(search.nuisances, fit.model, rows[:: -(-len(rows) // _ROWS)])
    fit_all(search.problem, starts, steps=_STEPS)
    found = []
    for fit in fits:
        best = min((s for s in starts if s.model is fit.model), key=chi2_of)
        if best.chi2 < fit.chi2:
            search.fits[frozenset(fit.model.names)] = best
            found.append(best)
    return found
