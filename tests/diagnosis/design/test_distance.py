"""Distances between effects: signals in units of the noise, strengths, refits."""

import numpy as np
import pytest

from locosweep.diagnosis.design.distance import PlannedRuns, project, refit, strengths
from locosweep.files.robot import Robot
from locosweep.files.runs import Run

ROBOT = Robot({"mass": 0.271, "segments": 4.0, "mu_coulomb": 0.15})
NOISE = {"x": 1e-4}
T = np.arange(0.0, 1.2, 0.01)
PUSH = np.where((T > 0.05) & (T < 0.4), 0.62, 0.0)
BOTH = PUSH - np.where((T > 0.7) & (T < 1.0), 0.7, 0.0)


def planned(*drives):
    return [Run(str(i), T, drive) for i, drive in enumerate(drives)]


class TestPlan:
    def test_directions_are_orthonormal_and_taken_out(self):
        plan = PlannedRuns(ROBOT, planned(PUSH, BOTH), NOISE)
        rows = plan.directions
        assert rows.shape == (4, 2 * T.size)
        np.testing.assert_allclose(rows @ rows.T, np.eye(4), atol=1e-9)
        signals = plan.signals([("viscous_friction", {"c": 0.1})])
        assert np.abs(signals @ rows.T).max() < 1e-9 * np.abs(signals).max()
        assert project(project(signals, rows), rows) == pytest.approx(project(signals, rows))

    def test_nominal_effects_have_no_signal(self):
        plan = PlannedRuns(ROBOT, planned(PUSH), NOISE)
        off = [("viscous_friction", {"c": 0.0}), ("drive_gain_error", {"e": 0.0})]
        assert np.abs(plan.signals(off)).max() == 0.0

    def test_a_shift_of_the_start_is_no_signal(self):
        plan = PlannedRuns(ROBOT, planned(PUSH), NOISE)
        assert np.linalg.norm(project(np.full((1, T.size), 5.0), plan.directions)) < 1e-9

    def test_signals_are_in_units_of_the_noise(self):
        drift = ("sensor_drift", {"b": 1e-3})
        fine, coarse = (
            PlannedRuns(ROBOT, planned(PUSH), {"x": sd}).signals([drift]) for sd in (1e-5, 1e-4)
        )
        assert np.linalg.norm(fine) == pytest.approx(10 * np.linalg.norm(coarse), rel=1e-3)

    def test_strengths_have_the_length_asked_for(self):
        plan = PlannedRuns(ROBOT, planned(BOTH), NOISE)
        families = plan.families
        asked = [(f, sign) for f in families.values() for sign in f.signs if f.least < 1e-3]
        for (family, sign), theta in zip(asked, strengths(plan, asked, 6.0), strict=True):
            if theta is None:
                continue
            assert np.sign(theta[0]) == sign
            size = np.linalg.norm(plan.signals([(family.name, family.parameters(theta))]))
            if abs(theta[0]) > 1.01 * family.least:
                assert size == pytest.approx(6.0, rel=0.15), family.name

    def test_a_refit_finds_the_effect_itself(self):
        plan = PlannedRuns(ROBOT, planned(BOTH), NOISE)
        for name in ("viscous_friction", "drive_lag", "friction_drift", "lubricant_buildup"):
            family = plan.families[name]
            (theta,) = strengths(plan, [(family, 1.0)], 30.0)
            signal = plan.signals([(name, family.parameters(theta))])
            # From a start that is far off.
            left, (best,) = refit(plan, family, signal, 0.2 * theta[0])
            assert left[0] < 0.3, name
            assert best[0] == pytest.approx(theta[0], rel=0.1), name

    def test_what_a_rival_cannot_imitate_is_all_left(self):
        plan = PlannedRuns(ROBOT, planned(BOTH), NOISE)
        family = plan.families["drive_gain_error"]
        (theta,) = strengths(plan, [(family, 1.0)], 10.0)
        signal = plan.signals([(family.name, family.parameters(theta))])
        # Neither a lag nor a saturation makes the head go further.
        left, (best,) = refit(plan, plan.families["drive_saturation"], signal, 0.01)
        assert left[0] == pytest.approx(np.linalg.norm(signal))
        assert best[0] == 0.0
