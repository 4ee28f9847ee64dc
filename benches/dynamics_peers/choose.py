"""Tries tolerances and steps of the peers, to show that those in use are the loosest that do.

Run in ``benches`` as ``python -m dynamics_peers.choose``; takes some minutes.
"""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from dynamics_peers import with_numpy
from dynamics_peers.measure import differences
from dynamics_peers.work import ATTAIN, LUGRE, ROBOT, STRIBECK, LuGre, Robot, Stribeck
from peers.work import Array

_STEPS = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 4e-3, 5e-3, 1e-2)
_STRIBECKS, _LUGRES, _ROBOTS = 200, 64, 32


def _show(work: str, name: str, setting: str, call: Callable[[], Array], expected: Array) -> None:
    call()
    start = time.perf_counter()
    actual = call()
    taken = (time.perf_counter() - start) / len(expected)
    off = differences(work, actual, expected)
    worst = off.max()
    attains = "attains" if worst <= ATTAIN[work] else "-"
    print(
        f"{work:6} {name:22} {setting:16} max {worst:.1e} median {np.median(off):.1e} "
        f"{1e6 * taken:10.1f} us  {attains}"
    )


def stribeck() -> None:
    """W3 with adaptive methods, against RK4 at the given step."""
    p = Stribeck.draw(_STRIBECKS)
    expected = with_numpy.stribeck(p)
    if solver := _peer("scipy"):
        for method in ("RK45", "LSODA"):
            for rtol in (1e-4, 1e-5, 1e-6, 1e-7):
                call: Any = partial(solver.stribeck, p, method, rtol, 1e-2)
                _show(STRIBECK, f"scipy {method}", f"{rtol:g}", call, expected)
    for name, tolerances in (
        ("diffrax", (1e-4, 1e-5, 1e-6, 1e-7)),
        ("heyoka", (1e-13, 1e-14, 1e-15, 1e-16)),
    ):
        if solver := _peer(name):
            for tolerance in tolerances:
                _show(STRIBECK, name, f"{tolerance:g}", solver.stribeck(p, tolerance), expected)


def lugre() -> None:
    """W4 with all methods, against a tight Radau."""
    p = LuGre.draw(_LUGRES)
    solver = _peer("scipy")
    if not solver:
        return
    expected = solver.reference(p)
    for method, choices in (
        ("LSODA", ((1e-5, 1e-5), (1e-6, 1e-4), (1e-6, 1e-5), (1e-7, 1e-3))),
        ("Radau", ((1e-4, 1e-3), (1e-5, 1e-3), (1e-5, 1e-4))),
    ):
        for rtol, below in choices:
            call: Any = partial(solver.lugre, p, method, rtol, below)
            _show(LUGRE, f"scipy {method}", f"{rtol:g}, {rtol * below:g}", call, expected)
    if solver := _peer("locosweep"):
        for tolerance in (1e-4, 2e-5, 1e-5, 5e-6):
            call = partial(solver.lugre(p, tolerance), 1, None)
            _show(LUGRE, "locosweep", f"{tolerance:g}", call, expected)
    if solver := _peer("numba"):
        for step in (2.5e-5, 4e-5, 5e-5, 6.25e-5):
            _show(LUGRE, "numba RK4", f"{step:g} s", partial(solver.lugre, p, step), expected)
    for name, tolerances in (
        ("heyoka", (1e-8, 1e-15, 1e-16)),
        ("diffrax", (1e-4, 3e-5, 1e-5)),
    ):
        if solver := _peer(name):
            for tolerance in tolerances:
                _show(LUGRE, name, f"{tolerance:g}", solver.lugre(p, tolerance), expected)


def robot() -> None:
    """Find the steps of the robot, each against the smallest step of the same model."""
    p = Robot.draw(_ROBOTS)
    models: list[tuple[str, Callable[[float], Callable[[], Array]]]] = []
    if solver := _peer("locosweep"):
        ours = solver.robot
        models.append(("locosweep", lambda step: partial(ours(p, step), 1, None)))
    if solver := _peer("numba"):
        stepped, smoothed = solver.robot_stepped, solver.robot_smoothed
        models.append(("numba, time stepping", lambda step: partial(stepped, p, step)))
        models.append(("numba, smoothed", lambda step: partial(smoothed, p, step)))
    if solver := _peer("mujoco"):
        roll = solver.rolled_out
        models.append(("mujoco", lambda step: roll(p, step, 1)))
        models.append(("mujoco, its defaults", lambda step: roll(p, step, 1, "")))
    dry = with_numpy.robot(p, with_numpy.ROBOT_FINE)
    print(f"robot: advance of the first in dry friction {dry[0, 0]:.6f} m")
    for name, with_step in models:
        limit = with_step(_STEPS[0])().copy()
        off = differences(ROBOT, limit, dry).max()
        print(f"robot: {name}: limit {limit[0, 0]:.6f} m, off dry friction by up to {off:.1e}")
        for step in _STEPS:
            # Beyond where it is stable, the smoothed one gives no numbers.
            _show(ROBOT, name, f"{step:g} s", with_step(step), limit)


def _peer(name: str) -> Any:
    try:
        return importlib.import_module(f"dynamics_peers.with_{name}")
    except ModuleNotFoundError as error:
        print(f"{error.name}: skipped, not installed")
        return None


if __name__ == "__main__":
    for chosen in sys.argv[1:] or ("stribeck", "lugre", "robot"):
        {"stribeck": stribeck, "lugre": lugre, "robot": robot}[chosen]()
