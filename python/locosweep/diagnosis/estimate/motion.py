"""Basis functions of any law in one variable along a motion, and their responses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core
from locosweep.diagnosis.effects.catalogue import VARIABLES
from locosweep.diagnosis.estimate.least_squares import point_of
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
"""Knots of what depends on the place: it may change within a small part of the travel."""
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


ALL = (*dict.fromkeys(VARIABLES.values()), "terrain", "acceleration")
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
    swept, turned = np.zeros_like(x), np.zeros_like(x)
    for i in range(1, x.size):
        if number[i] != number[i - 1]:
            continue
        step = x[i] - x[i - 1]
        swept[i] = swept[i - 1] + step if v[i] > 0.0 else 0.0
        turned[i] = turned[i - 1] + step if v[i] * v[i - 1] > 0.0 else 0.0
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
    keeps[turns] = np.clip(-after / (step - until) / (before / until), 0.0, 1.0)
    return keeps


def _hats(values: Floats, where: NDArray[np.bool_], knots: int = _KNOTS) -> Floats:
    """Piecewise linear functions on knots at quantiles of the values that count."""
    if where.sum() < 3 * knots:
        return np.zeros((0, values.size))
    edges = np.unique(np.quantile(values[where], np.linspace(0.0, 1.0, knots)))
    if edges.size < 3:
        return np.zeros((0, values.size))
    below = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)
    with np.errstate(over="ignore"):
        # A speed that dies away may leave edges nearer to each other than a quotient can say.
        share = np.clip((values - edges[below]) / np.diff(edges)[below], 0.0, 1.0)
    found = np.zeros((edges.size, values.size))
    sample = np.arange(values.size)
    found[below, sample] = 1.0 - share
    found[below + 1, sample] = share
    return found


def terms_of(variable: str, m: Motion) -> tuple[list[Floats], bool]:
    """Basis functions along a motion in groups of one smooth law, and whether they are forces."""
    moving, every = m.v != 0.0, np.ones(m.v.size, dtype=bool)
    forward, backward = m.v > 0.0, m.v < 0.0
    sign = np.sign(m.v)
    match variable:
        case "speed":
            return [_hats(m.v, forward) * forward, _hats(m.v, backward) * backward], True
        case "place":
            return [_hats(m.x, moving, _KNOTS_ALONG) * sign], True
        case "terrain":
            return [_hats(m.x, moving)], True
        case "load":
            return [_hats(np.abs(m.force), moving) * sign], True
        case "time":
            return [_hats(m.t, moving) * sign], True
        case "swept":
            return [_hats(m.swept, forward) * forward], True
        case "turned":
            return [_hats(m.turned, forward) * forward, _hats(m.turned, backward) * backward], True
        case "drive":
            return [_hats(m.drive, moving, _KNOTS_BENT)], True
        case "change":
            return _changes(m), True
        case "sag":
            return [_hats(m.t, moving) * m.drive], True
        case "acceleration":
            rate = np.gradient(m.v, m.t + m.run * (m.t.max() + 1.0))
            return [_hats(rate, moving), sign[None, :]], True
        case "history":
            return _history(m), True
        case "reading":
            return _readings(m), False
        case "clock":
            return [_hats(m.t, every)], False
        case "late":
            return [_hats(m.v, every)], False
    return [], True


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


def _readings(m: Motion) -> list[Floats]:
    """Errors by the way since a run began, as of a scale, and by the place where they differ.

    Knots are where the head moves: at rest it may be in few places for most of the time.
    """
    first = np.flatnonzero(np.diff(m.run, prepend=-1))
    moved = m.x - np.repeat(m.x[first], np.diff(first, append=m.x.size))
    ways = [moved] if np.ptp(m.x[first]) == 0.0 else [moved, m.x]
    return [_hats(way, m.v != 0.0, _KNOTS_BENT) for way in ways]


def response(forces: Floats, m: Motion) -> tuple[Floats, Floats]:
    """First-order change of position and speed under small forces, a row a force."""
    step = np.diff(m.t, append=m.t[-1:])
    last = np.diff(m.run, append=m.run[-1:] + 1) != 0
    rows = np.ascontiguousarray(forces)
    return _core.linear_response(rows, m.v, step, last, m.mass, m.damping, m.keeps, m.stiffness)
