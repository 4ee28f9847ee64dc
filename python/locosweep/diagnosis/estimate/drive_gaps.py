"""What a drive that is known only within bounds, where rows miss, may have changed of a run.

The impulse of such a gap shifts speed and position of all that follows. Like the start of a run
it is no finding: residuals are free of it, as far as the bounds of the drive go.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core
from locosweep.diagnosis.estimate.slides import Slides
from locosweep.files.channels import REPLAYED

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]
    Columns = list[dict[str, Floats]]
    """Changes by channel, whitened, one deviation of one cause each."""

_GAPS = 96
"""Gaps of a run that are followed one by one, at most; where there are more, neighbours are
taken together: over a hundredth of a run their responses hardly differ."""
_MEMORY = 3
"""Rows over which a force may remember its drive: a lag, a spring that swings. So long a reading
of it is as little known as the drive in the gap before."""
_DEVIATIONS = (-1.0, 1.0)
"""Drives of a gap, in its deviations, that the nominal model is replayed with."""
_UNSEEN = 1e-4
"""Squared length of a shift, in noise, that changes no verdict."""


@dataclass(frozen=True)
class GapShifts:
    """Shifts by gaps in the drive of all runs, sample by sample, a deviation of each."""

    kinds: Columns
    """A run has one size of each kind; 0 where a run has fewer."""
    variance: Mapping[str, Floats]
    """Variance, in noise, of what these leave out of all gaps."""
    edges: NDArray[np.intp]
    """First sample of each run, and one beyond the last."""

    def in_core(
        self, channels: Sequence[str], seen: NDArray[np.bool_]
    ) -> list[list[tuple[int, Floats]]]:
        """Return the shifts as the core takes them, 0 in samples that fits do not see."""
        return [
            [(i, kind[c] * seen / np.sqrt(1.0 + self.variance[c])) for i, c in enumerate(channels)]
            for kind in self.kinds
        ]

    def of(self, errors: Mapping[str, Floats], starts: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return the shifts that errors ask for, as far as the bounds of the drive go.

        Errors are whitened, channel by channel, of shape (models, samples of all runs); 0
        where nothing was measured. `starts` are whitened start offsets by channel, of one
        deviation, which are fitted and returned with the others.
        """
        found = {c: np.zeros_like(e) for c, e in errors.items()}
        kinds = [*self.kinds, *({c: change} for c, change in starts.items())]
        for a, b in zip(self.edges[:-1], self.edges[1:], strict=True):
            shift = {
                c: np.array([k[c][a:b] if c in k else np.zeros(b - a) for k in kinds])
                for c in errors
            }
            normal = np.eye(len(kinds))
            along = np.zeros((len(kinds), len(next(iter(errors.values())))))
            for c, e in errors.items():
                shift[c] = shift[c] / np.sqrt(1.0 + self.variance[c][a:b])
                normal += shift[c] @ shift[c].T
                along += shift[c] @ e[:, a:b].T
            sizes = np.linalg.solve(normal, along)
            for c, change in shift.items():
                found[c][:, a:b] = sizes.T @ change
        return found


def gap_shifts(problem: Problem, weights: Mapping[str, Floats], most: int) -> GapShifts:
    """Return at most `most` kinds of shifts, whitened by the weights of all runs' samples."""
    edges = problem.starts_at
    variance = {c: np.zeros(problem.count) for c in weights}
    if all(run.drive_deviation is None for run in problem.runs):
        return GapShifts([], variance, edges)
    gain = problem.nominal["gain"]
    found = []
    nominal_speeds = np.split(problem.replay([problem.plain()])["v"][0], edges[1:-1])
    for r, run in enumerate(problem.runs):
        at = slice(int(edges[r]), int(edges[r + 1]))
        # Slides too short to be measured are those of the nominal model.
        motion = problem.motions[r]
        slides = (np.abs(motion.v) > motion.resting_speed) | (nominal_speeds[r] != 0.0)
        changes = [_along_motion(problem, run, slides), _of_nominal(problem, r)]
        columns = _whitened(changes, gain * run.drive, {c: w[at] for c, w in weights.items()})
        shifts, rest = _strongest(columns, most)
        found.append(shifts)
        for c, squares in rest.items():
            variance[c][at] = squares
        if "force" in weights and run.drive_deviation is not None:
            after = gain * _remembered(run.drive_deviation)
            variance["force"][at] = (after * weights["force"][at]) ** 2
    kinds = [{c: np.zeros(problem.count) for c in weights} for _ in range(max(map(len, found)))]
    for r, shifts in enumerate(found):
        for kind, shift in zip(kinds, shifts, strict=False):
            for c, change in shift.items():
                kind[c][edges[r] : edges[r + 1]] = change
    return GapShifts(kinds, variance, edges)


