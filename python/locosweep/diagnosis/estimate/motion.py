"""Basis functions of any law in one variable along a motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import VARIABLES
from locosweep.diagnosis.estimate.least_squares import point_of
from locosweep.diagnosis.estimate.slides import Slides
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

_KNOTS = 9
"""Knots of laws that bend slowly, at quantiles of their variable."""
_KNOTS_BENT = 13
"""Knots of laws that bend sharply: limits, dead zones, scales. With 25, two of the sets of runs
without a gap of `locosweep blind-check --cases 300 --gap-free 300 --seed 2029` (free 194, case 297)
were said to have one: rounding of readings goes by the place. With 13, they are not."""
_KNOTS_ALONG = 25
"""Knots of what depends on the place: it may change within a small part of the travel. Friction and
a force that is none have as many, or the one that bends would win. With 9 of a force, `locosweep
blind-check --only outside --cases 150 --seed 11112` named four causes more that are not there, and
`--only another-law --cases 150 --seed 11213` one that is."""
_CHANGES = 160
"""Changes of the drive, the largest of all runs, that may be late each for itself. Set on nine
drives that are read once a period, drawn as `locosweep blind-check --only another-law` draws them:
with 40, three still leave more than noise, with 160 one. No command draws such drives alone; more
changes cost computing time."""
_LAGS = 8
"""Times that a drive is looked back, evenly in their logarithm."""
_LONGEST = 0.08
"""Longest time that a drive is looked back, in the longest run's."""


@dataclass(frozen=True)
class Motion:
    """A fitted motion at the samples of the fitted runs."""

    t: Floats
    x: Floats
    v: Floats
    force: Floats
    drive: Floats
    run: NDArray[np.intp]
    swept: Floats
    turned: Floats
    mass: float
    damping: float
    keeps: Floats
    """Share of a change of speed that is left at the next sample, 1 but where the head turns."""
    stiffness: Floats
    """With which gravity pulls a pendulum back, N m/rad; 0 of others."""

    @property
    def slides(self) -> Slides:
        """The motion that small forces change."""
        step = np.diff(self.t, append=self.t[-1:])
        last = np.diff(self.run, append=self.run[-1:] + 1) != 0
        return Slides(self.v, step, last, self.mass, self.damping, self.keeps, self.stiffness)


ALL = (*dict.fromkeys((*VARIABLES.values(), "terrain")), "acceleration")
"""Variables of effects, and of forces that no effect stands for."""


def motion_of(problem: Problem, fit: Fit) -> Motion:
    """Replay a fit over the fitted runs."""
    point = point_of(problem, fit)
    found = problem.replay([point], problem.fitted)
    runs = [problem.runs[r] for r in problem.fitted]
    number = np.repeat(np.arange(len(runs)), [run.t.size for run in runs])
    x, v = found["x"][0], found["v"][0]
    # The head itself, where its readings err.
    sensors = [name for name in point.names if effect(name).site == "sensor"]
    names = tuple(name for name in point.names if name not in sensors)
    bare = replace(point, names=names)
    head = problem.replay([bare], problem.fitted)["x"][0] if sensors else x
    begins = np.diff(number, prepend=-1) != 0
    slid = np.array([run.sliding_distance for run in runs])[number] * (begins & (v > 0.0))
    swept = np.where(v > 0.0, _way_since((v <= 0.0) | begins, x, slid), 0.0)
    turned = _way_since(begins | (v * np.roll(v, 1) <= 0.0), x)
    dm = point.values[problem.parameter_index("payload_mass", "dm")]
    dm = dm if "payload_mass" in point.names else 0.0
    c = problem.nominal["viscous"]
    for name, key in (("viscous_friction", "c"), ("back_emf", "k_e")):
        if name in point.names:
            c += point.values[problem.parameter_index(name, key)]
    return Motion(
        t=np.concatenate([run.since_start for run in runs]),
        x=x,
        v=v,
        force=found["force"][0],
        drive=np.concatenate([run.drive for run in runs]) * problem.nominal["gain"],
        run=number,
        swept=swept,
        turned=turned,
        mass=problem.nominal["mass"] * point.factors[0] + dm,
        damping=max(c, 0.0),
        keeps=_keeps(problem, number, v, head),
        stiffness=problem.nominal.get("gravity_torque", 0.0) * np.cos(head),
    )


def _way_since(begins: NDArray[np.bool_], x: Floats, already: Floats | float = 0.0) -> Floats:
    """Return the way since the last sample where it begins, with what had been passed by then."""
    since = np.maximum.accumulate(np.where(begins, np.arange(x.size), 0))
    return x - (x - already)[since]


def _keeps(problem: Problem, number: NDArray[np.intp], v: Floats, x: Floats) -> Floats:
    """Return the share of a change of speed that outlasts the time to the next sample.

    A head that turns round without a rest does so at another time, and keeps the ratio of the
    accelerations behind and before (Corner, Sandu and Sandu 2019). They follow from way and
    speeds, each constant up to the turn and from there on.
    """
    t = np.concatenate([problem.runs[r].since_start for r in problem.fitted])
    keeps = np.ones(v.size)
    turns = np.flatnonzero((v[:-1] * v[1:] < 0.0) & (np.diff(number) == 0))
    before, after, step = v[turns], v[turns + 1], np.diff(t)[turns]
    until = (2.0 * np.diff(x)[turns] - after * step) / (before - after)
    until = np.clip(until, 1e-6 * step, (1.0 - 1e-6) * step)
    # From next to no speed, the ratio is beyond all numbers.
    with np.errstate(over="ignore"):
        keeps[turns] = np.clip(-after / (step - until) / (before / until), 0.0, 1.0)
    return keeps


