"""Measured runs against a model: batches of replays as whitened residuals."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core
from locosweep.diagnosis.data.noise import Noise, noise_of, stretches
from locosweep.diagnosis.data.regimes import measured_motion
from locosweep.files.channels import CHANNELS, OFFSETS, PREDICTED, REPLAYED
from locosweep.simulation.replay import effect, motor_of, nominal_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.regimes import MeasuredMotion
    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run

LOST = 1e60
"""Reading of a model that cannot be replayed to the end: far from everything."""
_ANYWHERE = 10.0
"""Deviation of a start that was not measured, in spans of its run."""
_BATCH = 4_000_000
"""Samples of one call: some 130 MB of readings."""


@dataclass(frozen=True)
class Point:
    """A model to replay: effects, the parameters of all effects, and nuisances."""

    names: tuple[str, ...]
    values: NDArray[np.float64]
    factors: NDArray[np.float64]
    """Factors on mass, Coulomb level and gain, and the clock offset in s."""
    speeds: NDArray[np.float64]
    """Start speed of each run."""
    start_offsets: NDArray[np.float64]
    """Shift of each run's start position, where the motion depends on it."""


@dataclass(frozen=True)
class InitialStates:
    """State in which every run begins, and which runs begin in motion."""

    position: NDArray[np.float64]
    """Position of the head at the first sample of each run, m."""
    speed: NDArray[np.float64]
    """Its speed there, m/s."""
    moving: tuple[int, ...] = ()
    """Runs that begin in motion."""


class ReplayMeter:
    """Count of the samples replayed so far, from which searches know their effort."""

    def __init__(self) -> None:
        self.samples = 0

    def add(self, samples: int) -> None:
        """Count samples that were replayed."""
        self.samples += samples


