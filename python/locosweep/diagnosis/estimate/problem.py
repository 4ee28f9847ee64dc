"""Measured runs against a model: batches of replays as whitened residuals."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core
from locosweep.diagnosis.data.noise import Noise, noise_of, weights_of
from locosweep.diagnosis.data.regimes import measured_motion, misfit_of_speed
from locosweep.diagnosis.estimate.drive_gaps import GapShifts, gap_shifts
from locosweep.files.channels import CHANNELS, OFFSETS, PREDICTED, REPLAYED
from locosweep.simulation.replay import effect, motor_of, nominal_of, sensor_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.regimes import MeasuredMotion
    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

Shift = list[tuple[int, "Floats"]]
"""Something that differs from run to run within a deviation: channels that it acts on, by
number, and what a deviation of it changes in their weighted readings."""
LOST = 1e60
"""Reading of a model that cannot be replayed to the end: far from everything."""
_MOST_SHIFTS = 16
"""Shifts of a start and of drives that were missed, at most: the time of a fit grows with them. Not
derived."""
_ANYWHERE = 10.0
"""Deviation of a start that was not measured, in spans of its run."""


@dataclass(frozen=True)
class Point:
    """A model to replay: effects, the parameters of all effects, and nuisances."""

    names: tuple[str, ...]
    values: Floats
    factors: Floats
    """Factors on mass, Coulomb level and gain, and the clock offset in s."""
    speeds: Floats
    """Start speed of each run."""
    start_offsets: Floats
    """Shift of each run's start position, where the motion depends on it."""


@dataclass(frozen=True)
class InitialStates:
    """State in which every run begins, and which runs begin in motion."""

    position: Floats
    """Position of the head at the first sample of each run, m."""
    speed: Floats
    """Its speed there, m/s."""
    moving: tuple[int, ...] = ()
    """Runs that begin in motion."""


def work_of(names: Sequence[str]) -> float:
    """Return the work of a replay with such effects, in replays of the nominal model."""
    return prod(effect(name).work for name in names)


@dataclass
class ReplayMeter:
    """Count of the samples replayed so far, and their work in samples of the nominal model."""

    samples: int = 0
    work: float = 0.0

    def count(self, names: Sequence[Sequence[str]], samples: int) -> None:
        """Count samples of models with such effects, of each as many."""
        self.samples += samples * len(names)
        self.work += samples * sum(map(work_of, names))


