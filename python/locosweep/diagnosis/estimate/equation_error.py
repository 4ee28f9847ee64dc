"""Equation error: forces of models along the measured motion, in place of replays.

Over each slide in one direction the measured motion says what friction acted, so that the
forces of a model give its displacement without a replay, and without an error that feeds
back. Start and start speed of every slide are free. What acts at rest, as a bristle does, is
not seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.regimes import measured_motion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.regimes import MeasuredMotion
    from locosweep.diagnosis.estimate.problem import Point, Problem

    Floats = NDArray[np.float64]

_ROWS = 3000
"""Block means that are kept of all runs, about: a screen of all effects then takes some
hundredths of a second (`benches/diagnosis.py`)."""
_ACCURACY = 0.25
"""Deviation of smoothed speeds, in mean speeds: friction asks for no more, and slides end
sooner where more is smoothed over."""
_LEAST = 5
"""Block means of a slide, at least: two of them go to its start."""


@dataclass(frozen=True, eq=False)
class EquationError:
    """Displacements of models along the measured slides, in units of their noise."""

    problem: Problem

    @cached_property
    def block(self) -> int:
        """Samples of a block mean."""
        return max(1, int(self.problem.lengths[self.problem.fitted].sum()) // _ROWS)

    @cached_property
    def motions(self) -> list[MeasuredMotion]:
        """Smoothed motion of each run: less than elsewhere, as slides end with its width."""
        noise = self.problem.noise["x"]
        return [measured_motion(run, noise, _ACCURACY) for run in self.problem.runs]

    @cached_property
    def slides(self) -> list[list[tuple[int, int]]]:
        """Slides of each run in one direction: first sample and one beyond the last."""
        problem = self.problem
        found = []
        for r, motion in enumerate(self.motions):
            last = int(problem.lengths[r] * problem.train_fraction)
            known = r in problem.fitted
            found.append(slides_of(motion, last, _LEAST * self.block) if known else [])
        return found

    @cached_property
    def _edges(self) -> NDArray[np.intp]:
        """First block of each slide, of all runs in turn."""
        sizes = [-(-(b - a) // self.block) for run in self.slides for a, b in run]
        return np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.intp)

    @cached_property
    def _blocks(self) -> tuple[Floats, Floats, Floats]:
        """Mean reading, weight and mean time of every block."""
        problem, noise = self.problem, self.problem.noise["x"]
        means, weights, times = [], [], []
        for r, run in enumerate(problem.runs):
            x = run.channels["x"]
            known = np.isfinite(x)
            whole = np.interp(run.t, run.t[known], x[known]) if known.any() else x
            for a, b in self.slides[r]:
                cuts = np.arange(a, b, self.block)
                count = np.diff(cuts, append=b)
                seen = np.add.reduceat(known[:b].astype(float), cuts)
                means.append(np.add.reduceat(whole[:b], cuts) / count)
                times.append(np.add.reduceat(run.since_start[:b], cuts) / count)
                spread = np.sqrt(noise.sd**2 / np.maximum(seen, 1.0) + noise.stuck**2)
                weights.append(np.where(seen > 0.0, 1.0 / spread, 0.0))
        return np.concatenate(means), np.concatenate(weights), np.concatenate(times)

    @cached_property
    def measured(self) -> Floats:
        """What was measured, in the form of `displacements`."""
        (row,) = self._projected(self._blocks[0][None, :].copy())
        return np.asarray(row)

    @cached_property
    def degrees(self) -> int:
        """Block means with readings, less the start and the start speed of every slide."""
        return max(int(np.count_nonzero(self._blocks[1])) - 2 * self._edges.size, 1)

    def displacements(self, points: Sequence[Point]) -> Floats:
        """Return displacements of models in units of the noise, a row a model.

        Start and start speed of each slide are projected out.
        """
        problem = self.problem
        if not points:
            return np.zeros((0, self.measured.size))
        runs = [r for r in problem.fitted if self.slides[r]]
        columns = [(r, list(point.names)) for r in runs for point in points]
        values = np.tile([p.values for p in points], (len(runs), 1))
        factors = np.tile([p.factors for p in points], (len(runs), 1))
        number = np.repeat(runs, len(points))
        for r, factor in problem.payload_factors.items():
            factors[number == r, 0] *= factor
        slope = problem.parameter_index("slope_error", "d_alpha_deg")
        values[np.isin(number, list(problem.reversed_runs)), slope] *= -1.0
        found = problem.job.displacements(
            columns, values, factors, self._motions, self.block, problem.threads
        )
        sizes = [sum(-(-(b - a) // self.block) for a, b in self.slides[r]) for r in runs]
        cuts = np.cumsum([n * len(points) for n in sizes])[:-1]
        parts = [part.reshape(len(points), -1) for part in np.split(found, cuts)]
        rows: Floats = np.concatenate(parts, axis=1)
        return self._projected(rows)

    @cached_property
    def _motions(self) -> list[tuple[Floats, Floats, Floats, list[tuple[int, int]]]]:
        return [
            (m.x, m.v, _distance_forward(m, slides), slides)
            for m, slides in zip(self.motions, self.slides, strict=True)
        ]

    @cached_property
    def _line(self) -> tuple[Floats, Floats]:
        """Weighted unit columns of a constant and of the time in every slide."""
        _, w, t = self._blocks
        edges, sizes = self._edges, np.diff(self._edges, append=w.size)

        def total(values: Floats) -> Floats:
            return np.repeat(np.add.reduceat(values, edges), sizes)

        one = w / np.sqrt(np.maximum(total(w * w), 1e-300))
        slope = t * w
        slope = slope - one * total(one * slope)
        return one, slope / np.sqrt(np.maximum(total(slope * slope), 1e-300))

    def _projected(self, rows: Floats) -> Floats:
        """Bring block means into units of the noise, and take out lines in time, in place."""
        edges, sizes = self._edges, np.diff(self._edges, append=rows.shape[1])
        rows *= self._blocks[1]
        for column in self._line:
            along = np.add.reduceat(rows * column, edges, axis=1)
            rows -= np.repeat(along, sizes, axis=1) * column
        return rows


def equation_error(problem: Problem) -> EquationError | None:
    """Return the equation error of a problem; None where no slide is long enough."""
    found = EquationError(problem)
    return found if any(found.slides) else None


def slides_of(motion: MeasuredMotion, last: int, least: int) -> list[tuple[int, int]]:
    """Return the slides in one direction of at least so many samples, before sample `last`.

    Half of what is smoothed over is left out at both ends: there the head may be at rest.
    """
    sign = np.where(np.abs(motion.v) > motion.resting_speed, np.sign(motion.v), 0.0)[:last]
    cuts, half = np.flatnonzero(np.diff(sign)) + 1, motion.width // 2
    edges = np.concatenate([[0], cuts, [sign.size]]).tolist()
    return [
        (a + half, b - half)
        for a, b in pairwise(edges)
        if b - a - 2 * half >= least and sign[a] != 0.0
    ]


def _distance_forward(motion: MeasuredMotion, slides: Sequence[tuple[int, int]]) -> Floats:
    """Return the distance moved forward since a slide began."""
    distance = np.zeros_like(motion.x)
    for a, b in slides:
        if motion.v[a] > 0.0:
            distance[a:b] = np.maximum(motion.x[a:b] - motion.x[a], 0.0)
    return distance
