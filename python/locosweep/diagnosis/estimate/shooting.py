"""Multiple shooting: windows of runs, each replayed freely from the state measured at its start.

Errors of a model grow along a free run, and where the plant is unstable they soon
exceed the motion itself. Over a short window they stay in proportion to their cause.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.regimes import measured_motion
from locosweep.diagnosis.estimate.problem import LOST, Problem
from locosweep.files.channels import CHANNELS
from locosweep.files.runs import Run

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.noise import Noise
    from locosweep.diagnosis.estimate.problem import Point, Shift

    Floats = NDArray[np.float64]

_WIDER = 2.0
"""A start may lie this much further off than noise alone says: the cubic through
the samples around it is no exact motion, and the window's own samples determine it."""
_AROUND = 9
"""Samples that say what the state at a start is, at least."""
_KNOWN = 6
"""Fewest of them that have to be there."""
_MISFIT = 1.5
"""Squares that a cubic leaves over those of noise, up to which it is taken."""
_STILL = 3.0
"""Deviations of a measured speed below which the head counts as at rest."""


@dataclass(frozen=True)
class Window(Run):
    """A window of a run, with the state that was measured at its start.

    Times are those of the run. The samples before `counted[0]` and from `counted[1]` on
    are replayed but do not count: a sensor that reads late has nothing to read there.
    """

    record: int = 0
    """Number of the run."""
    span: tuple[int, int] = (0, 0)
    """First sample within the run, and one beyond the last."""
    counted: tuple[int, int] = (0, 0)
    """First sample within the window that counts, and one beyond the last."""
    origin: float = 0.0
    """Time of the run's first sample, s."""
    base: float = 0.0
    """Position at the run's first sample."""
    state: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Position, speed and acceleration at the window's start."""
    spread: tuple[float, float] = (1.0, 1.0)
    """Deviations of position and speed."""
    sliding_distance: float = 0.0
    """Distance moved forward at the window's start since the last rest or turn before it."""

    @property
    def since_start(self) -> Floats:
        """Seconds since the first sample of the run, not of the window."""
        since: Floats = self.t - self.origin
        return since

    @property
    def start(self) -> tuple[float, float]:
        """Position and speed at the window's start."""
        return self.state[0], self.state[1]


@dataclass(frozen=True)
class _Around:
    """Readings of a run from which the states at starts of windows are found."""

    t: Floats
    x: Floats
    v: Floats | None
    noise: Mapping[str, Noise]
    half: float

    def state(self, when: float) -> tuple[tuple[float, float, float], tuple[float, float]]:
        """Cubic through the samples of x and v around a time, and its deviations.

        A parabola would take a change of acceleration for speed. Where the samples are
        dense, and friction turns its sign among them, fewer of them follow one cubic.
        """
        for share in (1.0, 0.5, 0.25):
            found, deviation, misfit = self._cubic(when, share * self.half)
            if misfit < _MISFIT:
                break
        position, speed, rate, _ = (float(value) for value in found)
        deviation = deviation * np.sqrt(max(misfit, 1.0))
        if abs(speed) < _STILL * deviation[1]:
            # A head that rests starts at rest: noise of its speed would break it away.
            speed = rate = 0.0
        spread = (_WIDER * float(deviation[0]), _WIDER * float(deviation[1]))
        return (position, speed, rate), spread

    def _cubic(self, when: float, half: float) -> tuple[Floats, Floats, float]:
        """Return derivatives at a time, their deviations, and what is left over noise."""
        a, b = _near(self.t, when, half)
        while (a > 0 or b < self.t.size) and np.isfinite(self.x[a:b]).sum() < _KNOWN:
            a, b = max(a - 1, 0), min(b + 1, self.t.size)
        since = self.t[a:b] - when
        powers = np.stack([since**0, since, since**2 / 2, since**3 / 6], axis=1)
        channels = [(self.x, self.noise["x"].sd, powers)]
        if self.v is not None:
            rates = np.concatenate([np.zeros((b - a, 1)), powers[:, :3]], axis=1)
            channels.append((self.v, self.noise["v"].sd, rates))
        rows, values = [], []
        for y, sd, basis in channels:
            ok = np.isfinite(y[a:b])
            rows.append(basis[ok] / sd)
            values.append(y[a:b][ok] / sd)
        wide, y = np.concatenate(rows), np.concatenate(values)
        size = half ** -np.arange(4.0)
        scaled = wide * size
        normal = scaled.T @ scaled
        floor = 1e-12 * max(float(np.trace(normal)), 1e-300)
        covariance = np.linalg.inv(normal + floor * np.eye(4))
        found = size * (covariance @ (scaled.T @ y))
        left = y - wide @ found
        misfit = float(left @ left) / max(y.size - 4, 1)
        return found, size * np.sqrt(np.diag(covariance)), misfit


