"""Two models compared on the runs: readings, squared errors, and those of validation data."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.report.improvement import draws_of_runs
from locosweep.diagnosis.report.localization import rms, smooth_square
from locosweep.files.channels import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.noise import Noise
    from locosweep.diagnosis.estimate.problem import Point, Problem

    Floats = NDArray[np.float64]
    ByRun = dict[str, list[Floats]]
    """Channel to one array a run."""

_STEPS = 4
"""Steps of a fit of a start speed."""


@dataclass(frozen=True, eq=False)
class Comparison(ABC):
    """The nominal and another model on the same runs, replayed whole or in windows.

    What is given by run has all its samples, NaN where nothing was measured or counts.
    """

    problem: Problem
    """The runs as they were measured."""
    before: Point
    after: Point
    noise: Mapping[str, Noise]
    seconds: float | None = None
    """Length of the windows, s; None where runs are replayed from end to end."""

    @property
    def same(self) -> bool:
        """True if both models have the same effects."""
        return self.before.names == self.after.names

    @property
    def validates(self) -> bool:
        """True if a part of the runs was kept from the fit."""
        return self.problem.train_fraction < 1.0 or bool(self.problem.held)

    def unit(self, channel: str) -> str:
        """Return the unit of a channel on this rig."""
        return CHANNELS[channel].unit_on(rotary="gravity_torque" in self.problem.nominal)

    @property
    @abstractmethod
    def readings(self) -> tuple[ByRun, ByRun]:
        """Sensor readings that either model predicts."""

    @property
    @abstractmethod
    def squares(self) -> tuple[ByRun, ByRun]:
        """Squared errors of either model."""

    @property
    @abstractmethod
    def validation_rms(self) -> dict[str, tuple[float, float]]:
        """Error of either model in the data kept from the fit, by channel that these have."""

    @property
    @abstractmethod
    def prominence(self) -> dict[str, float]:
        """Size of the gap in each channel where it is known, in units of its noise."""

    @abstractmethod
    def draws(self, channel: str, generator: np.random.Generator) -> list[Floats]:
        """Draw sums of squared errors, before and after, of data like those kept from the fit."""

    def gap_squares(self, channel: str, *, explained: bool) -> list[Floats]:
        """Return the square of the gap at every sample, 0 where nothing was measured.

        `explained` says whether the second model accounts for the gap.
        """
        del explained
        return [np.nan_to_num(s) for s in self.squares[0][channel]]


def compare_whole_runs(problem: Problem, before: Point, after: Point) -> Comparison:
    """Compare two models on runs that are replayed from end to end.

    Both start as the second one does: a start fitted to the first would hide part of the gap.
    """
    after = started(problem, after)
    if before.names == after.names:
        before = started(problem, before)
    else:
        before = replace(before, speeds=after.speeds, start_offsets=after.start_offsets)
    return _RunComparison(problem, before, after, problem.noise)


class _RunComparison(Comparison):
    @cached_property
    def readings(self) -> tuple[ByRun, ByRun]:
        read = self.problem.replay([self.before, self.after])
        before, after = ({c: self._by_run(rows[i]) for c, rows in read.items()} for i in range(2))
        return before, after

    def _by_run(self, values: Floats) -> list[Floats]:
        return np.split(values, self.problem.starts_at[1:-1])

    def _errors(self, model: int, channel: str) -> list[Floats]:
        """Measured minus simulated, run by run."""
        measured = self._by_run(self.problem.measured[channel])
        levels = np.zeros(len(measured))
        if CHANNELS[channel].from_rest:
            levels = self.problem.start_levels[channel]
        read = self.readings[model][channel]
        return [y - found - level for y, found, level in zip(measured, read, levels, strict=True)]

    @cached_property
    def squares(self) -> tuple[ByRun, ByRun]:
        errors = [{c: self._errors(k, c) for c in self.problem.channels} for k in range(2)]
        of_model = self._gap_shifts if self.problem.gap_shifts.kinds else self._start_offsets
        after = of_model(errors[1])
        before = of_model(errors[0]) if self.same else after
        return _squared(errors[0], before), _squared(errors[1], after)

    def _start_offsets(self, errors: ByRun) -> ByRun:
        """Return the start offset of each run at its samples."""
        return {
            c: [np.full(e.size, s) for e, s in zip(own, self._offsets(c, own), strict=True)]
            for c, own in errors.items()
        }

    def _gap_shifts(self, errors: ByRun) -> ByRun:
        """Return the same, and what rows that miss may have changed."""
        weights = self.problem.weights
        whole = {c: np.concatenate(own) * weights[c] for c, own in errors.items()}
        found = self.problem.shifts_of({c: np.nan_to_num(e)[None, :] for c, e in whole.items()})
        with np.errstate(divide="ignore", invalid="ignore"):
            return {c: self._by_run(change[0] / weights[c]) for c, change in found.items()}

    def _offsets(self, channel: str, errors: Sequence[Floats]) -> list[float]:
        """Start offsets that the errors ask for, as far as the noise of the starts goes."""
        if not self.problem.has_offset(channel):
            return [0.0] * len(errors)
        variance = self.problem.noise[channel].sd ** 2
        return [
            float(np.nansum(e) / variance / (np.isfinite(e).sum() / variance + prior**-2.0))
            for e, prior in zip(errors, self.problem.priors[channel], strict=True)
        ]

    @cached_property
    def validation_rms(self) -> dict[str, tuple[float, float]]:
        found = {}
        for c in self.problem.channels:
            before, after = (rms(self._kept(squares[c])) for squares in self.squares)
            if before is not None and after is not None:
                found[c] = before, after
        return found

    def _kept(self, squares: list[Floats]) -> list[Floats]:
        if self.problem.train_fraction < 1.0:
            seen = np.split(self.problem.seen, self.problem.starts_at[1:-1])
            return [s[~k] for s, k in zip(squares, seen, strict=True)]
        return [squares[r] for r in self.problem.held or range(len(squares))]

    @cached_property
    def prominence(self) -> dict[str, float]:
        """Error that the second model takes away, over all runs: few may hold little of the gap."""
        found = {}
        for c in self.problem.channels:
            before, after = (rms(squares[c]) for squares in self.squares)
            if before is not None and after is not None:
                size = before if self.same else np.sqrt(max(before**2 - after**2, 0.0))
                found[c] = float(size) / self.noise[c].sd
        return found

    def draws(self, channel: str, generator: np.random.Generator) -> list[Floats]:
        before, after = self.squares
        kept = max(1, len(self.problem.held))
        return draws_of_runs(before[channel], after[channel], kept, generator)

    def gap_squares(self, channel: str, *, explained: bool) -> list[Floats]:
        """Return what an explanation adds to the model; else the smoothed residual, squared."""
        if not explained:
            return [smooth_square(e, self.noise[channel].sd) for e in self._errors(0, channel)]
        before, after = self.readings
        measured = self._by_run(self.problem.measured[channel])
        return [
            np.where(np.isfinite(y), b - a, 0.0) ** 2
            for y, a, b in zip(measured, before[channel], after[channel], strict=True)
        ]


def _squared(errors: ByRun, shifts: ByRun) -> ByRun:
    return {
        c: [(e - shift) ** 2 for e, shift in zip(parts, shifts[c], strict=True)]
        for c, parts in errors.items()
    }


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