@dataclass(frozen=True)
class Regressor:
    """A variable along a motion: a law of it gives a force that is its height times a factor."""

    values: Floats
    where: NDArray[np.bool_]
    """Samples where it acts."""
    factor: Floats | float
    knots: int = _KNOTS

    def hats(self, edges: Floats | None = None) -> Floats:
        """Return piecewise linear functions on knots, at quantiles of the values that count.

        Nothing where they are too few, or too few values.
        """
        if edges is None:
            if self.where.sum() < 3 * self.knots:
                return np.zeros((0, self.values.size))
            shares = np.linspace(0.0, 1.0, self.knots)
            edges = np.unique(np.quantile(self.values[self.where], shares))
        if edges.size < 3:
            return np.zeros((0, self.values.size))
        below = np.clip(np.searchsorted(edges, self.values, side="right") - 1, 0, edges.size - 2)
        with np.errstate(over="ignore"):
            # A speed that dies away may leave edges nearer to each other than a quotient can say.
            share = np.clip((self.values - edges[below]) / np.diff(edges)[below], 0.0, 1.0)
        found = np.zeros((edges.size, self.values.size))
        sample = np.arange(self.values.size)
        found[below, sample] = (1.0 - share) * self.factor
        found[below + 1, sample] = share * self.factor
        return found


def regressors(variable: str, m: Motion) -> list[Regressor]:
    """Return a variable along a motion, one regressor for each smooth law that it has."""
    moving, every = m.v != 0.0, np.ones(m.v.size, dtype=bool)
    forward, backward = m.v > 0.0, m.v < 0.0
    sign = np.sign(m.v)
    match variable:
        case "speed":
            return [Regressor(m.v, way, way.astype(float)) for way in (forward, backward)]
        case "place":
            return [Regressor(m.x, moving, sign, _KNOTS_ALONG)]
        case "terrain":
            return [Regressor(m.x, moving, 1.0, _KNOTS_ALONG)]
        case "load":
            return [Regressor(np.abs(m.force), moving, sign)]
        case "time":
            return [Regressor(m.t, moving, sign)]
        case "swept":
            return [Regressor(m.swept, forward, forward.astype(float))]
        case "turned":
            return [Regressor(m.turned, way, way.astype(float)) for way in (forward, backward)]
        case "drive":
            return [Regressor(m.drive, moving, 1.0, _KNOTS_BENT)]
        case "sag":
            return [Regressor(m.t, moving, m.drive)]
        case "mass":
            # Drive and weight alike act on a larger mass; drag alone does not grow with it.
            return [Regressor(m.t, moving, (m.damping * m.v - m.force) / m.mass)]
        case "acceleration":
            rate = np.gradient(m.v, m.t + m.run * (m.t.max() + 1.0))
            return [Regressor(rate, moving, 1.0)]
        case "reading":
            return [Regressor(way, moving, 1.0, _KNOTS_BENT) for way in _ways(m)]
        case "clock":
            return [Regressor(m.t, every, 1.0)]
        case "late":
            return [Regressor(m.v, every, 1.0)]
    return []


READINGS = ("reading", "clock", "late")
"""Variables of errors of the reading, not of forces."""


def terms_of(variable: str, m: Motion) -> tuple[list[Floats], bool]:
    """Basis functions along a motion in groups of one smooth law, and whether they are forces."""
    match variable:
        case "change":
            return _changes(m), True
        case "history":
            return _history(m), True
    groups = [one.hats() for one in regressors(variable, m)]
    if variable == "acceleration":
        groups.append(np.sign(m.v)[None, :])
    return groups, variable not in READINGS


def _history(m: Motion) -> list[Floats]:
    """Drives of a while ago less that of now, one law where it rises and one where it falls.

    From half a sample on: a drive is held, so one that acts a part of a sample late is a
    mean of two. A drive may well take longer to switch off than on.
    """
    step = float(np.median(np.diff(m.t)[np.diff(m.run) == 0]))
    longest = _LONGEST * max(float(np.ptp(m.t[m.run == r])) for r in np.unique(m.run))
    rows = []
    for lag in np.geomspace(min(0.5 * step, longest), longest, _LAGS):
        late = np.zeros_like(m.drive)
        for r in np.unique(m.run):
            own = m.run == r
            late[own] = np.interp(m.t[own] - lag, m.t[own], m.drive[own])
        rows.append(late - m.drive)
    changes = np.array(rows)
    rises = np.abs(changes + m.drive) < np.abs(m.drive)
    return [changes * rises, changes * ~rises]


def _changes(m: Motion) -> list[Floats]:
    """Return a law for each change of the drive: the force that one a second later lacks."""
    step = np.diff(m.t, append=m.t[-1:])
    counts = (np.diff(m.run, prepend=-1) == 0) & (step > 0.0)
    change = np.where(counts, np.diff(m.drive, prepend=0.0), 0.0)
    largest = np.sort(np.argsort(-np.abs(change), kind="stable")[:_CHANGES])
    found = []
    for sample in largest[change[largest] != 0.0]:
        row = np.zeros((1, change.size))
        row[0, sample] = -change[sample] / step[sample]
        found.append(row)
    return found


def _ways(m: Motion) -> list[Floats]:
    """Return the way since a run began, as a scale has it, and the place where they differ.

    Knots are where the head moves: at rest it may be in few places for most of the time.
    """
    first = np.flatnonzero(np.diff(m.run, prepend=-1))
    moved = m.x - np.repeat(m.x[first], np.diff(first, append=m.x.size))
    return [moved] if np.ptp(m.x[first]) == 0.0 else [moved, m.x]
