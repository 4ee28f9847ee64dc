"""Where fits of effects start: grids that follow the rig's own scale."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from locosweep.simulation.replay import effect, effects, nominal_of

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run

__all__ = ["Free", "Scale", "candidates", "level_of", "parameters_of", "scale_of", "starts_of"]


@dataclass(frozen=True)
class Scale:
    """Sizes of a rig and of its runs, all positive, SI."""

    mass: float
    level: float
    least_level: float
    """What the Coulomb level may be where the nominal file leaves it uncertain."""
    force: float
    speed: float
    travel: float
    duration: float
    interval: float
    weight: float
    grip: float
    viscous: float
    has_force_level: bool
    rotary: bool
    replayed: float
    """Length of a free replay, s: that of a run, or of a window of one."""


@dataclass(frozen=True)
class Free:
    """A free parameter: how it is stepped and where it may go."""

    effect: str
    name: str
    unit: str
    log: bool
    size: float
    """What counts as a large change, in the parameter's unit (of its logarithm if `log`)."""
    low: float
    high: float
    off: float
    """Value without the effect; NaN where none does it."""


def level_of(nominal: Mapping[str, float]) -> float:
    """Coulomb level at the nominal slope, N: what levels of effects are given beside."""
    cosine = float(np.cos(np.radians(nominal["slope_deg"])))
    weight = nominal["mass"] * nominal["gravity"]
    return nominal.get("coulomb_force", nominal.get("mu_coulomb", 0.0) * weight * cosine)