def _near(run_t: Floats, when: float, half: float) -> tuple[int, int]:
    """Return the samples within `half` seconds of a time, or the few nearest ones."""
    a, b = (int(i) for i in np.searchsorted(run_t, [when - half, when + half]))
    while b - a < _AROUND and (a > 0 or b < run_t.size):
        a, b = max(a - 1, 0), min(b + 1, run_t.size)
    return a, b


def knows_start(run: Run, first: int, half: float) -> bool:
    """Return whether enough is measured within `half` seconds of a sample to start there."""
    a, b = _near(run.t, float(run.t[first]), half)
    return int(np.isfinite(run.channels["x"][a:b]).sum()) >= _KNOWN


def cut(
    runs: Sequence[Run],
    windows: Sequence[tuple[int, int, int]],
    lead: Sequence[int],
    noise: Mapping[str, Noise],
    half: float,
) -> list[Window]:
    """Cut windows (run, first sample, one beyond the last) and find the states at their starts.

    `lead` gives for each run the samples at either end of a window that do not count; readings
    within `half` seconds of a start say what its state is.
    """
    found = []
    around: dict[int, _Around] = {}
    moved: dict[int, Floats] = {}
    for r, a, b in windows:
        run = runs[r]
        if r not in around:
            x = run.channels["x"]
            around[r] = _Around(run.t, x, run.channels.get("v"), noise, half)
            moved[r] = measured_motion(run, noise["x"]).sliding_distance()
        state, spread = around[r].state(float(run.t[a]))
        known = run.channels["x"][np.isfinite(run.channels["x"])]
        found.append(
            Window(
                run.label,
                run.t[a:b],
                run.drive[a:b],
                {name: values[a:b] for name, values in run.channels.items()},
                run.slope_deg,
                record=r,
                span=(a, b),
                counted=(lead[r], b - a - lead[r]),
                origin=float(run.t[0]),
                base=float(known[0]),
                drive_deviation=None if run.drive_deviation is None else run.drive_deviation[a:b],
                state=state,
                spread=spread,
                sliding_distance=float(moved[r][a]),
            )
        )
    return found