@dataclass(frozen=True, eq=False)
class Problem:
    """Runs, noise and weights; residuals of models in units of their noise.

    A value: what is derived from its fields is computed when first asked for and stays.
    The start offset of each run (of `x`, and of `x_rear`) is projected out with the
    uncertainty of the samples before the drive first changes.
    """

    robot: Robot
    runs: Sequence[Run]
    threads: int
    held: tuple[int, ...] = ()
    """Runs that take no part in fits."""
    train_fraction: float = 1.0
    """Share of every run that fits see; below 1 only where there is one run."""
    known: Mapping[str, Noise] | None = None
    """Noise of channels, where it is not to be read off the runs."""
    payload_factors: Mapping[int, float] = field(default_factory=dict)
    """Factor on the known mass, of runs with a payload."""
    reversed_runs: frozenset[int] = frozenset()
    """Runs of a robot that was turned round: an error of the slope has the other sign."""
    initial: InitialStates | None = None
    """Where runs begin, if not as they were measured."""
    speed_scale: float = 1.0
    """A large speed of this rig, m/s."""
    meter: ReplayMeter = field(default_factory=ReplayMeter, repr=False)
    """Where replays are counted; it takes part in no result."""

    @cached_property
    def nominal(self) -> dict[str, float]:
        """Parameters of the nominal model."""
        return nominal_of(self.robot)

    @cached_property
    def motor(self) -> tuple[float, float] | None:
        """Resistance and force constant, where the model has a motor."""
        return motor_of(self.robot)

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """Channels that are measured in some run and that a replay predicts."""
        predicted = PREDICTED if self.motor else REPLAYED
        return tuple(c for c in predicted if any(c in run.channels for run in self.runs))

    @cached_property
    def noise(self) -> dict[str, Noise]:
        """Noise of each channel."""
        sensor = {
            key.removeprefix("sensor."): float(value)
            for key, value in self.robot.other.items()
            if key.startswith("sensor.")
        }
        return {
            c: self.known[c] if self.known and c in self.known else noise_of(c, self.runs, sensor)
            for c in self.channels
        }

    @cached_property
    def lengths(self) -> NDArray[np.intp]:
        """Samples of each run."""
        return np.array([run.t.size for run in self.runs])

    @cached_property
    def starts_at(self) -> NDArray[np.intp]:
        """First sample of each run among those of all, and one beyond the last."""
        return np.concatenate([[0], np.cumsum(self.lengths)])

    @cached_property
    def job(self) -> _core.Replay:
        """The engine with the drives of the runs."""
        return self._engine(self.runs)

    def _engine(self, runs: Sequence[Run]) -> _core.Replay:
        slope = self.nominal["slope_deg"]
        data = [
            (run.since_start, run.drive, slope if run.slope_deg is None else run.slope_deg)
            for run in runs
        ]
        return _core.Replay({**self.nominal}, data)

    @cached_property
    def starts(self) -> InitialStates:
        """State in which every run begins."""
        if self.initial is not None:
            return self.initial
        measured = np.array([run.start for run in self.runs])
        return InitialStates(measured[:, 0], measured[:, 1])

    @cached_property
    def measured(self) -> dict[str, NDArray[np.float64]]:
        """Readings of all runs, NaN where nothing was measured."""
        return {
            c: np.concatenate(
                [run.channels.get(c, np.full(run.t.size, np.nan)) for run in self.runs]
            )
            for c in self.channels
        }

    @cached_property
    def motions(self) -> tuple[MeasuredMotion, ...]:
        """Smoothed motion of each run."""
        return tuple(measured_motion(run, self.noise["x"]) for run in self.runs)

    @cached_property
    def weights(self) -> dict[str, NDArray[np.float64]]:
        """Inverse deviation of every sample, 0 where it does not count."""
        return {c: self._weights(c, y) for c, y in self.measured.items()}

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """Samples that fits see, of runs that are not held out."""
        position = np.concatenate([np.arange(n) / n for n in self.lengths])
        seen: NDArray[np.bool_] = position < self.train_fraction
        return seen

    @cached_property
    def fitted(self) -> list[int]:
        """Runs that take part in fits."""
        return [r for r in range(len(self.runs)) if r not in self.held]

    def _weights(self, channel: str, y: NDArray[np.float64]) -> NDArray[np.float64]:
        noise = self.noise[channel]
        weight = np.where(np.isfinite(y), 1.0 / noise.sd, 0.0)
        if noise.stuck > 0.05 * noise.sd:
            # Samples at rest repeat one error of the quantiser: together they
            # count for as many as their mean is worth.
            for a, b in zip(self.starts_at, self.starts_at[1:], strict=False):
                number = stretches(y[a:b], noise.step * 1.01 + 4.0 * noise.gaussian)
                counts = np.bincount(number)[number].astype(float)
                worth = noise.sd**2 / (noise.sd**2 / counts + noise.stuck**2)
                weight[a:b] *= np.sqrt(np.minimum(1.0, worth / counts))
        return weight

    @cached_property
    def priors(self) -> dict[str, NDArray[np.float64]]:
        """Deviation of the start offset of each run, by channel that has offsets."""
        return {c: self._offset_deviations(c) for c in OFFSETS if c in self.channels}

    @cached_property
    def rest_levels(self) -> dict[str, NDArray[np.float64]]:
        """Reading of each run before its drive first changes, by channel that has offsets."""
        found = {}
        for c in OFFSETS:
            if c in self.channels:
                levels = []
                for run in self.runs:
                    before, known = _at_start(run, c)
                    first = float(known[0]) if known.size else 0.0
                    levels.append(float(before.mean()) if before.size else first)
                found[c] = np.array(levels)
        return found

    def _offset_deviations(self, channel: str) -> NDArray[np.float64]:
        noise = self.noise[channel]
        # That of one sample: a bristle may give way while the drive rests.
        own = float(np.hypot(noise.sd, noise.stuck))
        deviations = []
        for run in self.runs:
            before, known = _at_start(run, channel)
            # Where nothing was measured before the drive changes, it is anywhere.
            span = float(np.ptp(known)) if known.size else 0.0
            deviations.append(own if before.size else own + _ANYWHERE * span)
        return np.array(deviations)

    @property
    def count(self) -> int:
        """Samples of all runs."""
        return int(self.starts_at[-1])

    def plain(self) -> Point:
        """Return the nominal model."""
        return Point(
            (),
            np.zeros(_core.effect_parameter_count()),
            np.array([1.0, 1.0, 1.0, 0.0]),
            self.starts.speed.copy(),
            np.zeros(len(self.runs)),
        )

    @property
    def position_matters(self) -> bool:
        """Whether the motion itself depends on where a run starts: that of a pendulum."""
        return "gravity_torque" in self.nominal

    @property
    def starts_vary(self) -> bool:
        """Whether runs may begin in motion, so that start speeds are found first."""
        return True

    def has_offset(self, channel: str) -> bool:
        """Whether a channel has a start offset that is projected out."""
        return channel in self.priors and not (channel == "x" and self.position_matters)

    def parameter_index(self, name: str, parameter: str) -> int:
        """Return the place of a parameter among those of all effects."""
        record = effect(name)
        return record.first + [p.name for p in record.parameters].index(parameter)

    def replay(
        self, points: Sequence[Point], runs: Sequence[int] | None = None
    ) -> dict[str, NDArray[np.float64]]:
        """Return what the sensors would read, per channel, a row a point.

        With `runs`, only those runs are replayed, one after another.
        """
        chosen = range(len(self.runs)) if runs is None else runs
        self.meter.add(len(points) * int(self.lengths[list(chosen)].sum()))
        columns = [
            (r, 0, int(self.lengths[r]), list(point.names)) for point in points for r in chosen
        ]
        values = np.repeat([p.values for p in points], len(chosen), axis=0)
        shares = np.repeat([p.factors for p in points], len(chosen), axis=0)
        starts = np.array(
            [
                (self.starts.position[r] + p.start_offsets[r], p.speeds[r])
                for p in points
                for r in chosen
            ]
        )
        if self.payload_factors or self.reversed_runs:
            number = np.tile(np.array(list(chosen)), len(points))
            for r, factor in self.payload_factors.items():
                shares[number == r, 0] *= factor
            slope = self.parameter_index("slope_error", "d_alpha_deg")
            values[np.isin(number, list(self.reversed_runs)), slope] *= -1.0
        read = self.job.run(columns, values, shares, starts, self.threads)
        return self.readings(read, len(points))

    def readings(
        self, read: Sequence[NDArray[np.float64]], rows: int
    ) -> dict[str, NDArray[np.float64]]:
        """Lay out what the engine gave, a row a point, with the power that follows from it."""
        found = {c: one.reshape(rows, -1) for c, one in zip(REPLAYED, read, strict=True)}
        if self.motor and "power" in self.channels:
            force, speed = read[REPLAYED.index("force")], read[REPLAYED.index("v")]
            # A force that was given had the voltage that it needs.
            motor = (np.inf, *self.motor)
            found["power"] = _core.motor_power(force, speed, motor).reshape(rows, -1)
        wrong = ~np.isfinite(found["x"]).all(axis=1)
        for reading in found.values():
            reading[wrong] = LOST
        return found

    def residuals(
        self, points: Sequence[Point], runs: Sequence[int] | None = None
    ) -> NDArray[np.float64]:
        """Return whitened residuals of the runs that are fitted, or of `runs`.

        A row a point: channel by channel, run by run, and last the start offsets in
        units of their uncertainty. Samples behind `train_fraction` are 0.
        """
        chosen = self.fitted if runs is None else list(runs)
        samples = int(self.lengths[chosen].sum())
        limit = max(1, _BATCH // max(1, samples))
        parts = [
            self._residuals(points[i : i + limit], chosen) for i in range(0, len(points), limit)
        ]
        return np.concatenate(parts) if len(parts) != 1 else parts[0]

    def _residuals(self, points: Sequence[Point], chosen: list[int]) -> NDArray[np.float64]:
        found = self.replay(points, chosen)
        picked = np.concatenate(
            [np.arange(self.starts_at[r], self.starts_at[r + 1]) for r in chosen]
        )
        edges = np.concatenate([[0], np.cumsum(self.lengths[chosen])])[:-1]
        rows: list[NDArray[np.float64]] = []
        extra: list[NDArray[np.float64]] = []
        for c in self.channels:
            y, w = self.measured[c][picked], self.weights[c][picked] * self.seen[picked]
            e = np.where(w > 0.0, y, 0.0) - found[c]
            if self.has_offset(c):
                if CHANNELS[c].from_rest:
                    e -= np.repeat(self.rest_levels[c][chosen], self.lengths[chosen])
                e *= w
                prior = 1.0 / self.priors[c][chosen]
                top = np.add.reduceat(e * w, edges, axis=1)
                bottom = np.add.reduceat(w * w, edges) + prior**2
                offset = top / bottom
                e -= np.repeat(offset, self.lengths[chosen], axis=1) * w
                extra.append(offset * prior)
            else:
                e *= w
            rows.append(e)
        return np.concatenate(rows + extra, axis=1)

    def whitened(
        self, dx: NDArray[np.float64], dv: NDArray[np.float64], size: int
    ) -> NDArray[np.float64]:
        """Bring changes of x and v into the form of whitened residuals."""
        picked = np.concatenate(
            [np.arange(self.starts_at[r], self.starts_at[r + 1]) for r in self.fitted]
        )
        edges = np.concatenate([[0], np.cumsum(self.lengths[self.fitted])])[:-1]
        rows, extra = [], []
        for c in self.channels:
            w = self.weights[c][picked] * self.seen[picked]
            change = {"x": dx, "v": dv}.get(c, np.zeros_like(dx)) * w
            if self.has_offset(c):
                prior = 1.0 / self.priors[c][self.fitted]
                bottom = np.add.reduceat(w * w, edges) + prior**2
                offset = np.add.reduceat(change * w, edges, axis=1) / bottom
                change = change - np.repeat(offset, self.lengths[self.fitted], axis=1) * w
                extra.append(offset * prior)
            rows.append(change)
        full = np.concatenate(rows + extra, axis=1)
        return np.pad(full, ((0, 0), (0, size - full.shape[1])))

    def of_run(self, run: int, chosen: Sequence[int]) -> NDArray[np.intp]:
        """Return where the residuals of one run lie among those of several."""
        chosen = list(chosen)
        place = chosen.index(run)
        lengths = self.lengths[chosen]
        first, samples = int(lengths[:place].sum()), int(lengths.sum())
        count = int(self.lengths[run])
        own = [np.arange(c * samples + first, c * samples + first + count)
               for c in range(len(self.channels))]  # fmt: skip
        offsets = [c for c in self.channels if self.has_offset(c)]
        base = len(self.channels) * samples
        own += [np.array([base + k * len(chosen) + place]) for k in range(len(offsets))]
        return np.concatenate(own)

    def unseen(self, points: Sequence[Point]) -> NDArray[np.float64]:
        """Return whitened residuals of what fits do not see, in the form of `residuals`.

        Start offsets of runs of their own are refitted; behind `train_fraction` they stay
        those of the fit.
        """
        if self.train_fraction < 1.0:
            found = self.replay(points, range(len(self.runs)))
            edges = self.starts_at[:-1]
            rows = []
            for c in self.channels:
                w = self.weights[c]
                e = (np.where(w > 0.0, self.measured[c], 0.0) - found[c]) * w
                if self.has_offset(c):
                    if CHANNELS[c].from_rest:
                        e -= np.repeat(self.rest_levels[c], self.lengths) * w
                    wf = w * self.seen
                    bottom = np.add.reduceat(wf * wf, edges) + self.priors[c] ** -2.0
                    offset = np.add.reduceat(e * wf, edges, axis=1) / bottom
                    e -= np.repeat(offset, self.lengths, axis=1) * w
                rows.append(np.where(self.seen, 0.0, e))
            return np.concatenate(rows, axis=1)
        if not self.held:
            return np.zeros((len(points), 0))
        e = self.residuals(points, self.held)
        kinds = []
        if self.position_matters:
            kinds.append(("start_offsets", self.priors["x"]))
        if any(r in self.starts.moving for r in self.held):
            free = np.isin(np.arange(len(self.runs)), self.starts.moving)
            kinds.append(("speeds", np.where(free, 1e30, 1e-30)))
        return self._started(points, e, kinds) if kinds else e

    def _started(
        self,
        points: Sequence[Point],
        e: NDArray[np.float64],
        kinds: list[tuple[str, NDArray[np.float64]]],
    ) -> NDArray[np.float64]:
        """Fit how runs start, to first order, and take that out of their residuals."""
        columns = []
        for kind, spread in kinds:
            step = np.where(spread < 1e20, 0.1 * spread, 1e-4 * self.speed_scale)
            step = np.maximum(step, 1e-12)
            moved = [replace(p, **{kind: getattr(p, kind) + step}) for p in points]
            columns.append((self.residuals(moved, self.held) - e, step, spread))
        for r in self.held:
            own = self.of_run(r, self.held)
            jacobian = np.stack([c[:, own] / step[r] for c, step, _ in columns], axis=1)
            prior = np.diag([min(s[r] ** -2.0, 1e60) for _, _, s in columns])
            normal = jacobian @ jacobian.transpose(0, 2, 1) + prior
            gradient = jacobian @ e[:, own, None]
            shift = np.linalg.solve(normal, gradient)
            e[:, own] -= (jacobian.transpose(0, 2, 1) @ shift)[:, :, 0]
        return e

    def degrees(self) -> int:
        """Count the residuals that fits see."""
        seen = self.seen & ~np.isin(np.repeat(np.arange(len(self.runs)), self.lengths), self.held)
        return int(sum(((w > 0.0) & seen).sum() for w in self.weights.values()))


def _at_start(run: Run, channel: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the readings of a channel before the drive first changes, and all of them."""
    y = run.channels.get(channel, np.full(run.t.size, np.nan))
    changes = np.flatnonzero(run.drive != run.drive[0])
    still = int(changes[0]) + 1 if changes.size and run.drive[0] == 0.0 else 1
    return y[:still][np.isfinite(y[:still])], y[np.isfinite(y)]