@dataclass(frozen=True, eq=False)
class Problem:
    """Runs, noise and weights; residuals of models in units of their noise.

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
    """States in which runs begin, if not as they were measured."""
    speed_scale: float = 1.0
    """A large speed of this rig, m/s."""
    meter: ReplayMeter = field(default_factory=ReplayMeter, repr=False)
    """Counter of replays; it takes part in no result."""
    wider: tuple[float, ...] = ()
    """Factors on the deviations of single runs, if what models leave differs from run to run."""
    known_shifts: Sequence[Shift] | None = None
    """Start shifts, if they are known, in deviations: factors on those count for priors, too."""
    rest: Sequence[Shift] = ()
    """Parts of a force that no effect stands for, which models may leave."""

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
        sensor = sensor_of(self.robot)
        known = self.known or {}
        found = {c: known.get(c) or noise_of(c, self.runs, sensor) for c in self.channels}
        if "v" in found and "v" not in known and not found["v"].stated:
            found["v"] = self._noise_of_speed(found["v"], found["x"])
        return found

    def _noise_of_speed(self, seen: Noise, position: Noise) -> Noise:
        """Return the noise of a measured speed: filters make it smooth, and wrong.

        Where no file states it, it is at least as far off as from the slope of the position.
        """
        parts = [misfit_of_speed(run, position) for run in self.runs]
        off = np.concatenate(parts)
        sd = float(np.sqrt(np.mean(off**2))) if off.size else 0.0
        return replace(seen, sd=sd, gaussian=sd) if sd > seen.sd else seen

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
        slope = self.nominal["slope_deg"]
        data = [
            (run.since_start, run.drive, slope if run.slope_deg is None else run.slope_deg)
            for run in self._driven
        ]
        return _core.Replay({**self.nominal}, data)

    @property
    def _driven(self) -> Sequence[Run]:
        return self.runs

    @cached_property
    def starts(self) -> InitialStates:
        """State in which every run begins."""
        if self.initial is not None:
            return self.initial
        measured = np.array([run.start for run in self.runs])
        return InitialStates(measured[:, 0], measured[:, 1])

    @property
    def initial_or_none(self) -> InitialStates | None:
        """States in which runs begin, for another problem of the same runs."""
        return self.starts

    @cached_property
    def of_all_runs(self) -> Problem:
        """The problem of all runs, none kept from fits; its replays do not count."""
        return replace(self, held=(), initial=self.starts, meter=ReplayMeter())

    def of_all_samples(self) -> Problem:
        """Return the problem of the same runs in which every sample counts, without a rest."""
        return replace(
            self,
            train_fraction=1.0,
            rest=(),
            known_shifts=None,
            wider=(),
            initial=self.initial_or_none,
        )

    @cached_property
    def measured(self) -> dict[str, Floats]:
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
    def weights(self) -> dict[str, Floats]:
        """Inverse deviation of every sample, 0 where it does not count."""
        rest = self.gap_shifts.variance
        wider = self.widening
        return {c: w / (np.sqrt(1.0 + rest[c]) * wider) for c, w in self._noise_weights.items()}

    @property
    def widening(self) -> Floats:
        """Factor on the deviation of every sample."""
        factors = np.array(self.wider) if self.wider else np.ones(len(self.runs))
        found: Floats = np.repeat(factors, self.lengths)
        return found

    @cached_property
    def _noise_weights(self) -> dict[str, Floats]:
        """Inverse deviation of the sensor's noise at every sample, 0 where it does not count."""
        found = {c: weights_of(y, self.noise[c], self.starts_at) for c, y in self.measured.items()}
        for c, own in self.noise.items():
            if own.late > 0.0:
                speeds = np.concatenate([motion.v for motion in self.motions])
                found[c] = found[c] * own.sd / np.hypot(own.sd, own.late * speeds)
        return found

    @cached_property
    def gap_shifts(self) -> GapShifts:
        """What rows that miss may have changed of each run."""
        return gap_shifts(self, self._noise_weights, _MOST_SHIFTS - self._start_kinds)

    def shifts_of(self, errors: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return start offsets and what rows that miss changed, as whitened errors ask for them."""
        offsets = {
            c: self._noise_weights[c] * np.repeat(self.priors[c], self.lengths)
            for c in self.channels
            if self.has_offset(c)
        }
        return self.gap_shifts.of(errors, offsets)

    @property
    def _start_kinds(self) -> int:
        """Number of shifts that a start has."""
        return sum(map(self.has_offset, self.channels))

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """Samples that fits see, of runs that are not held out."""
        position = np.concatenate([np.arange(n) / n for n in self.lengths])
        return np.asarray(position < self.train_fraction)

    @cached_property
    def fitted(self) -> list[int]:
        """Runs that take part in fits."""
        return [r for r in range(len(self.runs)) if r not in self.held]

    @cached_property
    def priors(self) -> dict[str, Floats]:
        """Deviation of the start offset of each run, by channel that has offsets."""
        return {c: self._offset_deviations(c) for c in OFFSETS if c in self.channels}

    @cached_property
    def start_levels(self) -> dict[str, Floats]:
        """Reading of each run before its drive first changes, by channel that has offsets."""
        channels = [c for c in OFFSETS if c in self.channels]
        return {c: np.array([run.at_start(c)[0] for run in self.runs]) for c in channels}

    def _offset_deviations(self, channel: str) -> Floats:
        noise = self.noise[channel]
        # The deviation of one sample: a bristle may give way while the drive rests.
        own = float(np.hypot(noise.sd, noise.stuck))
        starts = [run.at_start(channel) for run in self.runs]
        # A start that was not measured before the drive changes is anywhere.
        return np.array([own if known else own + _ANYWHERE * span for _, known, span in starts])

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
        """True if the motion depends on the start position: that of a pendulum."""
        return "gravity_torque" in self.nominal

    @property
    def starts_vary(self) -> bool:
        """True if runs may begin in motion, so that start speeds are found first."""
        return True

    def has_offset(self, channel: str) -> bool:
        """Return whether a channel has a start offset that is projected out."""
        return channel in self.priors and not (channel == "x" and self.position_matters)

    def parameter_index(self, name: str, parameter: str) -> int:
        """Return the index of a parameter among those of all effects."""
        record = effect(name)
        return record.first + [p.name for p in record.parameters].index(parameter)

    def chosen(self, runs: Sequence[int] | None) -> tuple[int, ...]:
        """Return the runs that count: `runs`, or those that are fitted."""
        return tuple(self.fitted if runs is None else map(int, runs))

    def samples_of(self, runs: Sequence[int]) -> int:
        """Count the samples of some runs."""
        return int(self.lengths[list(runs)].sum())

    @cached_property
    def experiment(self) -> _core.Experiment:
        """The runs as the core replays them."""
        spans = [
            (*self._span(r), self.payload_factors.get(r, 1.0), r in self.reversed_runs)
            for r in range(len(self.runs))
        ]
        return _core.Experiment(self.job, spans, self._begins, self.motor)

    @cached_property
    def misfit(self) -> _core.Misfit:
        """What was measured, as the core compares models with it."""
        channels = []
        for c in self.channels:
            y = self.measured[c]
            if CHANNELS[c].from_rest:
                y = y - np.repeat(self.start_levels[c], self.lengths)
            channels.append((CHANNELS[c].replayed, y, self._fit_weights(c)))
        return _core.Misfit(self.experiment, channels, [*self.start_shifts, *self.rest])

    @property
    def _begins(self) -> Floats:
        """Position and speed at the start of each run."""
        return np.stack([self.starts.position, self.starts.speed], axis=1)

    @cached_property
    def start_shifts(self) -> Sequence[Shift]:
        """What may differ in how runs start, a deviation of each."""
        return self._found_shifts() if self.known_shifts is None else self.known_shifts

    def _found_shifts(self) -> list[Shift]:
        """Return the shifts of start offsets, and of drives that were missed."""
        offsets = [
            [(i, self._fit_weights(c) * np.repeat(self.priors[c], self.lengths))]
            for i, c in enumerate(self.channels)
            if self.has_offset(c)
        ]
        return offsets + self.gap_shifts.in_core(self.channels, self.seen)

    def driven_by(self, drives: Sequence[Floats]) -> Problem:
        """Return the problem with other drive columns, a row a run."""
        pairs = zip(self.runs, drives, strict=True)
        return replace(self, runs=[replace(run, drive=drive) for run, drive in pairs])

    def _span(self, run: int) -> tuple[int, int, int]:
        """Return what is replayed: the engine's run, first sample, one beyond the last."""
        return run, 0, int(self.lengths[run])

    def replay(
        self,
        points: Sequence[Point],
        runs: Sequence[int] | None = None,
        moved: Floats | None = None,
    ) -> dict[str, Floats]:
        """Return what the sensors would read, per channel, a row a point.

        With `runs`, only those runs are replayed, one after another; `moved` shifts position
        and speed at the start of each run of the problem, shape (runs, 2).
        """
        chosen = list(range(len(self.runs)) if runs is None else map(int, runs))
        self.meter.count([point.names for point in points], self.samples_of(chosen))
        read = self.experiment.read(list(points), chosen, self.threads, moved)
        found = {c: one.reshape(len(points), -1) for c, one in zip(REPLAYED, read, strict=True)}
        if self.motor and "power" in self.channels:
            force, speed = read[REPLAYED.index("force")], read[REPLAYED.index("v")]
            # A force that was given had the voltage that it needs.
            motor = (np.inf, *self.motor)
            found["power"] = _core.motor_power(force, speed, motor).reshape(len(points), -1)
        wrong = ~np.isfinite(found["x"]).all(axis=1)
        for reading in found.values():
            reading[wrong] = LOST
        return found

    def residuals(
        self, points: Sequence[Point], runs: Sequence[int] | None = None, most: float = np.inf
    ) -> Floats:
        """Return whitened residuals of the runs that are fitted, or of `runs`.

        A row a point: channel by channel, run by run, and last the start offsets in
        units of their uncertainty, at most `most` of them. Samples behind `train_fraction`
        are 0.
        """
        chosen = self.chosen(runs)
        self.meter.count([point.names for point in points], self.samples_of(chosen))
        found: Floats = self.misfit.residuals(list(points), chosen, self.threads, most)
        return found

    def _fit_weights(self, channel: str) -> Floats:
        weights: Floats = self.weights[channel] * self.seen
        return weights

    def of_run(self, run: int, chosen: Sequence[int]) -> NDArray[np.intp]:
        """Return where the residuals of one run lie among those of several."""
        chosen = list(chosen)
        rank = chosen.index(run)
        lengths = self.lengths[chosen]
        first, samples = int(lengths[:rank].sum()), int(lengths.sum())
        count = int(self.lengths[run])
        own = [np.arange(c * samples + first, c * samples + first + count)
               for c in range(len(self.channels))]  # fmt: skip
        base = len(self.channels) * samples
        shifts = len(self.start_shifts) + len(self.rest)
        own += [np.array([base + k * len(chosen) + rank]) for k in range(shifts)]
        return np.concatenate(own)

    def record_of(self, run: int) -> int:
        """Return the measured run that a run of the problem is a part of: itself."""
        return run

    @cached_property
    def _without_rest(self) -> Problem:
        return replace(self, rest=(), wider=())

    def position_errors(self, points: Sequence[Point], runs: Sequence[int]) -> Floats:
        """Return measured minus simulated positions of some runs, a row a point.

        Starts are shifted within the sensors' noise, at most by its deviation, whatever the factors
        on deviations. NaN where nothing was measured or counts.
        """
        whole = self._without_rest if self.rest or self.wider else self
        e = whole.residuals(points, runs, most=1.0)
        samples, rank = self.samples_of(runs), self.channels.index("x")
        ends = np.cumsum(self.lengths)
        picked = np.concatenate([np.arange(ends[r] - self.lengths[r], ends[r]) for r in runs])
        w = (whole.weights["x"] * self.seen)[picked]
        own = e[:, rank * samples : (rank + 1) * samples]
        found: Floats = np.where(w > 0.0, own / np.where(w > 0.0, w, 1.0), np.nan)
        return found

    def degrees(self, runs: Sequence[int] | None = None) -> int:
        """Count the residuals of `runs` that fits see, or of those that are fitted."""
        of_run = np.repeat(np.arange(len(self.runs)), self.lengths)
        seen = self.seen & np.isin(of_run, self.chosen(runs))
        return int(sum(((w > 0.0) & seen).sum() for w in self.weights.values()))
