"""locosweep: the same works as sweeps, all checks of a call included."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

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
from peers.work import Array, thread_counts

# With no weight and a wall force of 1 N, friction coefficients are forces.
BARE: dict[str, float] = {"gravity": 0.0, "wall_force": 1.0}
LUGRE_TOLERANCE = 2e-4
ROBOT_STEP = 5e-3
LOCATED_STEP = 1e-2
"""As long as a phase allows: friction and drive are linear within it."""


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
    axes = {renamed[k]: v for k, v in points.axes(points.size).items()}
    fixed = {**BARE, "duration": points.END, "time_step": points.STEP}
    names = ["final_position", "final_speed"]
    return _job(names, axes, fixed, law="tanh", drive="sine", method="runge_kutta")


def lugre(points: LuGre) -> Callable[[int, str | None], Array]:
    """W4."""
    found = points.axes(points.size)
    axes = {"spring_stiffness": found["stiffness"], "mu_static": found["static"]}
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
        "tolerance": LUGRE_TOLERANCE,
    }
    return _job(["final_position"], axes, fixed, law="lugre")


def pulses(points: Pulses, method: str) -> Callable[[int, str | None], Array]:
    """W5."""
    found = points.axes(points.size)
    axes = {
        "drive_amplitude": found["forward"],
        "drive_back": found["back"],
        "mu_coulomb": found["coulomb"],
        "mu_static": found["static"],
        "viscous": found["viscous"],
        "mass": found["mass"],
        "drive_duty": points.DUTY,
    }
    fixed = {**BARE, "drive_period": points.PERIOD, "duration": points.PERIODS * points.PERIOD}
    fixed["time_step"] = LOCATED_STEP
    names = ["final_position", "final_speed"]
    return _job(names, axes, fixed, law="static_viscous", drive="pulse", method=method)


def robot(points: Robot) -> Callable[[int, str | None], Array]:
    """Return the whole robot's advance."""
    found = points.axes(points.size)
    axes = {"mu_coulomb": found["friction"], "drive_limit": found["limit"]}
    fixed = {
        "mass": SEGMENT_MASS,
        "segments": points.SEGMENTS,
        "joint_stiffness": points.STIFFNESS,
        "joint_damping": points.DAMPING,
        "stroke": points.STROKE,
        "speed_limit": points.RAMP,
        "dwell": points.PHASE - points.STROKE / points.RAMP,
        "cycles": points.CYCLES,
        "time_step": ROBOT_STEP,
        # Below sliding friction it counts as that.
        "mu_static": 0.0,
    }
    per_cycle = _job(["gait_advance"], axes, fixed, gait="single")
    return lambda threads, level: per_cycle(threads, level) * points.CYCLES


def ways(work: str, points: Points) -> list[Way]:
    """Return the variants of a work, the main call first."""
    run: Callable[[int, str | None], Array]
    others: list[tuple[str, str, Callable[[int, str | None], Array]]] = []
    allowed, steps = ATTAIN[work], 0
    if isinstance(points, Stribeck):
        run, allowed, steps = stribeck(points), 1e-9, points.STEPS
    elif isinstance(points, LuGre):
        run = lugre(points)
    elif isinstance(points, Pulses):
        run, allowed = pulses(points, "exact"), 1e-9
        others = [("located", "RK4 with events, 10 ms", pulses(points, "runge_kutta"))]
    elif isinstance(points, Robot):
        run, steps = robot(points), round(points.END / ROBOT_STEP)
    else:
        return []
    make = partial(Way, kind="ours", points=points.size, allowed=allowed, steps=steps)
    made = [make("ours", "locosweep", n, partial(run, n, None)) for n in thread_counts()]
    made += [
        make(f"ours.{level}", f"locosweep, {level}", 1, partial(run, 1, level))
        for level in _core.simd_levels()
    ]
    made += [
        make(f"ours.{key}", f"locosweep, {label}", 1, partial(call, 1, None))
        for key, label, call in others
    ]
    return made
