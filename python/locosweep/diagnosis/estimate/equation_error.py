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

from locosweep import _core
from locosweep.diagnosis.data.regimes import measured_motion

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.regimes import MeasuredMotion
    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem

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
    def core(self) -> _core.EquationError:
        """The engine with the measured motion of every run."""
        motions = [
            (m.x, m.v, m.sliding_distance(run.sliding_distance), slides)
            for m, run, slides in zip(self.motions, self.problem.runs, self.slides, strict=True)
        ]
        return _core.EquationError(self.problem.experiment, motions, self.block, *self._blocks)

    @cached_property
    def measured(self) -> Floats:
        """What was measured, in the form of `displacements`."""
        found: Floats = self.core.measured()
        return found

    @cached_property
    def degrees(self) -> int:
        """Block means with readings, less the start and the start speed of every slide."""
        return max(int(np.count_nonzero(self._blocks[1])) - 2 * sum(map(len, self.slides)), 1)

    def displacements(self, fits: Sequence[Fit]) -> Floats:
        """Return displacements of fits in units of the noise, a row a fit.

        Start and start speed of each slide are projected out.
        """
        found: Floats = self.core.displacements(list(fits), self.problem.threads)
        return found

    def jacobian(self, fit: Fit) -> Floats:
        """Return their derivatives, a row for each entry of theta that is not about a start."""
        found: Floats = self.core.jacobian(fit, self.problem.threads)
        return found


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
