"""locosweep: the same works as sweeps, all checks of a call included."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from common.threads import thread_counts
from dynamics_peers.replays import (
    NOMINAL,
    SAMPLES,
    SLOPE_DEG,
    Bristles,
    Replays,
    drives,
    times,
)
from dynamics_peers.work import (
    ATTAIN,
    SEGMENT_MASS,
    LuGre,
    Points,
    Pulses,
    Robot,
    Stribeck,
    Way,
)
from locosweep import _core
from peers.work import Array

# With no weight and a wall force of 1 N, friction coefficients are forces.
BARE: dict[str, float] = {"gravity": 0.0, "wall_force": 1.0}
# The loosest that attain what the work asks for; choose.py shows the others.
LUGRE_TOLERANCE = 1e-4
ROBOT_STEP, ROBOT_FINE = 5e-3, 2e-4
LOCATED_STEP = 2e-3


def _job(
    names: list[str], axes: Mapping[str, Array], fixed: Mapping[str, float], **how: Any
) -> Callable[[int, str | None], Array]:
    """Return what runs a sweep on some threads, at a SIMD level."""

    def run(threads: int, level: str | None) -> Array:
        requests = [(name, None, None) for name in names]
        job = _core.Sweep(list(axes.items()), list(fixed.items()), requests, **how)
        out = [np.empty(job.cells) for _ in names]
        job.run(list(enumerate(out)), threads, None, None, None, level)
        return np.stack(out, axis=1)

    return run


def stribeck(points: Stribeck) -> Callable[[int, str | None], Array]:
    """W3."""
    renamed = {
        "amplitude": "drive_amplitude",
        "coulomb": "mu_coulomb",
        "static": "mu_static",
        "stribeck": "stribeck_speed",
        "width": "transition_speed",
        "viscous": "viscous",
        "mass": "mass",
    }
    axes = {name: np.unique(getattr(points, ours)) for ours, name in renamed.items()}
    fixed = {**BARE, "duration": points.END, "time_step": points.STEP}
    names = ["final_position", "final_speed"]
    return _job(names, axes, fixed, law="tanh", drive="sine", method="runge_kutta")


def lugre(points: LuGre, tolerance: float) -> Callable[[int, str | None], Array]:
    """W4."""
    axes = {
        "spring_stiffness": np.unique(points.stiffness),
        "mu_static": np.unique(points.static),
    }
    fixed = {
        **BARE,
        "mass": points.MASS,
        "mu_coulomb": points.COULOMB,
        "viscous": points.SIGMA2,
        "stribeck_speed": points.VELOCITY,
        "bristle_stiffness": points.SIGMA0,
        "bristle_damping": points.SIGMA1,
        "pull_speed": points.PULL,
        "duration": points.END,
        "tolerance": tolerance,
    }
    return _job(["final_position"], axes, fixed, law="lugre")


def pulses(points: Pulses, method: str) -> Callable[[int, str | None], Array]:
    """W5."""
    axes = {
        "drive_amplitude": np.unique(points.forward),
        "drive_back": np.unique(points.back),
        "mu_coulomb": np.unique(points.coulomb),
        "mu_static": np.unique(points.static),
        "viscous": np.unique(points.viscous),
        "mass": np.unique(points.mass),
        "drive_duty": points.DUTY,
    }
    fixed = {**BARE, "drive_period": points.PERIOD, "duration": points.PERIODS * points.PERIOD}
    fixed["time_step"] = LOCATED_STEP
    names = ["final_position", "final_speed"]
    return _job(names, axes, fixed, law="static_viscous", drive="pulse", method=method)


def robot(points: Robot, step: float) -> Callable[[int, str | None], Array]:
    """Return the whole robot's advance."""
    axes = {"mu_coulomb": np.unique(points.friction), "drive_limit": np.unique(points.limit)}
    fixed = {
        "mass": SEGMENT_MASS,
        "segments": points.SEGMENTS,
        "joint_stiffness": points.STIFFNESS,
        "joint_damping": points.DAMPING,
        "stroke": points.STROKE,
        "speed_limit": points.RAMP,
        "dwell": points.PHASE - points.STROKE / points.RAMP,
        "cycles": points.CYCLES,
        "time_step": step,
        # Below sliding friction it counts as that.
        "mu_static": 0.0,
    }
    per_cycle = _job(["gait_advance"], axes, fixed, gait="single")
    return lambda threads, level: per_cycle(threads, level) * points.CYCLES


def _off_limit(points: Robot) -> float:
    """Return the largest relative difference to the advance at a very small step."""
    threads = thread_counts()[-1]
    fine = robot(points, ROBOT_FINE)(threads, None)
    return float(np.max(np.abs(robot(points, ROBOT_STEP)(threads, None) / fine - 1)))


def replay(points: Replays | Bristles) -> Callable[[int, str | None], Array]:
    """Return the positions at all samples."""
    if isinstance(points, Replays):
        effects = {"viscous_friction": [points.viscous], "drive_gain_error": [points.gain_error]}
    else:
        effects = {"presliding_compliance": [points.stiffness, points.damping]}
    values = np.zeros((points.size, _core.effect_parameter_count()))
    for effect in _core.effects():
        for k, column in enumerate(effects.get(effect.name, [])):
            values[:, effect.first + k] = column
    job = _core.Replay({**NOMINAL}, [(times(), drive, SLOPE_DEG) for drive in drives()])
    columns = [(int(run), 0, SAMPLES, list(effects)) for run in points.run]
    shares, starts = np.tile([1.0, 1.0, 1.0, 0.0], (points.size, 1)), np.zeros((points.size, 2))

    def run(threads: int, _level: str | None) -> Array:
        # Positions alone, as the peers.
        x: Array = job.run(columns, values, shares, starts, threads, channels=[0])
        return x.reshape(points.size, SAMPLES)

    return run


def ways(work: str, points: Points) -> list[Way]:
    """Return the variants of a work, the main call first."""
    run: Callable[[int, str | None], Array]
    others: list[tuple[str, str, Callable[[int, str | None], Array]]] = []
    allowed, steps = ATTAIN[work], 0
    own: Callable[[], float] | None = None
    if isinstance(points, Stribeck):
        run, allowed, steps = stribeck(points), 1e-9, points.STEPS
    elif isinstance(points, LuGre):
        run = lugre(points, LUGRE_TOLERANCE)
    elif isinstance(points, Pulses):
        run, allowed = pulses(points, "exact"), 1e-9
        others = [
            (
                "located",
                f"RK4 with events, {1e3 * LOCATED_STEP:g} ms",
                pulses(points, "runge_kutta"),
            )
        ]
    elif isinstance(points, Robot):
        run, steps = robot(points, ROBOT_STEP), round(points.END / ROBOT_STEP)
        own = partial(_off_limit, points)
    elif isinstance(points, Replays | Bristles):
        run, steps = replay(points), SAMPLES
    else:
        return []
    make = partial(Way, kind="ours", points=points.size, allowed=allowed, steps=steps)
    made = [make("ours", "locosweep", n, partial(run, n, None), own=own) for n in thread_counts()]
    # The baseline has no fused multiply-add and computes it bit by bit: dynamics.rs shows it.
    # A replay takes the level of the process.
    levels = (
        []
        if isinstance(points, Replays | Bristles)
        else [n for n in _core.simd_levels() if n != "baseline"]
    )
    made += [
        make(f"ours.{level}", f"locosweep, {level}", 1, partial(run, 1, level)) for level in levels
    ]
    made += [
        make(f"ours.{key}", f"locosweep, {label}", 1, partial(call, 1, None))
        for key, label, call in others
    ]
    return made
