"""MuJoCo: the robot in soft contact with its own idea of dry friction."""

from __future__ import annotations

import copy
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout

from common.threads import thread_counts
from dynamics_peers.work import ROBOT, SEGMENT_MASS, Points, Robot, Way, share
from peers.work import Array

# The largest step within 1 % of the limit of small ones; choose.py shows the others.
STEP, FINE_STEP = 2e-3, 1e-4
# Robots whose own limit is computed to check the step.
_CHECKED = 8
# The defaults of a joint's dry friction let a segment that should stick creep by some mm/s.
# With this softness it sticks harder; either way the advance is up to 5 % off that with true
# dry friction, and both allow the same step.
_FRICTION = 'solreffriction="0.025 1" solimpfriction="0.995 0.995 0.001"'


def _text(step: float, friction: str) -> str:
    count = Robot.SEGMENTS
    bodies = "".join(
        f'<body name="segment{i}" pos="{-0.1 * i} 0 0">'
        f'<joint name="x{i}" type="slide" axis="1 0 0" frictionloss="1" {friction}/>'
        f'<inertial pos="0 0 0" mass="{SEGMENT_MASS}" diaginertia="1e-3 1e-3 1e-3"/></body>'
        for i in range(count)
    )
    tendons = "".join(
        f'<fixed name="length{j}"><joint joint="x{j}" coef="1"/>'
        f'<joint joint="x{j + 1}" coef="-1"/></fixed>'
        for j in range(count - 1)
    )
    servo = (
        f'gainprm="{Robot.STIFFNESS}" biastype="affine" '
        f'biasprm="0 {-Robot.STIFFNESS} {-Robot.DAMPING}" forcelimited="true" forcerange="-5 5"'
    )
    servos = "".join(f'<general tendon="length{j}" {servo}/>' for j in range(count - 1))
    # Nothing can touch. Of the solvers, PGS is the fastest for four constraints on as many
    # degrees of freedom; of the integrators, Euler, and it needs no shorter steps.
    return (
        f'<mujoco><option timestep="{step}" integrator="Euler" solver="PGS" gravity="0 0 0" '
        f'jacobian="dense"><flag contact="disable"/></option><worldbody>{bodies}</worldbody>'
        f"<tendon>{tendons}</tendon><actuator>{servos}</actuator></mujoco>"
    )


def models(p: Robot, step: float, friction: str = _FRICTION) -> list[Any]:
    """Return one model per robot; compiled once, as only two numbers differ."""
    first = mujoco.MjModel.from_xml_string(_text(step, friction))
    made = []
    for drag, limit in zip(p.drag, p.limit, strict=True):
        model = copy.copy(first)
        model.dof_frictionloss[:] = drag
        model.actuator_forcerange[:] = (-limit, limit)
        made.append(model)
    return made


def stepped(p: Robot, step: float) -> Callable[[], Array]:
    """Advance by ``mj_step`` in a loop, as in MuJoCo's tutorials."""
    made = models(p, step)
    lengths = p.commanded(p.midpoints(step))

    def call() -> Array:
        out = np.empty((p.size, 1))
        for i, model in enumerate(made):
            data = mujoco.MjData(model)
            for length in lengths:
                data.ctrl[:] = length
                mujoco.mj_step(model, data)
            out[i] = data.qpos.mean()
        return out

    return call


def rolled_out(
    p: Robot, step: float, threads: int, friction: str = _FRICTION
) -> Callable[[], Array]:
    """Advance by ``mujoco.rollout``: the loop in C++, on threads."""
    made = models(p, step, friction)
    data = [mujoco.MjData(made[0]) for _ in range(threads)]
    lengths = p.commanded(p.midpoints(step))
    states = mujoco.mj_stateSize(made[0], mujoco.mjtState.mjSTATE_FULLPHYSICS)
    start = np.zeros((p.size, states))
    # All states are returned, there is no other way; into memory that was used before.
    kept = np.empty((p.size, len(lengths), states))
    sensed = np.empty((p.size, len(lengths), 0))
    pool = rollout.Rollout(nthread=threads if threads > 1 else 0)

    def call() -> Array:
        pool.rollout(made, data, start, lengths[None], state=kept, sensordata=sensed)
        # After the time come the positions.
        advance: Array = kept[:, -1, 1 : 1 + p.SEGMENTS].mean(axis=1, keepdims=True)
        return advance

    return call


@cache
def off_limit(frictions: tuple[float, ...], limits: tuple[float, ...]) -> float:
    """Return the largest relative difference of some robots to the advance at a small step."""
    few = Robot(np.array(frictions), np.array(limits))
    fine = rolled_out(few, FINE_STEP, 1)()
    return float(np.max(np.abs(rolled_out(few, STEP, 1)() / fine - 1)))


def ways(work: str, points: Points) -> list[Way]:
    """List MuJoCo's ways to do a work."""
    if work != ROBOT or not isinstance(points, Robot):
        return []
    steps = round(points.END / STEP)
    some = points.some(_CHECKED)
    own = partial(off_limit, tuple(some.friction), tuple(some.limit))
    few = points.some(share(points, 0.1, 4))
    call = stepped(few, STEP)
    label = f"mujoco, mj_step at {STEP:g} s"
    found = [Way("mujoco", label, 1, call, points=few.size, allowed=None, steps=steps, own=own)]
    for n in thread_counts():
        call = rolled_out(points, STEP, n)
        label = f"mujoco, rollout at {STEP:g} s"
        found.append(
            Way(
                "mujoco.rollout",
                label,
                n,
                call,
                points=points.size,
                allowed=None,
                steps=steps,
                own=own,
            )
        )
    return found
