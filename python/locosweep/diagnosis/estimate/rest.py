"""What a model leaves, as a force inside the plant that no effect stands for.

Measured rigs never come down to the noise of their sensors. So every model has the same rest:
a force that is a random function of time, of its own in each run (a Gaussian process with an
exponential covariance), and that moves the head where the head is seen to slide. It is taken
out of residuals to first order, as starts of runs are, so that models are compared by what the
rest does not do as well (Kennedy and O'Hagan 2001; inside the plant as by Wu, Levine, Schneider
and Stuart 2024). Its size, its correlation time and the variance of what even it leaves are the
likeliest ones beside a fit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import point_of
from locosweep.diagnosis.estimate.slides import Slides
from locosweep.files.channels import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Point, Problem, Shift

    Floats = NDArray[np.float64]

_KNOTS = 24
"""Knots of the force along a run, at most: the time of a fit grows with them. Not derived."""
_SPACING = 6
"""Samples between two knots, at least: a faster force is noise."""
_TIMES = (1 / 16, 1 / 4, 1.0, 4.0)
"""Correlation times that are tried, in durations of the longest run."""
_SIZES = np.geomspace(1e-5, 3.0, 28)
"""Deviations of the force that are tried, in root mean squares of the drive force: a step is
a factor of 1.6, which changes no likelihood by more than a parameter costs."""
_JITTER = 1e-9
"""Part of a variance that is added on a diagonal, so that a covariance has a root."""


@dataclass(frozen=True)
class Rest:
    """The likeliest rest beside a fit."""

    size: float
    """Standard deviation of the force where a run has the stated noise, N: a run that has more has
    as much more of the force, and starts that are as much less sure."""
    time: float
    """Correlation time, s."""
    noise: tuple[float, ...]
    """Variance of what even this leaves of each fitted run, in that of the stated noise, 1 or
    more: a run that no model follows says the less about all."""
    deviance: float
    """Minus twice the log likelihood of the fit with it, up to a constant of the runs."""


@dataclass(frozen=True, eq=False)
class RestForce:
    """The force along the runs of a problem, and how likely a size of it is beside a fit."""

    problem: Problem

    def beside(self, fits: Sequence[Fit]) -> list[Rest]:
        """Return the likeliest rest beside each of some fits."""
        points = [point_of(self.problem, fit) for fit in fits]
        moments, squares = self._moments(self._residuals(points))
        count = self._counts
        best = [Rest(0.0, 1.0, (), np.inf)] * len(fits)
        sizes = _SIZES * self._drive_force
        for time, (values, along) in self._spectra.items():
            parts = np.einsum("rkj,frj->frk", along, moments) ** 2
            signal = np.square(sizes)[:, None, None] * values
            left = squares[:, None] - np.einsum("srk,frk->fsr", signal / (1.0 + signal), parts)
            noise = np.maximum(left / count, 1.0)
            deviance = (left / noise + count * np.log(noise)).sum(axis=2)
            deviance += np.log1p(signal).sum(axis=(1, 2))
            for i, s in enumerate(deviance.argmin(axis=1).tolist()):
                if deviance[i, s] < best[i].deviance:
                    wider = tuple(noise[i, s].tolist())
                    best[i] = Rest(float(sizes[s]), time, wider, float(deviance[i, s]))
        return best

    def log_bayes_factor(self, fit: Fit) -> float:
        """Return the log Bayes factor of the likeliest force beside a fit, on the scale of chi2.

        More noise than was stated is no merit of the force: what other models leave has it, too.
        """
        squares = self._moments(self._residuals([point_of(self.problem, fit)]))[1]
        rest = self.beside([fit])[0]
        noise = np.array(rest.noise)
        wider = float(self._counts @ (noise - 1.0 - np.log(noise)))
        return float(squares.sum()) - rest.deviance - wider

    def beside_one(self, rest: Rest) -> Problem:
        """Return the problem in which every model leaves this rest, and as much noise."""
        problem = self.problem
        factors = np.full(len(problem.runs), np.sqrt(np.median(rest.noise)))
        factors[problem.fitted] = np.sqrt(rest.noise)
        wider = replace(
            problem,
            known=problem.noise,
            wider=tuple(factors.tolist()),
            known_shifts=problem.start_shifts,
            initial=problem.initial_or_none,
        )
        rows = {c: np.zeros((self._knots, problem.count)) for c in ("x", "v")}
        for r, response in enumerate(self._responses):
            own = slice(problem.starts_at[r], problem.starts_at[r + 1])
            root = rest.size * _root(self._times[r], rest.time)
            for c, row in rows.items():
                row[:, own] = root.T @ response[c]
        number = {c: i for i, c in enumerate(problem.channels)}
        shifts: list[Shift] = [
            # In deviations of the stated noise: what a factor widens, it widens as a whole.
            [(number[c], row[k] * problem.weights[c] * problem.seen)
             for c, row in rows.items() if c in number]
            for k in range(self._knots)
        ]  # fmt: skip
        return replace(wider, rest=shifts)

    @cached_property
    def _knots(self) -> int:
        return int(np.clip(self.problem.lengths.max() // _SPACING, 2, _KNOTS))

    @cached_property
    def _times(self) -> list[Floats]:
        """Times of the knots in each run, s from its first sample."""
        ends = [float(run.t[-1] - run.t[0]) for run in self.problem.runs]
        return [np.linspace(0.0, end, self._knots) for end in ends]

    @cached_property
    def _drive_force(self) -> float:
        drives = np.concatenate([run.drive for run in self.problem.runs])
        return max(float(np.sqrt(np.mean(np.square(drives * self.problem.nominal["gain"])))), 1e-12)

    @cached_property
    def _responses(self) -> list[dict[str, Floats]]:
        """What a unit force at each knot, linear between them, changes in x and v of each run.

        It acts along the measured motion: a model that stands still where the head slides
        would hide it.
        """
        problem, found = self.problem, []
        mass, damping = problem.nominal["mass"], max(problem.nominal["viscous"], 0.0)
        for run, motion, times in zip(problem.runs, problem.motions, self._times, strict=True):
            t = run.t - run.t[0]
            hats = np.array([np.interp(t, times, row) for row in np.eye(times.size)])
            speed = np.where(np.abs(motion.v) > motion.resting_speed, motion.v, 0.0)
            dx, dv = Slides.of_run(t, speed, mass, damping).response(hats)
            found.append({"x": dx, "v": dv})
        return found

    @cached_property
    def _weights(self) -> list[Floats]:
        return [self.problem.weights[c] * self.problem.seen for c in self.problem.channels]

    @cached_property
    def _counts(self) -> Floats:
        """Readings that count of each fitted run."""
        p = self.problem
        spans = [slice(p.starts_at[r], p.starts_at[r + 1]) for r in p.fitted]
        found = [sum(np.count_nonzero(w[own]) for w in self._weights) for own in spans]
        counts: Floats = np.maximum(np.array(found, dtype=float), 1.0)
        return counts

    @cached_property
    def _rows(self) -> list[tuple[Floats, Floats]]:
        """Weighted rows of each fitted run: of its start's shifts, and of the knots."""
        problem, found = self.problem, []
        for r in problem.fitted:
            own = slice(problem.starts_at[r], problem.starts_at[r + 1])
            shape = (len(problem.channels), int(problem.lengths[r]))
            starts = np.zeros((len(problem.start_shifts), *shape))
            for row, shift in zip(starts, problem.start_shifts, strict=True):
                for channel, change in shift:
                    row[channel] = change[own]
            force = np.zeros((self._knots, *shape))
            for i, c in enumerate(problem.channels):
                if c in self._responses[r]:
                    force[:, i] = self._responses[r][c] * self._weights[i][own]
            found.append((starts.reshape(len(starts), shape[0] * shape[1]),
                          force.reshape(self._knots, -1)))  # fmt: skip
        return found

    @cached_property
    def _bases(self) -> list[tuple[Floats, Floats, Floats]]:
        """Orthonormal directions in the readings of each fitted run, a column each.

        What its start can do, within its prior; what the knots do beside that; and the root of the
        products of the knots: their rows are its transpose in these directions. Both sorts of rows
        move readings by millions of deviations, so that their products would hold few digits.
        """
        found: list[tuple[Floats, Floats, Floats]] = []
        for starts, force in self._rows:
            shifts, count = starts.shape
            # A prior is a reading of the shift itself.
            of_start = np.linalg.qr(np.hstack([starts, np.eye(shifts)]).T)[0]
            force = np.hstack([force, np.zeros((self._knots, shifts))])
            of_force, root = np.linalg.qr((force - (force @ of_start) @ of_start.T).T)
            # A run of few readings has fewer directions than knots.
            missing = self._knots - len(root)
            of_force = np.pad(of_force, ((0, 0), (0, missing)))
            root = np.pad(root, ((0, missing), (0, 0)))
            found.append((of_start[:count], of_force[:count], root))
        return found

    @cached_property
    def _spectra(self) -> dict[float, tuple[Floats, Floats]]:
        """Squared singular values of the force in each fitted run, and their directions.

        By correlation time; directions are those in the moments. Shapes (runs, knots) and
        (runs, knots, knots).
        """
        longest = max(float(times[-1]) for times in self._times)
        found = {}
        for time in (longest * share for share in _TIMES):
            values, along = [], []
            for r, (_, _, root) in zip(self.problem.fitted, self._bases, strict=True):
                _, one, vectors = np.linalg.svd(_root(self._times[r], time).T @ root.T)
                values.append(np.square(one))
                along.append(vectors)
            found[time] = np.array(values), np.array(along)
        return found

    def _residuals(self, points: Sequence[Point]) -> list[Floats]:
        """Return weighted errors of models in each fitted run, a row a model."""
        problem = self.problem
        read = problem.replay(points)
        parts = []
        for c, weight in zip(problem.channels, self._weights, strict=True):
            measured = problem.measured[c]
            if CHANNELS[c].from_rest:
                measured = measured - np.repeat(problem.start_levels[c], problem.lengths)
            parts.append(np.where(weight > 0.0, (measured - read[c]) * weight, 0.0))
        spans = [slice(problem.starts_at[r], problem.starts_at[r + 1]) for r in problem.fitted]
        return [np.concatenate([part[:, own] for part in parts], axis=1) for own in spans]

    def _moments(self, residuals: Sequence[Floats]) -> tuple[Floats, Floats]:
        """Return residuals along the directions of the knots, and squares of residuals.

        Shapes (models, runs, knots) and (models, runs).
        """
        moments, squares = [], []
        for e, (of_start, of_force, _) in zip(residuals, self._bases, strict=True):
            started = e @ of_start
            squares.append(np.einsum("ij,ij->i", e, e) - np.einsum("ij,ij->i", started, started))
            moments.append(e @ of_force)
        return np.stack(moments, axis=1), np.stack(squares, axis=1)


def _root(times: Floats, time: float) -> Floats:
    """Return a root of the covariance between knots of a force of deviation 1."""
    covariance = np.exp(-np.abs(times[:, None] - times) / time)
    return np.asarray(np.linalg.cholesky(covariance + _JITTER * np.eye(times.size)))
