"""How large a cause is on given runs, and which other causes look the same there.

Sizes are lengths of whitened vectors, in standard deviations of the noise, after what
a fit may shift freely is projected out: start offset and start velocity of each run,
and uncertain nominal values within their standard deviations.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.blindcheck.experiment import COARSE, Experiment, World
from locosweep.blindcheck.laws import CAUSES, Scale
from locosweep.blindcheck.rivals import Rival, rivals_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.blindcheck.experiment import Effect

    Floats = NDArray[np.float64]

__all__ = ["ALIKE", "Nuisances", "rival_distances"]

ALIKE = 3.0
"""Causes nearer than this cannot be told apart."""
_RIGID = {
    "transmission_backlash": "transmission_compliance",
    "transmission_compliance": "transmission_backlash",
}
"""Causes that are one where nothing gives way: a mass more on the side of the drive."""
_NO_PLAY = 1e-9
_SMALL = 0.1
"""Standard deviations by which uncertain values are moved for their sensitivities."""
_STEPS = 5


class Nuisances:
    """What is projected out of differences between worlds.

    Parameters
    ----------
    experiment : Experiment
        Rig and drives.
    scale : Scale
        Speeds for the nudges.
    world : World
        Where the sensitivities are taken.
    threads : int
        For the reality.
    """

    def __init__(self, experiment: Experiment, scale: Scale, world: World, threads: int) -> None:
        self.experiment, self.world, self.threads = experiment, world, threads
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
            place = slice(at, at + size)
            offset = np.zeros(size)
            offset[: drive.t.size] = 1.0
            columns = [offset]
            if np.linalg.norm(moved[place]) > 0.0:
                columns.append(moved[place])
            bases.append((place, np.linalg.qr(np.array(columns).T)[0]))
            at += size
        return bases

    def _per_run(self, vector: Floats) -> Floats:
        vector = vector.copy()
        for place, basis in self._runs:
            part = vector[place]
            vector[place] = part - basis @ (basis.T @ part)
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
        seen = self.experiment.whitened(self.experiment.read([world], COARSE, self.threads)[0])
        names = list(self.experiment.rig.uncertainty)
        moved = np.zeros(len(names))
        best = float(np.linalg.norm(self.left(seen - self.base)))
        for _ in range(_STEPS if names else 0):
            at = [moved, *(moved + _SMALL * row for row in np.eye(len(names)))]
            read = self.experiment.read([self._shifted(names, m) for m in at], COARSE, self.threads)
            here, *near = (self._per_run(self.experiment.whitened(r)) for r in read)
            rest = np.concatenate([self._per_run(seen) - here, -moved])
            best = min(best, float(np.linalg.norm(rest)))
            columns = np.array([(n - here) / _SMALL for n in near]).T
            step = np.linalg.lstsq(np.vstack([columns, np.eye(len(names))]), rest, rcond=None)[0]
            moved = moved + step
        return best

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
    scale: Scale,
    gap: Floats,
    *,
    own: Effect | None = None,
    beside: Sequence[Floats] = (),
    absent: Sequence[str] = (),
) -> dict[str, float]:
    """Measure how near each cause, refitted, comes to a gap.

    Parameters
    ----------
    nuisances : Nuisances
        At the world that the rivals are added to.
    scale : Scale
        Of the rig.
    gap : ndarray
        The projected difference that rivals try to copy.
    own : tuple of str, str and dict, optional
        The effect that makes it.
    beside : sequence of ndarray
        Projected sensitivities of effects that stay and are refitted as well.
    absent : sequence of str
        Causes that have no meaning on the rig, or are already in the world.

    Returns
    -------
    dict of str to float
        What each cause leaves of the gap, in standard deviations.
    """
    as_force = bool(np.isnan(scale.mu))
    atoms = [a for a in rivals_of(scale, as_force=as_force) if a.cause not in absent]
    basis = np.linalg.qr(np.array(beside).T)[0] if len(beside) else np.zeros((gap.size, 0))

    def off(vector: Floats) -> Floats:
        left: Floats = vector - basis @ (basis.T @ vector)
        return left

    gap = off(gap)
    size = float(np.linalg.norm(gap))

    def responses(strengths: list[tuple[Rival, float]]) -> list[Floats]:
        effects = [(atom.effect(s, as_force=as_force),) for atom, s in strengths]
        return [off(d) for d in nuisances.differences(effects)]

    best: dict[str, float] = {cause: size for cause in CAUSES if cause not in absent}
    if size == 0.0:
        return best
    if own and own[0] in _RIGID:
        stiff = {"b": _NO_PLAY * scale.travel, "m_d": own[2]["m_d"]}
        rigid = nuisances.differences([(("transmission_backlash", "law", stiff),)])[0]
        best[_RIGID[own[0]]] = min(size, float(np.linalg.norm(gap - off(rigid))))
    start = 0.01
    strength: dict[Rival, float] = {}
    for atom, seen in zip(atoms, responses([(a, start) for a in atoms]), strict=True):
        norm = float(np.linalg.norm(seen))
        # As strong as the gap, as far as one may take the response to be straight.
        if norm > 0.0:
            strength[atom] = start * float(np.clip(size / norm, 1e-3, 30.0))
    visible = list(strength)
    current = dict(zip(visible, responses([(a, strength[a]) for a in visible]), strict=True))
    for _ in range(3):
        moves: list[tuple[Rival, float]] = []
        groups: dict[str, list[Rival]] = {}
        for atom in visible:
            groups.setdefault(atom.group, []).append(atom)
        for members in groups.values():
            columns = np.array([current[a] for a in members]).T
            factors = np.linalg.lstsq(columns, gap, rcond=1e-9)[0]
            cause = members[0].cause
            if len(members) > 1:
                # A plane of directions: what is left of the gap beside it.
                rest = float(np.linalg.norm(gap - columns @ factors))
                best[cause] = min(best[cause], rest)
            else:
                rest = float(np.linalg.norm(gap - columns[:, 0]))
                best[cause] = min(best[cause], rest)
            near = float(np.linalg.norm(gap - columns @ factors)) < max(0.5 * size, 4.0 * ALIKE)
            for atom, factor in zip(members, factors, strict=True):
                moved = float(strength[atom] * np.clip(factor, -4.0, 4.0))
                if near and atom.allows(moved) and abs(moved) > 1e-7 and abs(factor - 1.0) > 0.01:
                    moves.append((atom, moved))
        if not moves:
            break
        for (atom, s), seen in zip(moves, responses(moves), strict=True):
            if np.linalg.norm(seen) > 0.0:
                strength[atom], current[atom] = s, seen
            else:
                visible.remove(atom)
    return best
