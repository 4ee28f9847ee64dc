"""Drives that switched where rows miss: in which row, as far as the motion around tells it.

Each row in which the drive may have switched is a hypothesis. What the drive would then have done
to a free head is taken off the measured position; while the head slides on in one direction the
rest is smooth for the right one. Whatever drives the head may answer late, so that known
switches are asked first: only where these are found in their own rows are others believed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.noise import noise_of
from locosweep.diagnosis.data.regimes import measured_motion
from locosweep.simulation.replay import nominal_of, sensor_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.noise import Noise
    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

_AROUND = 10
"""Rows on either side of a gap whose positions tell where the drive switched."""
_FEWEST = 5
"""Of them, fewest on either side that have to be there, in one slide with the gap."""
_HELD = 3
"""Rows on either side over which a drive has to hold its level to be one that switches."""
_POWERS = 4
"""Coefficients of the smooth rest: a cubic, as friction may change along the slide."""
_OTHER_PUSH = 0.15
"""Deviation of gain over mass, relative: a switch may push by so much more or less."""
_BRAKES = 3.0
"""Rate at which friction may brake what a switch adds to the speed, beside the smooth rest, 1/s."""
_MISFIT = 2.0
"""Squares over those of noise from which the rest is not smooth for any hypothesis."""
_ODDS = 5.0
"""Log likelihood by which one row has to be better than all others: 150 to one."""
_KNOWN, _ASKED, _RIGHT = 3, 12, 0.9
"""Fewest known switches that have to tell their row, most that are asked, and the share of them
that has to be right: a delay of half a row makes it none."""


def told_by_motion(runs: Sequence[Run], robot: Robot) -> list[Run]:
    """Return runs whose drives in gaps switch in the row that the motion tells; others stay."""
    if all(run.drive_deviation is None for run in runs):
        return list(runs)
    nominal = nominal_of(robot)
    noise = noise_of("x", runs, sensor_of(robot))
    slides = [_slides(run, noise, nominal["gain"] / nominal["mass"]) for run in runs]
    answers = [right for one in slides for right in one.known_switches()]
    if len(answers) < _KNOWN or np.mean(answers) < _RIGHT:
        return list(runs)
    return [one.switched() for one in slides]


def _slides(run: Run, noise: Noise, push: float) -> _Slides:
    motion = measured_motion(run, noise)
    way = np.where(np.abs(motion.v) <= motion.resting_speed, 0.0, np.sign(motion.v))
    return _Slides(run, way, noise.sd, push)


@dataclass(frozen=True)
class _Slides:
    """A run, and where it slides on."""

    run: Run
    way: Floats
    """Sign of the speed, 0 at rest."""
    noise: float
    push: float
    """Acceleration by one unit of the drive, m/s^2: gain over mass."""

    @property
    def bounds(self) -> Floats:
        """Deviation of the drive, 0 where it is known."""
        bounds = self.run.drive_deviation
        return np.zeros(self.run.t.size) if bounds is None else bounds

    def switched(self) -> Run:
        """Return the run with the drive in each gap that switched in a row that motion tells."""
        if not (self.bounds > 0.0).any():
            return self.run
        drive, bounds = self.run.drive.copy(), self.bounds.copy()
        for a, b in _stretches(bounds > 0.0):
            row = self._row(a, b) if b < drive.size else None
            if row is not None:
                drive[a:b] = np.where(np.arange(a, b) < row, drive[a - 1], drive[b])
                bounds[a:b] = 0.0
        return replace(self.run, drive=drive, drive_deviation=bounds)

    def known_switches(self) -> list[bool]:
        """Say for known switches whose row the motion tells whether it is the right one."""
        drive = self.run.drive
        edges = (np.flatnonzero(np.diff(drive)) + 1).tolist()
        unknown = np.convolve(self.bounds > 0.0, np.ones(2 * _HELD + 1), mode="same") > 0.0
        rows = [k for k in edges if 1 < k < drive.size - 1 and not unknown[k]]
        # The rows before and after might have been it as well.
        told = [(self._row(k - 1, k + 1), k) for k in rows[:: max(1, len(rows) // _ASKED)]]
        return [row == k for row, k in told if row is not None]

    def _row(self, a: int, b: int) -> int | None:
        """Return the row from a to b, from which on the drive has its level behind b.

        None where the drive holds no level on both sides, the head does not slide on, or too
        little speaks for one row.
        """
        drive = self.run.drive
        before, after = drive[max(a - _HELD, 0) : a], drive[b : b + _HELD]
        if not before.size or not after.size or np.ptp(before) > 0.0 or np.ptp(after) > 0.0:
            return None
        window = self._window(a, b)
        if window is None or before[-1] == after[0]:
            return None
        squares = []
        for row in range(a, b + 1):
            supposed = drive[window].copy()
            supposed[a - window.start : b - window.start] = np.where(
                np.arange(a, b) < row, before[-1], after[0]
            )
            squares.append(self._rest(window, supposed, row, (a, b), after[0] - before[-1]))
        best, second = np.sort(squares)[:2]
        seen = int(np.isfinite(self.run.channels["x"][window]).sum())
        if best > _MISFIT * (seen - _POWERS) or second - best < 2.0 * _ODDS:
            return None
        return a + int(np.argmin(squares))

    def _window(self, a: int, b: int) -> slice | None:
        """Return the rows around a gap that lie in one slide with it."""
        first, last = max(a - 1 - _AROUND, 0), min(b + _AROUND, self.run.t.size)
        others = np.flatnonzero(self.way[first:last] != self.way[a - 1]) + first
        first = max([first, *(others[others < a - 1] + 1)])
        last = min([last, *others[others > a - 1]])
        seen = np.isfinite(self.run.channels["x"])
        few = min(seen[first:a].sum(), seen[b:last].sum()) < _FEWEST
        return None if self.way[a - 1] == 0.0 or few else slice(int(first), int(last))

    def _rest(
        self, window: slice, drive: Floats, row: int, gap: tuple[int, int], step: float
    ) -> float:
        """Return the squares, in noise, that a smooth rest leaves under a supposed drive."""
        t = self.run.t[window] - self.run.t[row]
        x = self.run.channels["x"][window] - self.push * _free(drive, t)
        # Other gaps are as unknown, and a switch may push more than by the nominal mass.
        # The speed that it gives is braked otherwise.
        after = np.maximum(t, 0.0)
        columns = [0.5 * after**2, after**3 / 6.0]
        priors = [share * self.push * abs(step) for share in (_OTHER_PUSH, _BRAKES)]
        unknown = self.bounds[window] > 0.0
        unknown[gap[0] - window.start : gap[1] - window.start] = False
        for c, d in _stretches(unknown):
            own = self.push * self.bounds[window] * (np.arange(t.size) >= c)
            columns.append(_free(np.where(np.arange(t.size) < d, own, 0.0), t))
            priors.append(1.0)
        scaled = np.array(columns) * np.array(priors)[:, None]
        powers = (t / (t[-1] - t[0])) ** np.arange(_POWERS)[:, None]
        ok = np.isfinite(x)
        wide = np.concatenate([powers, scaled])[:, ok].T / self.noise
        # Priors are rows of their own.
        own_rows = np.eye(wide.shape[1])[_POWERS:]
        y = np.concatenate([(x[ok] - x[ok].mean()) / self.noise, np.zeros(len(own_rows))])
        rows = np.concatenate([wide, own_rows])
        found, *_ = np.linalg.lstsq(rows, y, rcond=None)
        return float(np.sum((y - rows @ found) ** 2))


def _free(drive: Floats, t: Floats) -> Floats:
    """Return the second integral of a held drive over time."""
    step = np.diff(t)
    speed = np.concatenate([[0.0], np.cumsum(drive[:-1] * step)])
    place = (speed[:-1] + 0.5 * drive[:-1] * step) * step
    return np.concatenate([[0.0], np.cumsum(place)])


def _stretches(which: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return first row and one beyond the last of each stretch of true rows."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], which, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
