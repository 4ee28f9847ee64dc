"""Sizes of a rig from its model and its runs."""

from dataclasses import replace

import numpy as np
import pytest

from locosweep.diagnosis.effects.catalogue import parameters_of, starts_of
from locosweep.diagnosis.effects.scale import level_of, scale_of
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import nominal_of

T = np.linspace(0.0, 2.0, 201)
RUN = Run("0", T, np.where(T < 1.0, 3.0, -1.0), {"x": 0.25 * T})
ROBOT = Robot({"mass": 0.5, "segments": 3.0, "mu_coulomb": 0.2, "slope_deg": 60.0})


def test_the_level_is_that_on_the_nominal_slope():
    assert level_of(nominal_of(ROBOT)) == pytest.approx(0.2 * 0.5 * 9.81 * 0.5)


def test_a_level_given_as_a_force_counts_as_it_is():
    assert level_of({"slope_deg": 60.0, "mass": 1.0, "gravity": 9.81, "coulomb_force": 2.0}) == 2.0


def test_sizes_are_those_of_the_runs():
    scale = scale_of(ROBOT, [RUN])
    assert scale.travel == pytest.approx(0.5)
    assert scale.speed == pytest.approx(0.25)
    assert scale.force == scale.peak == 3.0
    assert scale.interval == pytest.approx(0.01)
    assert scale.duration == scale.replayed == 2.0
    assert scale.grip == pytest.approx(2.0 * 0.5 * 9.81 * 0.5)
    assert not scale.has_force_level
    assert not scale.rotary


def test_an_uncertain_level_may_be_lower():
    uncertain = Robot(ROBOT.parameters, {"uncertainty.mu_coulomb": 0.1, "uncertainty.mass": 0.05})
    scale = scale_of(uncertain, [RUN])
    assert scale.least_level == pytest.approx(scale.level * (1.0 - 3.0 * 0.15))


@pytest.mark.parametrize(
    ("robot", "level"),
    [
        (Robot({"mass": 0.5}, {"surface.coulomb_force": 1e-5}), 1e-5),
        (Robot({"mass": 0.5, "mu_coulomb": 1e-6}), 1e-6),
        (Robot({"mass": 0.5, "mu_coulomb": 0.2, "slope_deg": 0.0}), 0.2),
    ],
)
def test_no_error_makes_friction_negative(robot, level):
    """However small it is beside the forces: what drives the head is no friction."""
    (error,) = parameters_of("coulomb_error", scale_of(robot, [RUN]), ("coulomb_error",))
    assert error.low == pytest.approx(-0.999 * level)


def test_a_lag_may_last_as_long_as_a_run_where_a_delay_ends_with_its_window():
    windows = replace(scale_of(ROBOT, [RUN]), replayed=0.1)
    (lag,) = parameters_of("drive_lag", windows, ("drive_lag",))
    (delay,) = parameters_of("drive_delay", windows, ("drive_delay",))
    assert lag.high == pytest.approx(2.0)
    assert delay.high == pytest.approx(0.03)


def test_a_run_without_positions_leaves_sizes_above_zero():
    silent = Run("0", T, np.zeros(T.size), {"x": np.full(T.size, np.nan)})
    scale = scale_of(ROBOT, [silent])
    assert min(scale.travel, scale.speed, scale.force, scale.level) > 0.0


def test_a_limit_that_one_strong_run_reaches_lies_between_starts():
    weak = [replace(RUN, label=str(k), drive=0.6 * RUN.drive) for k in range(9)]
    strong = replace(RUN, drive=np.where(T < 0.2, 3.0, 1.0))
    scale = scale_of(ROBOT, [strong, *weak])
    assert (scale.force, scale.peak) == (pytest.approx(1.8), 3.0)
    starts = starts_of("drive_saturation", scale)[:, 0]
    assert starts.min() < scale.force < 0.9 * scale.peak < starts.max() < scale.peak
