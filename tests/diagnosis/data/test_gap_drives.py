"""Drives of rows that miss, as the motion around them tells them, and where it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep.diagnosis.data.gap_drives import told_by_motion
from locosweep.diagnosis.data.missing_rows import with_missing_rows
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs

STEP = 0.01
T = STEP * np.arange(400)
NOISE = 1e-5
ROBOT = Robot(
    {"mass": 0.2, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {"sensor.position_noise": NOISE},
)
SWITCHED = np.where(np.sin(8.0 * T + 0.4) > 0.0, 1.2, -1.1)
SWITCHED[:5] = 0.0
EDGES = np.flatnonzero(np.diff(SWITCHED)) + 1
EDGE = int(EDGES[4])


def measured(
    gone: list[int],
    drive: np.ndarray = SWITCHED,
    effects: dict[str, dict[str, float]] | None = None,
    noise: float = NOISE,
) -> Run:
    """A run whose rows in `gone` miss and are put in."""
    run = Run("0", T, drive, {"x": np.zeros(T.size)})
    x = replay_runs(replace(ROBOT, effects=effects or {}), [run])["x"].to_numpy()
    x = x + np.random.default_rng(1).normal(0.0, noise, T.size)
    kept = np.delete(np.arange(T.size), gone)
    return with_missing_rows(Run("0", T[kept], drive[kept], {"x": x[kept]}))[0]


def told(run: Run, robot: Robot = ROBOT) -> Run:
    (found,) = told_by_motion([run], robot)
    return found


def bounds(run: Run) -> np.ndarray:
    assert run.drive_deviation is not None
    return run.drive_deviation


@pytest.mark.parametrize("gone", [[EDGE], [EDGE - 1], [EDGE, EDGE + 1], [EDGE - 1, EDGE]])
@pytest.mark.parametrize(
    "effects",
    [{}, {"coulomb_error": {"d_mu": 0.05}}, {"payload_mass": {"dm": 0.02}},
     {"viscous_friction": {"c": 0.5}}],
)  # fmt: skip
def test_the_row_in_which_a_drive_switched_is_found(
    gone: list[int], effects: dict[str, dict[str, float]]
) -> None:
    run = measured(gone, effects=effects)
    found = told(run)
    assert found.drive[gone] == pytest.approx(SWITCHED[gone], abs=1e-12)
    assert bounds(found)[gone].max() == 0.0
    known = np.delete(np.arange(T.size), gone)
    assert np.array_equal(found.drive[known], run.drive[known])


def test_a_head_that_answers_late_does_not_shift_the_row() -> None:
    for effects in ({"drive_lag": {"T": 0.02}}, {"drive_delay": {"T": 0.02}}):
        run = measured([EDGE], effects=effects)
        found = told(run)
        # Known switches seem late as well, so that nothing is believed.
        assert np.array_equal(found.drive, run.drive)
        assert bounds(found)[EDGE] > 0.0


def test_where_noise_hides_it_the_drive_stays_within_its_bounds() -> None:
    run = measured([EDGE], noise=3e-3)
    robot = replace(ROBOT, other={"sensor.position_noise": 3e-3})
    found = told(run, robot)
    assert found.drive[EDGE] == pytest.approx(run.drive[EDGE])
    assert bounds(found)[EDGE] == bounds(run)[EDGE]


def test_a_head_at_rest_tells_nothing() -> None:
    drive = 0.1 * SWITCHED
    run = measured([EDGE], drive)
    assert told(run).drive[EDGE] == run.drive[EDGE]
    assert bounds(told(run))[EDGE] == bounds(run)[EDGE] > 0.0


def test_a_drive_that_switches_seldom_is_not_believed() -> None:
    twice = np.where(T > 1.2, 0.9, np.where(T > 0.1, 1.2, 0.0))
    row = int(np.searchsorted(T, 1.2)) + 1
    run = measured([row], twice)
    assert bounds(run)[row] > 0.0
    assert bounds(told(run))[row] == bounds(run)[row]


def test_runs_without_gaps_stay() -> None:
    run = Run("0", T, SWITCHED, {"x": np.zeros(T.size)})
    assert told(run) is run
    quiet = measured([EDGE + 10])
    assert bounds(quiet).max() == 0.0
    assert told(quiet) is quiet
