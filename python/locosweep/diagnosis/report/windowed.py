"""Two models compared on runs that are replayed in windows from end to end."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.window_plan import adjoining_windows
from locosweep.diagnosis.report.comparison import Comparison
from locosweep.diagnosis.report.improvement import draws_of_windows

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Point, Problem
    from locosweep.diagnosis.estimate.shooting import WindowProblem
    from locosweep.diagnosis.estimate.window_plan import WindowPlan
    from locosweep.diagnosis.report.comparison import ByRun

    Floats = NDArray[np.float64]

_JUDGED = 60_000
"""Samples kept from the fit on which every candidate's error reduction is judged."""


@dataclass(frozen=True, eq=False)
class ReportWindows:
    """Windows that cover all runs, and those of them that validate."""

    whole: Problem
    """The runs as they were measured."""
    problem: WindowProblem
    seconds: float
    validation: list[int]

    def compare(self, before: Point, after: Point) -> Comparison:
        """Compare two models on these windows."""
        noise = self.problem.noise
        return _WindowComparison(self.whole, before, after, noise, self.seconds, windows=self)

    def by_run(self, values: Floats) -> list[Floats]:
        """Lay windows' values over the samples of the runs; the parts that count win."""
        found = [np.full(int(n), np.nan) for n in self.whole.lengths]
        parts = np.split(values, self.problem.starts_at[1:-1])
        windows = list(zip(self.problem.windows, parts, strict=True))
        for window, own in windows:
            covered = found[window.record][slice(*window.span)]
            covered[:] = np.where(np.isnan(covered), own, covered)
        for window, own in windows:
            counted = slice(*window.counted)
            found[window.record][slice(*window.span)][counted] = own[counted]
        return found

    def sums(self, before: Point, after: Point) -> dict[str, Floats]:
        """Sum and number of squares in each window that validates, shape (2, windows, 2)."""
        errors = self.problem.errors([before, after], self.validation)
        return {c: _sums(e**2, self.problem.lengths[self.validation]) for c, e in errors.items()}


def report_windows(whole: Problem, plan: WindowPlan) -> ReportWindows:
    """Cut runs into windows from end to end, and choose those that validate."""
    problem = adjoining_windows(whole, plan)
    record = np.array([window.record for window in problem.windows], dtype=int)
    ends = np.array([window.span[1] for window in problem.windows])
    if whole.train_fraction < 1.0:
        kept = ends > whole.train_fraction * whole.lengths[record]
    else:
        # Where no run was kept, all are judged.
        kept = np.isin(record, whole.held or np.unique(record))
    chosen = np.flatnonzero(kept)
    most = max(1, int(_JUDGED / max(float(np.mean(problem.lengths)), 1.0)))
    if chosen.size > most:
        chosen = chosen[((np.arange(most) + 0.5) * chosen.size / most).astype(int)]
    return ReportWindows(whole, problem, plan.seconds, chosen.tolist())


@dataclass(frozen=True, eq=False)
class _WindowComparison(Comparison):
    windows: ReportWindows = field(kw_only=True)

    @cached_property
    def readings(self) -> tuple[ByRun, ByRun]:
        return self._laid(self.windows.problem.replay([self.before, self.after]))

    @cached_property
    def squares(self) -> tuple[ByRun, ByRun]:
        problem = self.windows.problem
        errors = problem.errors([self.before, self.after], range(len(problem.runs)))
        return self._laid({c: e**2 for c, e in errors.items()})

    def _laid(self, rows: Mapping[str, Floats]) -> tuple[ByRun, ByRun]:
        before, after = (
            {c: self.windows.by_run(values[i]) for c, values in rows.items()} for i in range(2)
        )
        return before, after

    @cached_property
    def _sums(self) -> dict[str, Floats]:
        return self.windows.sums(self.before, self.after)

    @cached_property
    def validation_rms(self) -> dict[str, tuple[float, float]]:
        found = {}
        for c, sums in self._sums.items():
            count = float(sums[0, :, 1].sum())
            if count > 0.0:
                before, after = np.sqrt(sums[:, :, 0].sum(axis=1) / count)
                found[c] = float(before), float(after)
        return found

    @property
    def prominence(self) -> dict[str, float]:
        return {c: before / self.noise[c].sd for c, (before, _) in self.validation_rms.items()}

    def draws(self, channel: str, generator: np.random.Generator) -> list[Floats]:
        return draws_of_windows(self._sums[channel][:, :, 0], generator)


def _sums(squares: Floats, lengths: NDArray[np.intp]) -> Floats:
    """Sum and number of what is known in each window; shape (points, windows, 2)."""
    edges = np.concatenate([[0], np.cumsum(lengths)])[:-1]
    ok = np.isfinite(squares)
    top = np.add.reduceat(np.where(ok, squares, 0.0), edges, axis=1)
    return np.stack([top, np.add.reduceat(ok.astype(float), edges, axis=1)], axis=2)
