"""Size of a cause on given runs, and its distances from all other causes.

Sizes are lengths of whitened vectors, in standard deviations of the noise, after what
a fit may shift freely is projected out: start offset and start velocity of each run,
and uncertain nominal values within their standard deviations.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.validation.experiment import COARSE, Experiment, World
from locosweep.validation.laws import CAUSES, Scale
from locosweep.validation.rivals import Rival, refined_step, rivals_between, rivals_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from locosweep.validation.experiment import Effect

    Floats = NDArray[np.float64]

ALIKE = 3.0
"""Standard deviations below which causes are indistinguishable."""
RISES = 1.1
"""Rise of the error beside a rest, by what a rival leaves of an effect's gap, below which the
rival is the same answer."""
_RIGID = {
    "transmission_backlash": "transmission_compliance",
    "transmission_compliance": "transmission_backlash",
}
"""Causes that are the same at a rigid joint: a further mass on the side of the drive."""
_STIFFNESSES, _DAMPINGS = np.geomspace(0.5, 2.0, 25), (0.1, 1.0)
"""Of springs near a joint, in its own; the nearest one is refitted. Of `blind-check --only
another-law`, case 11 of `--seed 26464`, a gap of 25 um with soft stops, is a spring of 0.84 of
their stiffness up to 9 standard deviations, and case 57 of `--cases 80 --seed 29191`, of 1.4 mm,
one of 0.7 and a tenth of their damping, where the nearest with all of it is at 34."""
_NUDGE = 0.01
"""Change of the logarithm of a spring's numbers for their sensitivities. Not derived."""
_LONGEST = 0.5
"""Change of it that a refit makes at once, at most: a spring of another stiffness swings out of
step, and says nothing of farther ones. Not derived."""
_FINER = 4
"""Times that values on either side of the best one are tried."""
_NO_PLAY = 1e-9
"""Play of a rigid joint, in the travel: what no sensor sees. Not derived."""
_SMALL = 0.1
"""Standard deviations by which uncertain values are moved for their sensitivities."""
_STEPS = 6
"""Steps of Gauss and Newton in which uncertain values, or a spring, are refitted. Not derived."""
_DAMPED = (0.0, 1e-6, 1e-4, 1e-2, 1.0)
"""Shares of the trace of a refit's normal matrix that are added to its diagonal; each step tries
all and takes the best. Without, a step goes far astray where several values do nearly the same.
Their spacing is not derived."""
_FURTHEST = 8.0
"""Standard deviations that an uncertain value is shifted by, at most."""


