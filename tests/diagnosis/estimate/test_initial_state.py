"""Initial states of runs whose start speeds are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_small import NOISE, ROBOT, problem
from locosweep.diagnosis.estimate.initial_state import initial_states
from locosweep.diagnosis.estimate.least_squares import Nuisances
from locosweep.files.robot import Robot
from locosweep.files.runs import Run

MU_G = ROBOT.parameters["mu_coulomb"] * ROBOT.parameters["gravity"]


def coasting(speed: float, label: str = "0", seed: int = 1) -> Run:
    """A head that slides to rest before its first push: v0 t - mu g t^2 / 2."""
    t = np.arange(0.0, 1.0, 0.0025)
    stop = np.minimum(t, abs(speed) / MU_G)
    x = speed * stop - np.sign(speed) * 0.5 * MU_G * stop**2
    noise = NOISE * np.random.default_rng(seed).standard_normal(t.size)
    return Run(label, t, np.zeros(t.size), {"x": x + noise})


def test_a_run_that_begins_in_motion_is_found_with_its_speed() -> None:
    own = problem([coasting(0.0, "0", 1), coasting(0.3, "1", 2), coasting(-0.2, "2", 3)])
    found = initial_states(own, Nuisances(speed=0.3))
    assert found.moving == (1, 2)
    np.testing.assert_allclose(found.speed, [0.0, 0.3, -0.2], atol=2e-3)
    # It rests elsewhere later: it begins where it was first seen.
    assert found.position[1] == pytest.approx(0.0, abs=5.0 * NOISE)


def test_the_problem_stays_as_it_was() -> None:
    own = problem([coasting(0.3)])
    before = own.starts.position.copy()
    assert initial_states(own, Nuisances(speed=0.3)).moving == (0,)
    assert own.starts.moving == ()
    np.testing.assert_array_equal(own.starts.position, before)


def test_runs_at_rest_begin_at_rest() -> None:
    own = problem([coasting(0.0, str(k), k) for k in range(4)])
    found = initial_states(own, Nuisances(speed=0.3))
    assert found.moving == ()
    assert not found.speed.any()


def test_too_few_samples_say_nothing() -> None:
    run = coasting(0.3)
    run.channels["x"][1:60] = np.nan
    assert initial_states(problem([run]), Nuisances(speed=0.3)).moving == ()


PENDULUM = Robot(
    {"mass": 0.0343, "gravity": 9.81, "viscous": 0.0, "segments": 1.0},
    {
        "surface.coulomb_force": 0.0945,
        "bench.kind": "rotary",
        "bench.gravity_torque": 1.61,
        "sensor.position_noise": 1.3e-5,
    },
)


def test_a_fit_of_a_start_speed_ends_in_no_wrong_valley() -> None:
    """A pendulum rests again after four samples; a parabola through ten has a third of its speed.

    Under torques that lift it step by step, fits from there end at a third, too.
    """
    t = np.arange(0.0, 4.9, 0.01)
    torque = np.array([0.0, 0.231, 0.366, 0.501, 0.636, 0.77])
    drive = torque[np.searchsorted([0.28, 1.13, 2.01, 2.88, 3.76], t, side="right")]
    run = Run("0", t, drive, {"x": np.zeros(t.size)})
    still = problem([run], robot=PENDULUM)
    x = still.replay([replace(still.plain(), speeds=np.array([0.1]))])["x"][0]
    noise = 1.3e-5 * np.random.default_rng(3).standard_normal(t.size)
    own = problem([replace(run, channels={"x": x + noise})], robot=PENDULUM)
    found = initial_states(own, Nuisances(speed=0.38))
    assert found.moving == (0,)
    np.testing.assert_allclose(found.speed, 0.1, atol=2e-3)


def pushed_at_once(speed: float, noise: float) -> list[Run]:
    """Heads that a drive pushes from the first sample on; the first one begins in motion."""
    t = np.arange(0.0, 2.0, 0.01)
    push = 4.4 * np.sin(np.pi * t / 0.11) * (t < 0.11)
    runs = [Run(str(k), t, (1.0 - 0.2 * k) * push, {"x": np.zeros(t.size)}) for k in range(3)]
    still = problem(runs)
    speeds = np.array([speed, 0.0, 0.0])
    x = still.replay([replace(still.plain(), speeds=speeds)])["x"].reshape(3, t.size)
    x = x + noise * np.random.default_rng(3).standard_normal(x.shape)
    return [replace(run, channels={"x": own}) for run, own in zip(runs, x, strict=True)]


@pytest.mark.parametrize(("speed", "moving"), [(-0.128, (0,)), (0.0, ())])
def test_a_start_speed_that_its_first_samples_hide_is_found_from_the_whole_run(
    speed: float, moving: tuple[int, ...]
) -> None:
    noise = 1e-3
    robot = replace(ROBOT, other={"sensor.position_noise": noise})
    found = initial_states(problem(pushed_at_once(speed, noise), robot=robot), Nuisances(speed=0.4))
    assert found.moving == moving
    np.testing.assert_allclose(found.speed, [speed, 0.0, 0.0], atol=5e-3)
