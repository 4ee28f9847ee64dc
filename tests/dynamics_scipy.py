"""Trajectories by SciPy with events and a stick logic of their own: a reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

if TYPE_CHECKING:
    from dynamics_laws import Force, Plant

TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
# A dip of the speed below zero shorter than this could be missed; so could a
# break-away shorter than a thousandth of the wait.
LONGEST_STEP = 0.02
WATCH = 1000
# No stop so soon after a start: the speed is all rounding there.
DEAF = 1e-7


@dataclass
class Run:
    """What the engine's outputs are held against."""

    x: float
    v: float
    stuck: float = 0.0
    sticks: int = 0
    work: float = 0.0
    heat: float = 0.0
    # Largest position and speed, the scales of errors.
    far: float = 0.0
    fast: float = 0.0


def dry(plant: Plant) -> Run:
    """Motion under a dry law, event by event."""
    p = plant.p
    run = Run(p["start_position"], p["start_speed"])
    t, way = 0.0, int(np.sign(run.v))
    rest = run.x
    for until, force in plant.pieces():
        while t < until:
            if way == 0:
                t, way = wait(plant, run, force, t, until)
                rest = run.x
                continue
            t, stopped = slide(plant, run, force, t, until, way, rest)
            if stopped:
                run.v, rest = 0.0, run.x
                way = released(plant, force, t, run.x)
                run.sticks += way == 0
    return run


def push_at(plant: Plant, force: Force, t: float, x: float) -> tuple[float, float]:
    """Push on a segment at rest, and by how much it exceeds what friction holds."""
    whole = force(t) + plant.pull(t, x, 0.0)
    push = whole - plant.weight
    return push, abs(push) - plant.holds(int(np.sign(push)), x, whole)


def released(plant: Plant, force: Force, t: float, x: float) -> int:
    push, excess = push_at(plant, force, t, x)
    return int(np.sign(push)) if excess > 0 else 0


def wait(plant: Plant, run: Run, force: Force, t: float, until: float) -> tuple[float, int]:
    """Rest until friction gives way or the piece ends."""
    if released(plant, force, t, run.x):
        return t, released(plant, force, t, run.x)
    times = np.linspace(t, until, WATCH)
    excess = [push_at(plant, force, when, run.x)[1] for when in times]
    first = next((i for i, e in enumerate(excess) if e > 0), None)
    if first is None:
        run.stuck += until - t
        return until, 0

    def over(when: float) -> float:
        return push_at(plant, force, when, run.x)[1]

    go = float(brentq(over, times[first - 1], times[first], xtol=1e-15, rtol=1e-15))
    while over(go) <= 0:
        go += 1e-15 + 1e-15 * go
    run.stuck += go - t
    return go, released(plant, force, go, run.x)


def slide(
    plant: Plant, run: Run, force: Force, t: float, until: float, way: int, rest: float
) -> tuple[float, bool]:
    """Slide until the speed is zero or the piece ends."""
    mass, weight = plant.p["mass"], plant.weight

    def rates(when: float, y: Any) -> list[float]:
        x, v = float(y[0]), float(y[1])
        drive = force(when) + plant.pull(when, x, v)
        against = plant.dry(way * v, way, x, max(x - rest, 0.0), drive)
        return [v, (drive - weight - way * against) / mass, drive * v, way * against * v]

    def speed(when: float, y: Any) -> float:
        return way * float(y[1]) if when > t + DEAF else 1.0

    speed.terminal, speed.direction = True, -1  # type: ignore[attr-defined]
    answer = solve_ivp(
        rates,
        (t, until),
        [run.x, run.v, run.work, run.heat],
        events=speed,
        max_step=LONGEST_STEP,
        **TIGHT,
    )
    assert answer.success, answer.message
    run.x, run.v, run.work, run.heat = (float(value) for value in answer.y[:, -1])
    run.far = max(run.far, float(np.abs(answer.y[0]).max()))
    run.fast = max(run.fast, float(np.abs(answer.y[1]).max()))
    return float(answer.t[-1]), answer.status == 1


def smooth(plant: Plant) -> Run:
    """Motion under a law that is a function of speed."""
    return _through(plant, 0, lambda v, _: (plant.smooth(v), []), TIGHT)


def bristle(plant: Plant, states: int) -> Run:
    """Motion under a bristle law, by an implicit method of order 5."""
    options = {"method": "Radau", "rtol": 1e-9, "atol": 1e-13}
    return _through(plant, states, plant.bristle, options)


def _through(plant: Plant, states: int, law: Any, options: dict[str, Any]) -> Run:
    p = plant.p
    mass, weight, t = p["mass"], plant.weight, 0.0
    run = Run(p["start_position"], p["start_speed"])
    y = np.array([run.x, run.v, *([0.0] * states), 0.0, 0.0])
    for until, force in plant.pieces():
        if until <= t:
            continue

        def rates(when: float, y: Any, force: Force = force) -> list[float]:
            x, v = float(y[0]), float(y[1])
            drive = force(when) + plant.pull(when, x, v)
            against, bent = law(v, [float(z) for z in y[2 : 2 + states]])
            return [v, (drive - weight - against) / mass, *bent, drive * v, against * v]

        answer = solve_ivp(rates, (t, until), y, max_step=LONGEST_STEP, **options)
        assert answer.success, answer.message
        y, t = answer.y[:, -1], until
        run.far = max(run.far, float(np.abs(answer.y[0]).max()))
        run.fast = max(run.fast, float(np.abs(answer.y[1]).max()))
    run.x, run.v, run.work, run.heat = (float(y[i]) for i in (0, 1, -2, -1))
    return run