class Nuisances:
    """Freedoms of a fit that are projected out of differences between worlds.

    Sensitivities are those at `world`; `scale` gives the speeds of their steps.
    """

    def __init__(self, experiment: Experiment, scale: Scale, world: World, threads: int) -> None:
        self.experiment, self.scale, self.world, self.threads = experiment, scale, world, threads
        nudge = 0.01 * scale.speed
        names = list(experiment.rig.uncertainty)
        worlds = [world, World(world.shifts, world.effects, nudge)]
        for name in names:
            shifts = {**world.shifts, name: world.shifts.get(name, 0.0) + _SMALL}
            worlds.append(World(shifts, world.effects))
        read = experiment.read(worlds, COARSE, threads)
        self.base = experiment.whitened(read[0])
        moved = (experiment.whitened(read[1]) - self.base) / nudge
        self._runs = list(self._bases(moved))
        columns = [(experiment.whitened(r) - self.base) / _SMALL for r in read[2:]]
        self._count = len(columns)
        self._prior = np.zeros((self.base.size + self._count, 0))
        if columns:
            # A standard deviation costs as much as one of the noise.
            stacked = np.array([self._per_run(c) for c in columns]).T
            self._prior = np.linalg.qr(np.vstack([stacked, np.eye(self._count)]))[0]

    def _bases(self, moved: Floats) -> list[tuple[slice, Floats]]:
        """Directions of start offset and start velocity, run by run."""
        bases, at = [], 0
        channels = ("x", *self.experiment.sensors.channels)
        for drive in self.experiment.drives:
            size = drive.t.size * len(channels)
            rows = slice(at, at + size)
            offset = np.zeros(size)
            offset[: drive.t.size] = 1.0
            columns = [offset]
            if np.linalg.norm(moved[rows]) > 0.0:
                columns.append(moved[rows])
            bases.append((rows, np.linalg.qr(np.array(columns).T)[0]))
            at += size
        return bases

    def _per_run(self, vector: Floats) -> Floats:
        vector = vector.copy()
        for rows, basis in self._runs:
            vector[rows] -= basis @ (basis.T @ vector[rows])
        return vector

    def left(self, vector: Floats) -> Floats:
        """Project a whitened difference."""
        whole = np.concatenate([self._per_run(vector), np.zeros(self._count)])
        left: Floats = whole - self._prior @ (self._prior.T @ whole)
        return left

    def size(self, effects: tuple[Effect, ...]) -> float:
        """Measure what effects, added to the world's own, change, beyond first order.

        Uncertain values that take an effect up bend on the way: they are shifted step by
        step, where `differences` shifts them along their sensitivities at the world's own.
        """
        world = World(self.world.shifts, (*self.world.effects, *effects))
        read = self.experiment.read([world], COARSE, self.threads)[0]
        seen = self._per_run(self.experiment.whitened(read))
        names = list(self.experiment.rig.uncertainty)

        def rests(shifts: Iterable[Floats]) -> list[Floats]:
            """Return what shifts of the uncertain values leave, their own prices last."""
            every = list(shifts)
            worlds = [self._shifted(names, moved) for moved in every]
            reads = self.experiment.read(worlds, COARSE, self.threads)
            there = (self._per_run(self.experiment.whitened(r)) for r in reads)
            return [np.concatenate([seen - t, -m]) for t, m in zip(there, every, strict=True)]

        moved = np.zeros(len(names))
        rest = np.concatenate([seen - self._per_run(self.base), moved])
        for _ in range(_STEPS if names else 0):
            near = rests(moved + _SMALL * row for row in np.eye(len(names)))
            columns = (rest - np.array(near)).T / _SMALL
            if not np.isfinite(columns).all():
                break
            known, along = columns.T @ columns, columns.T @ rest
            damped = (known + share * np.trace(known) * np.eye(len(names)) for share in _DAMPED)
            steps = (np.linalg.solve(one, along) for one in damped)
            tried = [np.clip(moved + step, -_FURTHEST, _FURTHEST) for step in steps]
            left = rests(tried)
            best = min(range(len(left)), key=lambda i: float(np.linalg.norm(left[i])))
            if not np.linalg.norm(left[best]) < np.linalg.norm(rest):
                break
            moved, rest = tried[best], left[best]
        return float(np.linalg.norm(rest))

    def _shifted(self, names: Sequence[str], moved: Floats) -> World:
        shifts = dict(self.world.shifts)
        for name, far in zip(names, moved.tolist(), strict=True):
            shifts[name] = shifts.get(name, 0.0) + far
        return World(shifts, self.world.effects)

    def differences(self, effects: Sequence[tuple[Effect, ...]]) -> list[Floats]:
        """Return what sets of effects, added to the world's own, change; projected."""
        worlds = [World(self.world.shifts, (*self.world.effects, *added)) for added in effects]
        read = self.experiment.read(worlds, COARSE, self.threads)
        return [self.left(self.experiment.whitened(r) - self.base) for r in read]


def rival_distances(
    nuisances: Nuisances,
    gap: Floats,
    *,
    own: Effect | None = None,
    beside: Sequence[Floats] = (),
    absent: Sequence[str] = (),
    most: float = np.inf,
) -> dict[str, float]:
    """Measure the part of a gap that each cause, refitted, leaves, in standard deviations.

    Parameters
    ----------
    nuisances : Nuisances
        At the world that the rivals are added to.
    gap : ndarray
        Projected difference that rivals try to copy, made by the effect `own`.
    beside : sequence of ndarray
        Projected sensitivities of further effects, refitted as well.
    absent : sequence of str
        Causes that have no meaning on the rig, or are already in the world.
    most : float
        Size of the gap by a refit beyond first order: no rival leaves more.
    """
    scale = nuisances.scale
    as_force = bool(np.isnan(scale.mu))
    rivals = [a for a in rivals_of(scale, as_force=as_force) if a.cause not in absent]
    basis = np.linalg.qr(np.array(beside).T)[0] if len(beside) else np.zeros((gap.size, 0))

    def off(vector: Floats) -> Floats:
        left: Floats = vector - basis @ (basis.T @ vector)
        return left

    gap = off(gap)
    size = float(np.linalg.norm(gap))
    best: dict[str, float] = {cause: min(size, most) for cause in CAUSES if cause not in absent}
    if size == 0.0:
        return best

    def responses(strengths: list[tuple[Rival, float]]) -> list[Floats]:
        effects = [(rival.effect(s),) for rival, s in strengths]
        return [off(d) for d in nuisances.differences(effects)]

    def left_by(joints: Sequence[Effect]) -> list[Floats]:
        return [gap - off(d) for d in nuisances.differences([(joint,) for joint in joints])]

    for cause, rest in _joints_near(own, scale, left_by).items() if own else ():
        best[cause] = min(best[cause], rest)
    left = _refitted(rivals, gap, responses)
    for cause in dict.fromkeys(rival.cause for rival in rivals if rival.refined is not None):
        _between(left, cause, scale, lambda finer: _refitted(finer, gap, responses))
    for rival, rest in left.items():
        best[rival.cause] = min(best[rival.cause], rest)
    return best


