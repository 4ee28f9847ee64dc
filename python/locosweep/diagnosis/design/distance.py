"""Pairwise model-discrimination (T-optimality) distances between effects, in sigmas.

Signals are what an effect changes in the readings, in units of their noise, with
each run's start offset and start velocity projected out. The distance from one
effect to a rival is what is left of its signal after the rival is refitted, from
several starts and with both signs.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core
from locosweep.diagnosis.effects.catalogue import families
from locosweep.diagnosis.effects.scale import Scale, level_of
from locosweep.files.channels import OFFSETS, REPLAYED
from locosweep.simulation.replay import effect_values, nominal_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.effects.catalogue import Family
    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

_BATCH = 3_000_000
"""Samples of one call: some 100 MB of readings."""

_NUDGE = 0.05
"""Start velocity over the largest one, for its direction."""

_GRID = 28
_STEPS = 8
_FALL = 0.02
_DAMPINGS = (0.1, 10.0)


def project(rows: Floats, directions: Floats) -> Floats:
    """Take orthonormal directions, shape (k, samples), out of rows, shape (n, samples)."""
    left: Floats = rows - (rows @ directions.T) @ directions
    return left


class PlannedRuns:
    """Runs of a drive with the noise of their sensors: effects in, signals out.

    `noise` gives the standard deviation of every channel that is measured (x, v, x_rear,
    force); measured values of the runs are not looked at.
    """

    def __init__(
        self, robot: Robot, runs: Sequence[Run], noise: Mapping[str, float], threads: int = 1
    ) -> None:
        self.robot = robot
        self.nominal = nominal_of(robot)
        self.noise = {name: noise[name] for name in REPLAYED if name in noise}
        self.threads = threads
        slope = self.nominal["slope_deg"]
        self.runs = [
            (run.since_start, run.drive, slope if run.slope_deg is None else run.slope_deg)
            for run in runs
        ]
        self.starts = np.array([run.start for run in runs])
        self._replay = _core.Replay({**self.nominal}, self.runs)
        self.lengths = np.array(self._replay.lengths)
        self.samples = int(self.lengths.sum())
        nothing = [((), np.zeros(_core.effect_parameter_count()))]
        self._origin = np.zeros((1, self.samples * len(self.noise)))
        self.readings = self._read(nothing, self.starts, REPLAYED)
        self._origin = self._whitened(self.readings)
        self.scale = self._scale()
        self.directions = self._starting()

    @property
    def families(self) -> dict[str, Family]:
        """Families of all effects at this rig's sizes."""
        return families(self.scale)

    def signals(self, models: Sequence[tuple[str, Mapping[str, float]]]) -> Floats:
        """Return what effects change in the readings, a row a model, projected.

        A model that cannot be replayed to finite numbers has a row of infinities.
        """
        limit = max(1, _BATCH // self.samples)
        rows = [((name,), effect_values({name: dict(values)})) for name, values in models]
        parts = []
        for i in range(0, len(rows), limit):
            found = self._changes(rows[i : i + limit], self.starts)
            wrong = ~np.isfinite(found).all(axis=1)
            found[wrong] = 0.0
            found = project(found, self.directions)
            found[wrong] = np.inf
            parts.append(found)
        return np.concatenate(parts)

    def _read(
        self,
        models: Sequence[tuple[Sequence[str], Floats]],
        starts: Floats,
        channels: Sequence[str],
    ) -> dict[str, Floats]:
        count = len(self.runs)
        columns = [(r, 0, int(self.lengths[r]), list(n)) for n, _ in models for r in range(count)]
        values = np.repeat(np.array([row for _, row in models]), count, axis=0)
        factors = np.tile([1.0, 1.0, 1.0, 0.0], (len(columns), 1))
        begin = np.tile(starts, (len(models), 1))
        rows = [REPLAYED.index(name) for name in channels]
        found = self._replay.run(columns, values, factors, begin, self.threads, channels=rows)
        return {
            name: field.reshape(len(models), -1)
            for name, field in zip(channels, found, strict=True)
        }

    def _changes(self, models: Sequence[tuple[Sequence[str], Floats]], starts: Floats) -> Floats:
        return self._whitened(self._read(models, starts, list(self.noise))) - self._origin

    def _whitened(self, readings: Mapping[str, Floats]) -> Floats:
        return np.concatenate([readings[c] / sd for c, sd in self.noise.items()], axis=1)

    def _scale(self) -> Scale:
        nominal, tiny = self.nominal, 1e-12
        weight = nominal["mass"] * nominal["gravity"]
        flat = weight * float(np.cos(np.radians(nominal["slope_deg"])))
        force = max(float(np.abs(self.readings["force"]).max(initial=0.0)), tiny)
        x = np.split(self.readings["x"][0], np.cumsum(self.lengths)[:-1])
        seconds = max(float(t[-1] - t[0]) for t, _, _ in self.runs)
        nominal_level = level_of(nominal)
        level = max(nominal_level, 1e-3 * force)
        return Scale(
            mass=nominal["mass"],
            nominal_level=nominal_level,
            level=level,
            least_level=level,
            force=force,
            peak=force,
            weight=max(weight, tiny),
            grip=max((nominal["segments"] - 1.0) * flat, tiny),
            speed=max(float(np.abs(self.readings["v"]).max(initial=0.0)), tiny),
            travel=max(*(float(np.ptp(one)) for one in x), tiny),
            duration=seconds,
            interval=float(np.median([np.median(np.diff(t)) for t, _, _ in self.runs])),
            viscous=nominal["viscous"],
            has_force_level="coulomb_force" in nominal,
            rotary="gravity_torque" in nominal,
            replayed=seconds,
        )

    def _starting(self) -> Floats:
        """Directions in which a run's start offset and start velocity move its readings."""
        edges = np.concatenate([[0], np.cumsum(self.lengths)])
        found = []
        for channel, name in enumerate(self.noise):
            if name not in OFFSETS:
                continue
            for a, b in pairwise(edges):
                row = np.zeros(self._origin.shape[1])
                row[channel * self.samples + a : channel * self.samples + b] = (b - a) ** -0.5
                found.append(row)
        offsets = np.array(found).reshape(-1, self._origin.shape[1])
        nothing = np.zeros(_core.effect_parameter_count())
        for r, (a, b) in enumerate(pairwise(edges)):
            nudged = self.starts.copy()
            nudged[r, 1] += _NUDGE * self.scale.speed
            moved = self._changes([((), nothing)], nudged)
            # Other runs start as before.
            own = np.zeros(self.samples, dtype=bool)
            own[a:b] = True
            moved = project(np.where(np.tile(own, len(self.noise)), moved, 0.0), offsets)
            size = float(np.linalg.norm(moved))
            if np.isfinite(size) and size > 1e-6:
                found.append(moved[0] / size)
        return np.array(found).reshape(-1, self._origin.shape[1])


def _sizes(rows: Floats) -> Floats:
    sizes: Floats = np.sqrt(np.einsum("ij,ij->i", rows, rows))
    return sizes


def strengths(
    plan: PlannedRuns, asked: Sequence[tuple[Family, float]], size: float
) -> list[Floats | None]:
    """Find how strong each effect, given with a sign, must be for a signal of `size` sigmas.

    Returns the coordinates of its family, strength first; None where no strength that the rig
    allows gives that signal.
    """
    first = []
    for family, _ in asked:
        shapes = family.starts()
        middle = zip(family.shapes, shapes[len(shapes) // 2], strict=True)
        first.append(np.array([0.0, *(shape.coordinate(value) for shape, value in middle)]))
    low = np.array([family.least for family, _ in asked])
    high = np.array([f.high if sign > 0.0 else -f.low for f, sign in asked])
    gone = np.zeros(len(asked), dtype=bool)
    for grid in (_GRID, 8, 8):
        models = []
        ladders = np.geomspace(low, np.maximum(high, low * 1.0001), grid, axis=1)
        for (family, sign), theta, ladder in zip(asked, first, ladders, strict=True):
            for u in ladder:
                models.append((family.name, family.parameters(np.array([sign * u, *theta[1:]]))))
        found = _in_parts(plan, models).reshape(len(asked), grid)
        above = found >= size
        gone |= ~above.any(axis=1)
        rung = np.where(above.any(axis=1), above.argmax(axis=1), 1)
        rows = np.arange(len(asked))
        low, high = ladders[rows, np.maximum(rung - 1, 0)], ladders[rows, rung]
    return [
        None if none else np.array([sign * u, *theta[1:]])
        for none, (_, sign), theta, u in zip(gone, asked, first, high, strict=True)
    ]


def _in_parts(plan: PlannedRuns, models: Sequence[tuple[str, Mapping[str, float]]]) -> Floats:
    """Return the lengths of signals, without keeping all of the signals."""
    limit = max(1, _BATCH // plan.samples)
    return np.concatenate(
        [_sizes(plan.signals(models[i : i + limit])) for i in range(0, len(models), limit)]
    )


@dataclass
class _State:
    """A fit in progress: its target, coordinates and residual."""

    target: int
    theta: Floats
    left: Floats
    cost: float
    damping: float = 1e-2
    done: bool = False


def refit(
    plan: PlannedRuns, family: Family, targets: Floats, reference: float, *, starts: int = 2
) -> tuple[Floats, list[Floats]]:
    """Fit one effect to signals, and return how much of each is left.

    Parameters
    ----------
    plan, family : PlannedRuns, Family
        The runs, and the effect that is fitted.
    targets : ndarray
        Signals, shape (n, samples of all channels).
    reference : float
        Strength at which the effect's own signal has about their size.
    starts : int
        Fits of each signal, from its best starts.

    Returns
    -------
    distances : ndarray
        Length of what is left, shape (n,); at most that of the signal.
    coordinates : list of ndarray
        Of the best fits, strength first; strength 0 where none is better than nothing.
    """
    states = _begin(plan, family, targets, abs(reference), starts)
    step = np.array([0.02 * abs(reference), *(s.step for s in family.shapes)])
    for _ in range(_STEPS):
        todo = [state for state in states if not state.done]
        if not todo:
            break
        _advance(plan, family, targets, todo, step)
    distances = _sizes(targets)
    best = [np.array([0.0, *(s.coordinate(s.starts[0]) for s in family.shapes)]) for _ in targets]
    for state in states:
        left = np.sqrt(state.cost)
        if left < distances[state.target]:
            distances[state.target] = left
            best[state.target] = state.theta
    return distances, best


def _begin(
    plan: PlannedRuns, family: Family, targets: Floats, reference: float, starts: int
) -> list[_State]:
    """Start where the effect's signal, stretched to fit, leaves least of a target."""
    thetas = []
    for shape in family.starts():
        rest = [s.coordinate(v) for s, v in zip(family.shapes, shape, strict=True)]
        for sign in family.signs:
            for factor in (0.3, 1.0, 3.0):
                thetas.append(np.array([sign * factor * reference, *rest]))
    signals = plan.signals([(family.name, family.parameters(theta)) for theta in thetas])
    usable = np.isfinite(signals[:, 0]) & (_sizes(np.nan_to_num(signals, posinf=0.0)) > 1e-6)
    thetas = [theta for theta, use in zip(thetas, usable, strict=True) if use]
    signals = signals[usable]
    if not thetas:
        return []
    along = targets @ signals.T
    lengths = np.einsum("ij,ij->i", signals, signals)
    # Only forward: the other sign has starts of its own.
    stretch = np.clip(along / lengths, 0.0, 10.0)
    left = np.einsum("ij,ij->i", targets, targets)[:, None] - 2 * stretch * along
    left += stretch**2 * lengths
    states = []
    for target in range(len(targets)):
        for start in np.argsort(left[target], kind="stable")[:starts]:
            theta = thetas[start].copy()
            theta[0] *= stretch[target, start]
            if abs(theta[0]) >= family.least:
                states.append(_State(target, theta, np.empty(0), np.inf))
    if states:
        found = plan.signals([(family.name, family.parameters(s.theta)) for s in states])
        for state, signal in zip(states, found, strict=True):
            state.left = signal - targets[state.target]
            state.cost = float(state.left @ state.left)
    return [state for state in states if np.isfinite(state.cost)]


def _advance(
    plan: PlannedRuns, family: Family, targets: Floats, todo: Sequence[_State], step: Floats
) -> None:
    """Make one step of Levenberg and Marquardt in every fit."""
    limit = max(1, _BATCH // (plan.samples * (len(step) + len(_DAMPINGS))))
    for i in range(0, len(todo), limit):
        some = todo[i : i + limit]
        # Inwards where a bound is near, or the difference would be none.
        moves = [np.where(s.theta + step <= family.high, step, -step) for s in some]
        models = [
            (family.name, family.parameters(s.theta + np.where(np.arange(step.size) == k, move, 0)))
            for s, move in zip(some, moves, strict=True)
            for k in range(step.size)
        ]
        moved = plan.signals(models).reshape(len(some), step.size, -1)
        trials = []
        for state, move, rows in zip(some, moves, moved, strict=True):
            now = state.left + targets[state.target]
            slope = np.nan_to_num((rows - now) / move[:, None], posinf=0.0, neginf=0.0)
            normal, gradient = slope @ slope.T, slope @ state.left
            floor = 1e-12 * max(float(np.trace(normal)), 1e-300)
            for factor in _DAMPINGS:
                damped = normal + np.diag(state.damping * factor * np.diag(normal) + floor)
                theta = state.theta - np.linalg.solve(damped, gradient)
                theta[0] = np.clip(theta[0], family.low, family.high)
                trials.append((state, factor, theta))
        found = plan.signals([(family.name, family.parameters(theta)) for _, _, theta in trials])
        before = {id(state): state.cost for state in some}
        for (state, factor, theta), signal in zip(trials, found, strict=True):
            left = signal - targets[state.target]
            cost = float(left @ left)
            if cost < state.cost:
                state.theta, state.left, state.cost = theta, left, cost
                state.damping = max(state.damping * factor, 1e-9)
        for state in some:
            fall = before[id(state)] - state.cost
            if fall <= 0.0:
                state.damping *= 100.0
            state.done = state.damping > 1e6 or 0.0 < fall < _FALL + 1e-3 * state.cost
