"""Initial states of runs whose start speeds are known."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis_small import NOISE, ROBOT, problem
from locosweep.diagnosis.estimate.initial_state import initial_states
from locosweep.diagnosis.estimate.least_squares import Nuisances
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
