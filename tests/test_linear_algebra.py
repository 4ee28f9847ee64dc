"""Linear algebra has one thread while runs are diagnosed, and as many as before afterwards."""

from __future__ import annotations

import numpy as np
from threadpoolctl import threadpool_info

from locosweep import Robot, diagnose
from locosweep.linear_algebra import on_one_thread


def threads() -> list[int]:
    return [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]


def test_a_function_has_one_thread_and_gives_the_others_back() -> None:
    np.eye(2) @ np.eye(2)
    before = threads()

    @on_one_thread
    def inside(size: int) -> list[int]:
        """Say how many."""
        assert size == 3
        return threads()

    assert before
    assert inside(size=3) == [1] * len(before)
    assert threads() == before
    assert inside.__doc__ == "Say how many."


def test_a_diagnosis_has_one_thread() -> None:
    seen = []

    def progress(*_: float) -> None:
        seen.append(threads())

    t = np.linspace(0.0, 1.0, 101)
    x = np.random.default_rng(0).normal(0.0, 1e-5, t.size)
    robot = Robot({"mass": 0.2, "mu_coulomb": 0.3, "gravity": 9.81})
    diagnose({"t": t, "drive": np.where(t > 0.1, 0.5, 0.0), "x": x}, robot, progress=progress)
    assert seen
    assert all(count == [1] * len(count) for count in seen)
