"""How large a cause is on given runs, and which other causes look the same there.

Sizes are lengths of whitened vectors, in standard deviations of the noise, after what
a fit may shift freely is projected out: start offset and start velocity of each run,
and uncertain nominal values within their standard deviations.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.blindcheck.experiment import COARSE, Experiment, World
from locosweep.blindcheck.laws import CAUSES, Scale

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.blindcheck.experiment import Effect

    Floats = NDArray[np.float64]

__all__ = ["ALIKE", "Nuisances", "rival_distances"]

ALIKE = 3.0
"""Causes nearer than this cannot be told apart."""


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
        small = 0.1
        for name in names:
            shifts = {**world.shifts, name: world.shifts.get(name, 0.0) + small}
            worlds.append(World(shifts, world.effects))
        read = experiment.read(worlds, COARSE, threads)
        self.base = experiment.whitened(read[0])
        moved = (experiment.whitened(read[1]) - self.base) / nudge
        self._runs = list(self._bases(moved))
        columns = [(experiment.whitened(r) - self.base) / small for r in read[2:]]
        self._count = len(columns)
        self._others = np.zeros((self.base.size, 0))
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

    def differences(self, effects: Sequence[tuple[Effect, ...]]) -> list[Floats]:
        """What sets of effects, added to the world's own, change; projected."""
        worlds = [World(self.world.shifts, (*self.world.effects, *added)) for added in effects]
        read = self.experiment.read(worlds, COARSE, self.threads)
        return [self.left(self.experiment.whitened(r) - self.base) for r in read]


@dataclass(frozen=True)
class _Atom:
    """A direction in which a rival can go: its effect at a signed strength."""

    cause: str
    group: str
    at: object
    signs: tuple[float, ...]

    def effect(self, s: float) -> Effect:
        return self.cause, "law", self.at(s)  # type: ignore[operator]


def _atoms(k: Scale, *, as_force: bool) -> list[_Atom]:
    """Laws of all causes over a grid of what is not their strength."""
    both, up = (1.0, -1.0), (1.0,)
    found = []

    def add(cause: str, at: object, signs: tuple[float, ...] = both, group: str = "") -> None:
        found.append(_Atom(cause, f"{cause}{group}", at, signs))

    per_speed = k.level / k.speed
    add("viscous_friction", lambda s: {"c": s * per_speed})
    add("quadratic_drag", lambda s: {"c2": s * per_speed / k.speed})
    for share in (0.03, 0.1, 0.35):
        for delta in (1.0, 2.0):
            add(
                "stribeck_friction",
                lambda s, share=share, delta=delta: {
                    "F_s": k.level * max(1.0 + s, 0.05),
                    "v_s": share * k.speed,
                    "delta": delta,
                },
                group=f" {share} {delta}",
            )

    def bristle(s: float, zeta: float) -> dict[str, float]:
        stiff = k.level / (max(s, 1e-4) * k.travel)
        return {"sigma0": stiff, "sigma1": 2.0 * zeta * float(np.sqrt(stiff * k.mass))}

    for zeta in (0.3, 1.0):
        add("presliding_compliance", lambda s, z=zeta: bristle(s, z), up, f" {zeta}")
    for side in ("F_c_forward", "F_c_backward"):
        levels = {"F_c_forward": k.level, "F_c_backward": k.level}
        add(
            "direction_dependent_friction",
            lambda s, side=side, levels=levels: {**levels, side: k.level * max(1.0 + s, 0.0)},
        )
    for share in (0.35, 0.6, 1.0, 1.7, 2.5):
        for phase in (0.0, 0.5 * np.pi):
            add(
                "position_dependent_friction",
                lambda s, share=share, phase=phase: {
                    "a": float(np.clip(s, -0.95, 0.95)),
                    "L": share * k.travel,
                    "p": phase,
                },
                group=f" {share}",
            )
    add("load_dependent_friction", lambda s: {"mu_l": s})
    for cause in ("friction_drift", "supply_sag"):
        for share in (0.15, 0.5, 1.5):
            add(
                cause,
                lambda s, share=share: {
                    "a": float(np.clip(s, -0.95, 0.95)),
                    "T": share * k.duration,
                },
                group=f" {share}",
            )
    add("lubricant_buildup", lambda s: {"k_b": s * k.level / k.travel})
    add("drive_saturation", lambda s: {"F_max": k.force * max(1.0 - s, 0.05)}, up)
    add("drive_lag", lambda s: {"T": max(s, 1e-5)}, up)
    add("drive_delay", lambda s: {"T": s}, both)
    add("drive_deadzone", lambda s: {"d": s * k.level}, up)
    add("drive_gain_error", lambda s: {"e": s})
    add("back_emf", lambda s: {"k_e": s * per_speed})

    def side(s: float, share: float) -> float:
        return k.mass * share * float(np.clip(s / 0.1, 0.02, 1.0))

    def spring(s: float, share: float) -> dict[str, float]:
        stiff, m_d = k.force / (max(s, 1e-3) * k.travel), side(s, share)
        reduced = m_d * k.mass / (m_d + k.mass)
        return {"k": stiff, "d": 0.4 * float(np.sqrt(stiff * reduced)), "m_d": m_d}

    for share in (0.05, 0.25):
        add(
            "transmission_backlash",
            lambda s, share=share: {"b": s * k.travel, "m_d": side(s, share)},
            up,
            f" {share}",
        )
        add("transmission_compliance", lambda s, share=share: spring(s, share), up, f" {share}")
    add("slope_error", lambda s: {"d_alpha_deg": float(np.clip(20.0 * s, -60, 60))})
    add("payload_mass", lambda s: {"dm": k.mass * max(s, -0.9)})
    if as_force:
        add("coulomb_error", lambda s: {"d_force": s * k.level})
    else:
        add("coulomb_error", lambda s: {"d_mu": s * k.mu})
    if k.grip > 0.0:

        def grip(s: float) -> dict[str, float]:
            mu = k.force * max(1.0 - s, 0.05) / k.grip
            return {"mu_static": mu, "mu_coulomb": 0.9 * mu}

        add("anchor_slip", grip, up)
    add("sensor_scale", lambda s: {"e": s})
    add("sensor_drift", lambda s: {"b": s * k.travel / k.duration})
    add("sensor_delay", lambda s: {"T": s}, both)
    return found