def _joints_near(
    own: Effect, scale: Scale, left_by: Callable[[Sequence[Effect]], list[Floats]]
) -> dict[str, float]:
    """Return what joints that may act as a joint does leave of its gap, by cause.

    A rigid one, and springs of its stiffness or about it: a gap with soft stops that is small
    beside their give is a spring, of a mass and a damping that no grid holds.
    """
    name, form, values = own
    if name not in _RIGID:
        return {}
    rigid = ("transmission_backlash", "law", {"b": _NO_PLAY * scale.travel, "m_d": values["m_d"]})
    found = {_RIGID[name]: float(np.linalg.norm(left_by([rigid])[0]))}
    if form != "law" and "k" in values:
        springs = [
            {"k": k * values["k"], "d": d * values["d"], "m_d": values["m_d"]}
            for k in _STIFFNESSES.tolist()
            for d in _DAMPINGS
        ]
        rest = _refitted_spring(springs, left_by)
        found["transmission_compliance"] = min(found.get("transmission_compliance", rest), rest)
    return found


def _refitted_spring(
    springs: Sequence[dict[str, float]], left_by: Callable[[Sequence[Effect]], list[Floats]]
) -> float:
    """Refit the numbers of the best of some springs; return what it leaves of a gap."""
    names = list(springs[0])

    def left_at(points: Floats) -> list[Floats]:
        numbers = [dict(zip(names, np.exp(p).tolist(), strict=True)) for p in points]
        return left_by([("transmission_compliance", "law", own) for own in numbers])

    at = np.log([[spring[name] for name in names] for spring in springs])
    rests = left_at(at)
    nearest = int(np.argmin([np.linalg.norm(rest) for rest in rests]))
    point, rest, damping = at[nearest], rests[nearest], 0.0
    for _ in range(_STEPS):
        columns = np.array(left_at(point + _NUDGE * np.eye(len(names)))) - rest
        if not np.isfinite(columns).all():
            break
        columns /= _NUDGE
        known = columns @ columns.T
        known[np.diag_indices_from(known)] *= 1.0 + damping
        step = -np.linalg.lstsq(known, columns @ rest, rcond=None)[0]
        step *= min(1.0, _LONGEST / max(float(np.abs(step).max()), 1e-300))
        (new,) = left_at(point[None] + step)
        better = bool(np.linalg.norm(new) < np.linalg.norm(rest))
        damping = 0.1 * damping if better else max(10.0 * damping, 0.1)
        point, rest = (point + step, new) if better else (point, rest)
    return float(np.linalg.norm(rest))


def _between(
    left: dict[Rival, float],
    cause: str,
    scale: Scale,
    refitted: Callable[[list[Rival]], dict[Rival, float]],
) -> None:
    """Look between the values of a refined number, nearer and nearer the best one."""
    factor = refined_step(cause)
    for _ in range(_FINER):
        own = {rival.refined: rival for rival in left if rival.cause == cause}
        if not own:
            return
        best = min(own.values(), key=left.__getitem__)
        if left[best] < ALIKE:
            return
        factor = factor**0.4
        left |= refitted(rivals_between(best, factor, scale))


def _refitted(
    rivals: Sequence[Rival],
    gap: Floats,
    responses: Callable[[list[tuple[Rival, float]]], list[Floats]],
) -> dict[Rival, float]:
    """Refit the strength of every rival that can be seen; return what each leaves of a gap."""
    size = float(np.linalg.norm(gap))
    start = 0.01
    strength: dict[Rival, float] = {}
    for rival, seen in zip(rivals, responses([(a, start) for a in rivals]), strict=True):
        norm = float(np.linalg.norm(seen))
        # As strong as the gap, as far as one may take the response to be straight.
        if norm > 0.0:
            strength[rival] = start * float(np.clip(size / norm, 1e-3, 30.0))
    visible = list(strength)
    left = dict.fromkeys(visible, size)
    current = dict(zip(visible, responses([(a, strength[a]) for a in visible]), strict=True))
    for again in (True, True, True, False):
        moves: list[tuple[Rival, float]] = []
        groups: dict[str, list[Rival]] = {}
        for rival in visible:
            groups.setdefault(rival.group, []).append(rival)
        for members in groups.values():
            columns = np.array([current[a] for a in members]).T
            factors = np.linalg.lstsq(columns, gap, rcond=1e-9)[0]
            fitted = float(np.linalg.norm(gap - columns @ factors))
            # Several span a plane of directions; of one, the law itself has to do.
            rest = fitted if len(members) > 1 else float(np.linalg.norm(gap - columns[:, 0]))
            near = fitted < max(0.5 * size, 4.0 * ALIKE)
            for rival, factor in zip(members, factors, strict=True):
                left[rival] = min(left[rival], rest)
                moved = float(strength[rival] * np.clip(factor, -4.0, 4.0))
                if near and rival.allows(moved) and abs(moved) > 1e-7 and abs(factor - 1.0) > 0.01:
                    moves.append((rival, moved))
        if not (moves and again):
            break
        for (rival, s), seen in zip(moves, responses(moves), strict=True):
            if np.linalg.norm(seen) > 0.0:
                strength[rival], current[rival] = s, seen
            else:
                visible.remove(rival)
    return left
