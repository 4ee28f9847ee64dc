"""Friction that a measured rig is given in addition: its force along the motion, on the drive.

The rig moved as it was measured under its drive. With a further friction force it moves the same
way if the drive gives that force on top. While the head slides, that is exact but for the
smoothing of the motion and for what changes within a sample (means over a sample are taken).

At rest, where the head bears any force up to its level, the drive's excess force N is made
larger in the same ratio as the level: N (level + extra) / level. So the head rests under the new
level exactly where it rested under the old one, it breaks away at the same instants with the
extra force already there, and the column does not jump where the excess force changes its sign.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.scale import level_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.regimes import MeasuredMotion
    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

_PARTS = 8
"""Parts of a sample that means are taken over: a head that turns within a sample is met to a
sixteenth of it."""
_NO_LEVEL = 1e-9
"""Level, in the largest drive force, below which a head bears nothing at rest."""


@dataclass(frozen=True)
class Along:
    """A motion in parts of its samples, shape (samples, parts)."""

    t: Floats
    x: Floats
    speed: Floats
    """Without its sign; 0 at rest."""
    direction: Floats
    """Sign of the speed; at rest the share of the level that is borne, with its sign."""
    swept: Floats
    """Distance moved forward since the last rest or turn."""
    level: float
    """Coulomb level of the model."""
    per_value: dict[str, float]
    """Level by each form of its error."""


def _viscous(at: Along, values: Mapping[str, float]) -> Floats:
    (coefficient,) = values.values()
    return coefficient * at.speed


def _quadratic(at: Along, values: Mapping[str, float]) -> Floats:
    return values["c2"] * at.speed**2


def _stribeck(at: Along, values: Mapping[str, float]) -> Floats:
    fallen = np.exp(-((at.speed / values["v_s"]) ** values["delta"]))
    return (values["F_s"] - at.level) * fallen


def _by_direction(at: Along, values: Mapping[str, float]) -> Floats:
    forward = at.direction > 0.0
    return np.where(forward, values["F_c_forward"], values["F_c_backward"]) - at.level


def _by_place(at: Along, values: Mapping[str, float]) -> Floats:
    wave = np.sin(2.0 * np.pi * at.x / values["L"] + values["p"])
    return at.level * values["a"] * wave


def _by_time(at: Along, values: Mapping[str, float]) -> Floats:
    return at.level * values["a"] * -np.expm1(-at.t / values["T"])


def _ploughed(at: Along, values: Mapping[str, float]) -> Floats:
    return np.where((at.direction > 0.0) & (at.speed > 0.0), values["k_b"] * at.swept, 0.0)


def _higher(at: Along, values: Mapping[str, float]) -> Floats:
    (change,) = (value * at.per_value[name] for name, value in values.items())
    return np.full_like(at.t, change)


def _loaded(at: Along, values: Mapping[str, float]) -> Floats:
    """Friction in newtons per newton of the drive force: see `drives_with`."""
    return np.full_like(at.t, values["mu_l"])


LAWS: dict[str, Callable[[Along, Mapping[str, float]], Floats]] = {
    "viscous_friction": _viscous,
    "back_emf": _viscous,
    "coulomb_error": _higher,
    "quadratic_drag": _quadratic,
    "stribeck_friction": _stribeck,
    "direction_dependent_friction": _by_direction,
    "position_dependent_friction": _by_place,
    "friction_drift": _by_time,
    "lubricant_buildup": _ploughed,
    "load_dependent_friction": _loaded,
}
"""Force against the motion that each law adds to the model's friction, N."""


def drives_with(
    law: Callable[[Along, Mapping[str, float]], Floats],
    nominal: Mapping[str, float],
    runs: Sequence[Run],
    motions: Sequence[MeasuredMotion],
    values: Mapping[str, float],
) -> list[Floats]:
    """Return drive columns under which runs move the same with a friction law in addition.

    Parameters
    ----------
    law : callable
        One of `LAWS`.
    nominal : mapping of str to float
        Numbers of the calibrated model.
    runs, motions : sequence of Run, of MeasuredMotion
        The runs and their smoothed motions.
    values : mapping of str to float
        Parameters of the law, SI.
    """
    found = []
    for run, motion in zip(runs, motions, strict=True):
        at = _along(run, motion, nominal)
        force = nominal["gain"] * run.drive
        if law is _loaded:
            # Friction follows the drive that is given: F' (1 - mu_l r sgn F') = F.
            pressed = np.mean(at.direction * law(at, values), axis=1) * np.sign(force)
            force = force / np.maximum(1.0 - pressed, 0.02)
        else:
            force = force + np.mean(at.direction * law(at, values), axis=1)
        found.append(force / nominal["gain"])
    return found


def rests_at_first(run: Run, motion: MeasuredMotion, nominal: Mapping[str, float]) -> bool:
    """Return whether the head rests at the first sample and the drive there leaves it at rest."""
    still = abs(float(motion.v[0])) <= motion.resting_speed
    excess = nominal["gain"] * run.drive[0] - _pull(run, motion.x[:1], nominal)[0]
    return bool(still and abs(excess) <= level_of(nominal))


def _pull(run: Run, x: Floats, nominal: Mapping[str, float]) -> Floats:
    """Force of gravity against forward motion."""
    if "gravity_torque" in nominal:
        return nominal["gravity_torque"] * np.sin(x)
    slope = nominal["slope_deg"] if run.slope_deg is None else run.slope_deg
    return np.full_like(x, nominal["mass"] * nominal["gravity"] * np.sin(np.radians(slope)))


def _along(run: Run, motion: MeasuredMotion, nominal: Mapping[str, float]) -> Along:
    """Return a measured motion in parts of its samples."""
    t = run.since_start
    step = np.append(np.diff(t), np.median(np.diff(t)))
    parts = (np.arange(_PARTS) + 0.5) / _PARTS
    at = t[:, None] + step[:, None] * parts
    x, v = np.interp(at, t, motion.x), np.interp(at, t, motion.v)
    force = (nominal["gain"] * run.drive)[:, None]
    level = level_of(nominal)
    least = max(level, _NO_LEVEL * max(float(np.abs(force).max()), 1e-300))
    rests = np.abs(v) <= motion.resting_speed
    borne = np.clip((force - _pull(run, x, nominal)) / least, -1.0, 1.0)
    direction = np.where(rests, borne, np.sign(v))
    speed = np.where(rests, 0.0, np.abs(v))
    slope = nominal["slope_deg"] if run.slope_deg is None else run.slope_deg
    normal = nominal["mass"] * nominal["gravity"] * float(np.cos(np.radians(slope)))
    per_value = {"d_force": 1.0, "d_mu": normal}
    swept = _swept(x, np.where(rests, 0.0, v))
    return Along(at, x, speed, direction, swept, level, per_value)


def _swept(x: Floats, v: Floats) -> Floats:
    """Distance moved forward since the last rest or turn."""
    flat, forward = x.ravel(), v.ravel() > 0.0
    way = np.append(0.0, np.cumsum(np.maximum(np.diff(flat), 0.0)))
    base = np.maximum.accumulate(np.where(forward, -np.inf, way))
    return np.where(forward, way - np.maximum(base, way[0]), 0.0).reshape(x.shape)