def _as_force(atom: _Atom, s: float, *, as_force: bool) -> Effect:
    name, form, parameters = atom.effect(s)
    return name, "force" if as_force and name == "coulomb_error" else form, parameters


def _allowed(atom: _Atom, s: float) -> bool:
    # A sensor reads late, a drive acts late; the other way round is no rival's law.
    return s >= 0.0 or (len(atom.signs) == 2 and not atom.cause.endswith("_delay"))


def rival_distances(
    nuisances: Nuisances,
    scale: Scale,
    gap: Floats,
    *,
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
    atoms = [a for a in _atoms(scale, as_force=as_force) if a.cause not in absent]
    basis = np.linalg.qr(np.array(beside).T)[0] if len(beside) else np.zeros((gap.size, 0))

    def off(vector: Floats) -> Floats:
        left: Floats = vector - basis @ (basis.T @ vector)
        return left

    gap = off(gap)
    size = float(np.linalg.norm(gap))

    def responses(strengths: list[tuple[_Atom, float]]) -> list[Floats]:
        effects = [(_as_force(atom, s, as_force=as_force),) for atom, s in strengths]
        return [off(d) for d in nuisances.differences(effects)]

    best: dict[str, float] = {cause: size for cause in CAUSES if cause not in absent}
    if size == 0.0:
        return best
    start = 0.01
    strength = {}
    for atom, seen in zip(atoms, responses([(a, start) for a in atoms]), strict=True):
        norm = float(np.linalg.norm(seen))
        # As strong as the gap, as far as one may take the response to be straight.
        strength[atom] = start * float(np.clip(size / norm, 1e-3, 30.0)) if norm > 0.0 else None
    visible = [a for a in atoms if strength[a] is not None]
    current = dict(zip(visible, responses([(a, strength[a]) for a in visible]), strict=True))
    for _ in range(3):
        moves: list[tuple[_Atom, float]] = []
        groups: dict[str, list[_Atom]] = {}
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
                if (
                    near
                    and _allowed(atom, moved)
                    and abs(moved) > 1e-7
                    and abs(factor - 1.0) > 0.01
                ):
                    moves.append((atom, moved))
        if not moves:
            break
        for (atom, s), seen in zip(moves, responses(moves), strict=True):
            if np.linalg.norm(seen) > 0.0:
                strength[atom], current[atom] = s, seen
            else:
                visible.remove(atom)
    return best
