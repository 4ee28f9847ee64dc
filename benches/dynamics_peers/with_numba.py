"""numba: loops over the points as users write them, and what they would tune by hand."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from common.threads import numba_threads, thread_counts
from dynamics_peers import numba_replays, numba_smooth, numba_sticking
from dynamics_peers.replays import COULOMB, INTERVAL, SAMPLES, VISCOUS, WEIGHT, Bristles, Replays
from dynamics_peers.work import (
    ATTAIN,
    BRISTLES,
    LUGRE,
    PULSES,
    REPLAY,
    ROBOT,
    SEGMENT_MASS,
    STRIBECK,
    LuGre,
    Points,
    Pulses,
    Robot,
    Stribeck,
    Way,
    share,
)
from peers.work import Array

# The largest steps that attain what the work asks for; choose.py shows the others.
LUGRE_STEP = 5e-5
PULSE_STEP, PULSE_LONG_STEP, PULSE_WITHIN = 1e-3, 1e-2, 1e-9
ROBOT_STEP = 5e-3
# Steps between two samples.
BRISTLE_STEPS = 32
# Smoothed: as narrow as RK4 stays stable with.
SMOOTH_STEP, SMOOTH_WIDTH, SMOOTH_STRIBECK = 1e-4, 1e-3, 5e-3
ROBOT_SMOOTH_STEP, ROBOT_WIDTH = 5e-4, 1e-3

_SERVO = (SEGMENT_MASS, Robot.STIFFNESS, Robot.DAMPING)


def _run(kernel: Any, results: int, columns: tuple[Array, ...], *constants: Any) -> Array:
    out = np.empty((columns[0].size, results))
    kernel(*columns, *constants, out)
    return out


def stribeck(p: Stribeck) -> Array:
    """W3, one point after the other."""
    return _run(numba_smooth.stribeck, 2, p.columns, p.STEPS, p.STEP)


def stribeck_lanes(p: Stribeck) -> Array:
    """W3, some points side by side."""
    drive = np.sin(2 * np.pi * (p.STEP / 2) * np.arange(2 * p.STEPS + 1))
    return _run(numba_smooth.stribeck_lanes, 2, p.columns, drive, p.STEP)


def lugre(p: LuGre, step: float) -> Array:
    """W4 by RK4."""
    constants = (p.SIGMA0, p.SIGMA1, p.SIGMA2, p.COULOMB, p.VELOCITY, p.MASS, p.PULL)
    return _run(numba_smooth.lugre, 1, p.columns, constants, round(p.END / step), step)


def pulses_located(p: Pulses, step: float) -> Array:
    """W5 by RK4, each stop located."""
    return _run(numba_sticking.pulses_located, 2, p.columns, p.PERIODS, step, PULSE_WITHIN)


def pulses_smoothed(p: Pulses) -> Array:
    """W5 with sticking smoothed away."""
    smooth = (SMOOTH_STEP, SMOOTH_WIDTH, SMOOTH_STRIBECK)
    return _run(numba_sticking.pulses_smoothed, 2, p.columns, p.PERIODS, *smooth)


def pulses_exact(p: Pulses) -> Array:
    """W5 by exponentials between the events."""
    return _run(numba_sticking.pulses_exact, 2, p.columns, p.PERIODS)


def robot_stepped(p: Robot, step: float) -> Array:
    """Advance of robots by time stepping."""
    lengths = p.commanded(p.midpoints(step))
    return _run(numba_sticking.robot_stepped, 1, (p.drag, p.limit), lengths, step, *_SERVO)


def robot_smoothed(p: Robot, step: float) -> Array:
    """Advance of robots with smoothed friction, by RK4."""
    lengths = p.commanded(p.starts(step / 2))
    # The last step needs the command at its end too.
    lengths = np.concatenate((lengths, lengths[-1:]))
    given = (lengths, step, *_SERVO, ROBOT_WIDTH)
    return _run(numba_sticking.robot_smoothed, 1, (p.drag, p.limit), *given)


def replay(p: Replays) -> Array:
    """Positions at all samples, exactly."""
    given = (COULOMB, WEIGHT, SEGMENT_MASS, INTERVAL)
    return _positions(numba_replays.exact, p.force(), VISCOUS + p.viscous, *given)


def bristles(p: Bristles, steps: int) -> Array:
    """Positions at all samples, bristles by RK4 with some steps between samples."""
    given = (p.stiffness, p.damping, VISCOUS, COULOMB, WEIGHT, SEGMENT_MASS, INTERVAL, steps)
    return _positions(numba_replays.bristles, p.force(), *given)


def _positions(kernel: Any, force: Array, *given: Any) -> Array:
    out = np.empty(force.shape)
    kernel(force, *given, out)
    return out


def ways(work: str, points: Points) -> list[Way]:
    """List numba's ways to do a work."""
    found: list[Way] = []

    def add(
        key: str, label: str, function: Callable[[Any], Array], on: Points, **more: Any
    ) -> None:
        for n in thread_counts():
            call = partial(function, on)
            around = partial(numba_threads, n)
            found.append(Way(key, label, n, call, around=around, points=on.size, **more))

    if work == STRIBECK:
        some = points.some(share(points, 0.1, 200))
        add("numba", "numba", stribeck, some, steps=Stribeck.STEPS)
        add("numba.lanes", "numba, lanes by hand", stribeck_lanes, some, steps=Stribeck.STEPS)
    elif work == LUGRE:
        add(
            "numba.rk4",
            f"numba, RK4 at {LUGRE_STEP:g} s",
            partial(lugre, step=LUGRE_STEP),
            points,
            steps=round(LuGre.END / LUGRE_STEP),
            allowed=ATTAIN[LUGRE],
        )
    elif work == PULSES:
        for key, step in (("numba.located", PULSE_STEP), ("numba.located.long", PULSE_LONG_STEP)):
            label = f"numba, RK4 at {step:g} s, stops located"
            add(key, label, partial(pulses_located, step=step), points, allowed=ATTAIN[PULSES])
        some = points.some(share(points, 0.1, 200))
        label = f"numba, smoothed, RK4 at {SMOOTH_STEP:g} s"
        add("numba.smoothed", label, pulses_smoothed, some, allowed=None)
        add("numba.exact", "numba, exact pieces", pulses_exact, points)
    elif work == ROBOT:
        add(
            "numba.stepped",
            f"numba, time stepping at {ROBOT_STEP:g} s",
            partial(robot_stepped, step=ROBOT_STEP),
            points,
            allowed=ATTAIN[ROBOT],
            steps=round(Robot.END / ROBOT_STEP),
        )
        add(
            "numba.smoothed",
            f"numba, smoothed, RK4 at {ROBOT_SMOOTH_STEP:g} s",
            partial(robot_smoothed, step=ROBOT_SMOOTH_STEP),
            points,
            allowed=None,
            steps=round(Robot.END / ROBOT_SMOOTH_STEP),
        )
    elif work == REPLAY:
        add("numba", "numba, exact pieces", replay, points, steps=SAMPLES)
    elif work == BRISTLES:
        add(
            "numba",
            f"numba, RK4 at {INTERVAL / BRISTLE_STEPS:g} s",
            partial(bristles, steps=BRISTLE_STEPS),
            points,
            allowed=ATTAIN[BRISTLES],
            steps=SAMPLES,
        )
    return found