def scale_of(robot: Robot, runs: Sequence[Run]) -> Scale:
    """Measure the rig's scale from its model and its runs."""
    nominal = nominal_of(robot)
    rotary = "gravity_torque" in nominal
    mass = nominal["mass"]
    weight = mass * nominal["gravity"]
    cosine = float(np.cos(np.radians(nominal["slope_deg"])))
    level = level_of(nominal)
    doubts = [robot.other.get(f"uncertainty.{key}", 0.0) for key in ("mass", "mu_coulomb")]
    drives = np.concatenate([run.drive for run in runs]) * nominal["gain"]
    force = float(np.quantile(np.abs(drives), 0.98)) or float(np.abs(drives).max()) or weight
    travel, speed = [], []
    for run in runs:
        x = run.channels["x"]
        ok = np.isfinite(x)
        if ok.sum() < 8:
            continue
        t, x = run.t[ok], x[ok]
        travel.append(float(np.ptp(x)))
        # Slopes over twentieths of a run: insensitive to noise of single samples.
        stride = max(1, x.size // 40)
        slopes = np.abs(np.diff(x[::stride]) / np.diff(t[::stride]))
        speed.append(float(slopes.max(initial=0.0)))
    duration = float(np.median([run.t[-1] - run.t[0] for run in runs]))
    far = float(np.median(travel)) if travel else 1e-3
    fast = float(np.median(speed)) if speed else 1e-3
    return Scale(
        mass=mass,
        level=max(level, 1e-3 * force),
        least_level=max(level, 1e-3 * force) * max(0.0, 1.0 - _DOUBT * sum(map(float, doubts))),
        force=force,
        speed=max(fast, 1e-6),
        travel=max(far, 1e-7),
        duration=duration,
        interval=float(np.median([np.median(np.diff(run.t)) for run in runs])),
        weight=weight,
        grip=max((nominal["segments"] - 1.0) * weight * cosine, 1e-9),
        viscous=nominal["viscous"],
        has_force_level="coulomb_force" in nominal,
        rotary=rotary,
        replayed=duration,
    )


# Share of the dry friction that is always left.
_LEAST = 1e-3
# Standard deviations that an uncertain value may be off.
_DOUBT = 3.0
# With these beside it, friction at rest may lie below the nominal Coulomb level and
# still above the true one.
_LOWERS_FRICTION = frozenset({"coulomb_error", "payload_mass"})

_SIGNED = (-0.3, -0.1, -0.03, -0.01, -0.003, 0.003, 0.01, 0.03, 0.1, 0.3)
_POSITIVE = (0.003, 0.01, 0.03, 0.1, 0.3)

# effect -> parameter -> (logarithmic, unit size, grid in unit sizes, low, high, off)
_NONE = float("nan")


def _table(
    s: Scale,
) -> dict[str, dict[str, tuple[bool, float, Sequence[float], float, float, float]]]:
    inf = np.inf
    # Dry friction that is 0 makes bristles infinitely stiff: steps of no length.
    most = 1.0 - _LEAST
    some = _LEAST * s.level
    viscosity = s.force / s.speed
    slow = [s.duration * share for share in (0.03, 0.1, 0.3, 1.0, 3.0)]
    fast = [
        max(s.interval * 0.3, s.replayed * share) for share in (5e-4, 2e-3, 5e-3, 0.01, 0.03, 0.1)
    ]
    degree = np.degrees(min(1.0, s.level / s.weight))

    def critical(stiffness: float) -> float:
        return 2.0 * float(np.sqrt(stiffness * s.mass))

    # The last ones ring within a sample of most sensors: rigid but for the mass behind them.
    omega = [2 * np.pi * f for f in (2.0, 5.0, 12.0, 30.0, 100.0, 300.0)]
    return {
        "viscous_friction": {
            "c": (False, viscosity, _SIGNED, -s.viscous, inf, 0.0),
        },
        "quadratic_drag": {
            "c2": (False, viscosity / s.speed, _POSITIVE, 0.0, inf, 0.0),
        },
        "stribeck_friction": {
            # Friction that rises from rest on is another cause.
            "F_s": (False, s.level, (1.03, 1.1, 1.4), s.least_level, 20 * s.force, s.level),
            "v_s": (
                True,
                1.0,
                [s.speed * r for r in (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)],
                1e-4 * s.speed,
                10 * s.speed,
                _NONE,
            ),
            "delta": (True, 1.0, (1.2,), 0.5, 2.5, _NONE),
        },
        "presliding_compliance": {
            "sigma0": (
                True,
                1.0,
                [s.level / (s.travel * r) for r in (1e-4, 1e-3, 1e-2, 1e-1)],
                s.level / (10 * s.travel),
                s.level / (1e-6 * s.travel),
                _NONE,
            ),
            "sigma1": (
                True,
                1.0,
                (0.01, 0.5),
                1e-4 * critical(s.level / s.travel),
                3 * critical(s.level / (1e-6 * s.travel)),
                _NONE,
            ),
        },
        "direction_dependent_friction": {
            "F_c_forward": (False, s.level, (0.8, 0.95, 1.05, 1.2), some, inf, s.level),
            "F_c_backward": (False, s.level, (0.8, 0.95, 1.05, 1.2), some, inf, s.level),
        },
        "position_dependent_friction": {
            "a": (False, 1.0, (0.05,), -most, most, 0.0),
            "L": (
                True,
                1.0,
                [s.travel * r for r in np.geomspace(0.04, 3.0, 20)],
                0.02 * s.travel,
                10 * s.travel,
                _NONE,
            ),
            "p": (False, 1.0, (0.0, 1.57, 3.14, 4.71), -100.0, 100.0, _NONE),
        },
        "load_dependent_friction": {"mu_l": (False, 1.0, _SIGNED, -1.0, 10.0, 0.0)},
        "friction_drift": {
            "a": (False, 1.0, (-0.3, -0.1, -0.01, 0.01, 0.1, 0.3), -most, 10.0, 0.0),
            "T": (True, 1.0, slow, 0.01 * s.duration, 10 * s.duration, _NONE),
        },
        "lubricant_buildup": {"k_b": (False, s.force / s.travel, _POSITIVE, 0.0, inf, 0.0)},
        "drive_saturation": {
            "F_max": (
                True,
                1.0,
                [s.force * r for r in (0.3, 0.45, 0.6, 0.75, 0.85, 0.93, 0.98)],
                0.02 * s.force,
                2.0 * s.force,
                _NONE,
            ),
        },
        "drive_lag": {"T": (True, 1.0, fast, 0.003 * s.interval, s.replayed, 0.0)},
        "drive_delay": {
            "T": (
                False,
                0.1 * s.replayed,
                [k * t / (0.1 * s.replayed) for t in fast for k in (-1, 1)],
                -0.3 * s.replayed,
                0.3 * s.replayed,
                0.0,
            )
        },
        "drive_deadzone": {"d": (False, s.force, (*_POSITIVE, 0.5), 0.0, s.force, 0.0)},
        "drive_gain_error": {"e": (False, 1.0, _SIGNED, -0.95, 10.0, 0.0)},
        "back_emf": {"k_e": (False, viscosity, _SIGNED, -s.viscous, inf, 0.0)},
        "supply_sag": {
            "a": (False, 1.0, (-0.3, -0.1, -0.01, 0.01, 0.1, 0.3), -5.0, 1.0, 0.0),
            "T": (True, 1.0, slow, 0.01 * s.duration, 10 * s.duration, _NONE),
        },
        "transmission_backlash": {
            "b": (
                True,
                1.0,
                [s.travel * r for r in (1e-5, 1e-3, 1e-2, 0.1)],
                1e-8 * s.travel,
                s.travel,
                _NONE,
            ),
            "m_d": (
                True,
                1.0,
                [s.mass * r for r in (0.005, 0.03, 0.2, 1.0)],
                1e-3 * s.mass,
                10 * s.mass,
                _NONE,
            ),
        },
        "transmission_compliance": {
            "k": (True, 1.0, [s.mass * w**2 for w in omega], s.mass, s.mass * 1e6, _NONE),
            "d": (
                True,
                1.0,
                (0.1, 0.6),
                1e-4 * critical(s.mass),
                3 * critical(s.mass * 1e6),
                _NONE,
            ),
            "m_d": (
                True,
                1.0,
                [s.mass * r for r in (0.01, 0.1, 0.7)],
                1e-3 * s.mass,
                10 * s.mass,
                _NONE,
            ),
        },
        "slope_error": {"d_alpha_deg": (False, degree, _SIGNED, -45.0, 45.0, 0.0)},
        "payload_mass": {"dm": (False, s.mass, (*_SIGNED, 1.0), -0.95 * s.mass, 20 * s.mass, 0.0)},
        "coulomb_error": {"d_force": (False, s.level, _SIGNED, some - s.level, inf, 0.0)}
        if s.has_force_level
        else {"d_mu": (False, s.level / s.weight, _SIGNED, -most * s.level / s.weight, inf, 0.0)},
        "anchor_slip": {
            "mu_static": (
                True,
                1.0,
                [s.force / s.grip * r for r in (0.3, 0.5, 0.7, 0.85, 0.97)],
                1e-3 * s.force / s.grip,
                3 * s.force / s.grip,
                _NONE,
            ),
            "mu_coulomb": (
                True,
                1.0,
                [s.force / s.grip * r for r in (0.3, 0.5, 0.7, 0.85, 0.95)],
                1e-3 * s.force / s.grip,
                3 * s.force / s.grip,
                _NONE,
            ),
        },
        "sensor_scale": {"e": (False, 1.0, _SIGNED, -0.95, 10.0, 0.0)},
        "sensor_drift": {"b": (False, s.travel / s.duration, _SIGNED, -inf, inf, 0.0)},
        "sensor_delay": {
            "T": (
                False,
                0.1 * s.replayed,
                [k * t / (0.1 * s.replayed) for t in fast for k in (-1, 1)],
                -0.3 * s.replayed,
                0.3 * s.replayed,
                0.0,
            )
        },
    }


def candidates(robot: Robot, runs: Sequence[Run], scale: Scale) -> tuple[list[str], dict[str, str]]:
    """List the effects that have a meaning on this rig, and why the others have none."""
    out: dict[str, str] = {}
    bench = robot.other.get("bench.kind") is not None
    single = nominal_of(robot)["segments"] <= 1.0
    if bench or single:
        out["anchor_slip"] = "a bench has no anchored body"
    elif not any("x_rear" in run.channels for run in runs):
        out["anchor_slip"] = "the body's motion is not measured (x_rear)"
    if scale.rotary:
        out["slope_error"] = "a rotary bench has no slope"
    return [record.name for record in effects() if record.name not in out], out


def parameters_of(name: str, scale: Scale, beside: Collection[str] = ()) -> list[Free]:
    """Return the free parameters of an effect with others beside it, on a rig of this scale."""
    units = {p.name: p.unit for p in effect(name).parameters}
    if _LOWERS_FRICTION.intersection(beside):
        scale = replace(scale, least_level=0.0)
    table = _table(scale)[name]
    ends = {**{key: row[3:5] for key, row in table.items()}, **_resolved(name, scale)}
    return [
        Free(name, key, units[key], log, size, *ends[key], off)
        for key, (log, size, _, _, _, off) in table.items()
    ]


def _resolved(name: str, scale: Scale) -> dict[str, tuple[float, float]]:
    """Return ends of ranges in windows: a spring that rings within a sample is rigid there."""
    if scale.replayed >= scale.duration or name != "transmission_compliance":
        return {}
    m, step = scale.mass, scale.interval
    return {
        "k": (min(m, 0.1 * m / step**2), m / step**2),
        "d": (1e-3 * m / scale.replayed, m / step),
        "m_d": (0.1 * m, 10.0 * m),
    }


def starts_of(name: str, scale: Scale) -> NDArray[np.float64]:
    """Return the start values of an effect's parameters, a row a start."""
    table = _table(scale)[name]
    grids = []
    for log, size, grid, _, _, _ in table.values():
        values = np.asarray(grid, dtype=float) * (1.0 if log else size)
        grids.append(np.unique(values))
    rows = np.array(list(product(*grids)))
    if name in ("presliding_compliance", "transmission_compliance"):
        # Damping is given as a share of the critical one.
        rows[:, 1] *= 2.0 * np.sqrt(rows[:, 0] * scale.mass)
    if name == "anchor_slip":
        rows = rows[rows[:, 1] <= rows[:, 0] * 1.0001]
    ends = _resolved(name, scale)
    lows = [ends.get(key, entry[3:5])[0] for key, entry in table.items()]
    highs = [ends.get(key, entry[3:5])[1] for key, entry in table.items()]
    return np.unique(np.clip(rows, lows, highs), axis=0)