@dataclass(frozen=True, eq=False)
class WindowProblem(Problem):
    """Windows of runs against a model; `runs` are windows.

    How each window starts is projected out to first order, within the deviations
    that its window gives: residuals end with the start's shifts in units of these.
    """

    records: Sequence[Run] = ()
    """The runs that the windows lie in."""

    @cached_property
    def windows(self) -> list[Window]:
        """The windows."""
        return [run for run in self.runs if isinstance(run, Window)]

    @property
    def initial_or_none(self) -> None:
        """None: windows say themselves how they begin."""
        return

    def record_of(self, run: int) -> int:
        """Return the measured run that a window lies in."""
        return self.windows[run].record

    @property
    def _driven(self) -> Sequence[Run]:
        return self.records

    @cached_property
    def _noise_weights(self) -> dict[str, Floats]:
        """Inverse deviation of every sample, 0 where it does not count."""
        weights = super()._noise_weights
        for a, window in zip(self.starts_at, self.windows, strict=False):
            for w in weights.values():
                w[a : a + window.counted[0]] = 0.0
                w[a + window.counted[1] : a + window.t.size] = 0.0
        return weights

    @cached_property
    def priors(self) -> dict[str, Floats]:
        """None: how windows start is projected out as states, not as offsets."""
        return {}

    @property
    def _begins(self) -> Floats:
        """State seen, time since the run's start, position there and distance moved forward."""
        return np.array(
            [(*w.state, w.since_start[0], w.base, w.sliding_distance) for w in self.windows]
        )

    @property
    def starts_vary(self) -> bool:
        """False: windows begin in the state that was measured there."""
        return False

    @property
    def position_matters(self) -> bool:
        """False: where windows start is projected out, also for a pendulum."""
        return False

    @property
    def _start_kinds(self) -> int:
        return 3 if "x_rear" in self.channels else 2

    def _found_shifts(self) -> list[Shift]:
        """Return the whitened change of each channel under a shift of every kind of start."""
        plain = self.plain()
        spread = np.array([window.spread for window in self.windows])
        base = self.replay([plain])
        kinds: list[dict[str, Floats]] = []
        for k in range(2):
            step = np.zeros_like(spread)
            step[:, k] = spread[:, k]
            above, below = (self.replay([plain], moved=sign * step) for sign in (1.0, -1.0))
            changes = {c: 0.5 * (above[c][0] - below[c][0]) for c in self.channels}
            lost = {c: np.abs(base[c][0]) >= LOST for c in self.channels}
            kinds.append({c: np.where(lost[c], 0.0, changes[c]) for c in self.channels})
        if "x_rear" in self.channels:
            deviation = float(np.hypot(self.noise["x_rear"].sd, self.noise["x_rear"].stuck))
            kinds.append(
                {c: np.full(self.count, deviation) for c in self.channels if CHANNELS[c].from_rest}
            )
        number = {c: i for i, c in enumerate(self.channels)}
        starts = [[(number[c], change * self.weights[c]) for c, change in kind.items()]
                  for kind in kinds]  # fmt: skip
        return starts + self.gap_shifts.in_core(self.channels, self.seen)

    def driven_by(self, drives: Sequence[Floats]) -> WindowProblem:
        """Return the problem with other drive columns, a row a window.

        Each window is then a record of its own: where two overlap, their drives may differ.
        """
        windows = tuple(
            replace(window, drive=drive, record=r, span=(0, window.t.size))
            for r, (window, drive) in enumerate(zip(self.windows, drives, strict=True))
        )
        return replace(self, runs=windows, records=windows)

    def _span(self, run: int) -> tuple[int, int, int]:
        return (self.windows[run].record, *self.windows[run].span)

    def errors(self, points: Sequence[Point], chosen: Sequence[int]) -> dict[str, Floats]:
        """Return measured minus simulated in the channels' units, a row a point, window by window.

        Starts are shifted within the sensors' noise. NaN where nothing was measured or counts.
        """
        chosen = list(chosen)
        e = self.residuals(points, chosen, most=1.0)
        samples = self.samples_of(chosen)
        ends = np.cumsum(self.lengths)
        picked = np.concatenate([np.arange(ends[r] - self.lengths[r], ends[r]) for r in chosen])
        found = {}
        for i, c in enumerate(self.channels):
            w = self.weights[c][picked]
            with np.errstate(divide="ignore", invalid="ignore"):
                own = e[:, i * samples : (i + 1) * samples]
                found[c] = np.where(w > 0.0, own / w, np.nan)
        return found

    def degrees(self, runs: Sequence[int] | None = None) -> int:
        """Count the residuals of `runs` that fits see, less what the starts take."""
        taken = self._start_kinds * len(self.chosen(runs))
        return int(max(super().degrees(runs) - taken, 1))