def _along_motion(problem: Problem, run: Run, slides: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return changes of position and speed by each gap along the motion as it was measured."""
    nominal = problem.nominal
    motion = Slides.of_run(run.t, slides.astype(float), nominal["mass"], nominal["viscous"])
    return motion.response(nominal["gain"] * _by_gap(run))


def _of_nominal(problem: Problem, r: int) -> tuple[Floats, Floats]:
    """Return changes of position and speed of the nominal model by each gap.

    Its reversals amplify them, which the motion as measured does not show, and large impulses
    bend them: a row a gap for each coefficient of a polynomial through `_DEVIATIONS`. Windows
    are too short for either to matter.
    """
    run = problem.runs[r]
    if not problem.starts_vary or run.drive_deviation is None:
        return np.zeros((0, run.t.size)), np.zeros((0, run.t.size))
    drives = _by_gap(run)
    slope = problem.nominal["slope_deg"] if run.slope_deg is None else run.slope_deg
    ways = [run.drive, *(run.drive + size * drive for size in _DEVIATIONS for drive in drives)]
    job = _core.Replay({**problem.nominal}, [(run.since_start, way, slope) for way in ways])
    plain = problem.plain()
    start = (problem.starts.position[r], problem.starts.speed[r])
    values, factors, starts = (
        np.tile(row, (len(ways), 1)) for row in (plain.values, plain.factors, start)
    )
    whole: list[tuple[int, int, int, list[str]]]
    whole = [(i, 0, run.t.size, []) for i in range(len(ways))]
    channels = [REPLAYED.index(name) for name in ("x", "v")]
    read = job.run(whole, values, factors, starts, problem.threads, channels=channels)
    sizes = np.array(_DEVIATIONS)
    powers = np.linalg.inv(sizes[:, None] ** np.arange(1, sizes.size + 1))

    def coefficients(part: Floats) -> Floats:
        rows = part.reshape(len(ways), -1)
        changes = (rows[1:] - rows[0]).reshape(sizes.size, -1)
        return np.asarray((powers @ changes).reshape(-1, run.t.size), dtype=np.float64)

    return coefficients(read[0]), coefficients(read[1])


def _whitened(
    changes: Sequence[tuple[Floats, Floats]], force: Floats, weights: Mapping[str, Floats]
) -> Columns:
    """Return changes of position and speed as changes of what is measured, in its noise.

    Each of the ways to tell them gets an equal part of their variance.
    """
    told = sum(len(dx) > 0 for dx, _ in changes)
    dx, dv = (np.concatenate([pair[i] for pair in changes]) / np.sqrt(told) for i in range(2))
    seen = {"x": dx, "v": dv}
    # Power is force times speed, beside what the force loses in the motor.
    seen["power"] = dv * force
    rows = {c: seen[c] * w for c, w in weights.items() if c in seen}
    return [{c: row[i] for c, row in rows.items()} for i in range(len(dx))]


def _by_gap(run: Run) -> Floats:
    """Return one deviation of the drive, a row a gap, or a row some neighbouring ones."""
    deviation = np.zeros(run.t.size) if run.drive_deviation is None else run.drive_deviation
    rows = np.flatnonzero(deviation > 0.0)
    if not rows.size:
        return np.zeros((0, run.t.size))
    number = np.cumsum(np.diff(rows, prepend=rows[0]) > 1)
    count = int(number[-1]) + 1
    group = np.arange(count) if count <= _GAPS else np.arange(count) * _GAPS // count
    found = np.zeros((int(group[-1]) + 1, run.t.size))
    found[group[number], rows] = deviation[rows]
    # Gaps are independent: impulses of those taken together add in squares.
    sums = np.bincount(number, deviation[rows])
    share: Floats = np.sqrt(np.bincount(group, sums**2)) / np.bincount(group, sums)
    return found * share[:, None]


def _remembered(deviation: Floats) -> Floats:
    """Return the deviation of the force in the rows after a gap, which forgets the drive."""
    found = deviation.copy()
    for back in range(1, 3 * _MEMORY + 1):
        later = deviation[:-back] * np.exp(-(back - 1) / _MEMORY)
        found[back:] = np.maximum(found[back:], later)
    return found


def _strongest(columns: Columns, most: int) -> tuple[Columns, dict[str, Floats]]:
    """Combine the shifts of a run into at most `most`; return the variance that these leave out.

    These are principal ones: their span and covariance are those of all.
    """
    if not columns:
        return [], {}
    channels = list(columns[0])
    wide = np.array([np.concatenate([column[c] for c in channels]) for column in columns])
    squares, turned = np.linalg.eigh(wide @ wide.T)
    seen = [i for i in np.argsort(squares)[::-1] if squares[i] > _UNSEEN]
    main, rest = (turned[:, seen[part]].T @ wide for part in (slice(most), slice(most, None)))
    shifts = [dict(zip(channels, np.split(row, len(channels)), strict=True)) for row in main]
    left = np.split(np.sum(rest**2, axis=0), len(channels))
    return shifts, dict(zip(channels, left, strict=True))
