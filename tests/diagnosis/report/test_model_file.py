"""The augmented model as a file that reads back to the same model."""

from dataclasses import replace

import numpy as np
import pytest

import locosweep as ls
from diagnosis_case import EFFECTS, NOMINAL
from diagnosis_small import ROBOT, measured, problem
from locosweep.diagnosis.report.model_file import calibrated, write_augmented
from locosweep.files.robot import Robot


class TestAugmented:
    def text(self, path, augmented, nominal=None):
        write_augmented(augmented, path, nominal)
        return path.read_text(encoding="utf-8")

    @pytest.mark.whole
    def test_the_users_file_is_kept(self, found, saved):
        text = (saved / "augmented.toml").read_text()
        assert text.startswith(NOMINAL)
        assert ls.load_robot(saved / "augmented.toml") == found.augmented

    @pytest.mark.parametrize(
        "effects",
        [
            {},
            {"drive_saturation": {"F_max": 0.1 + 0.2}, "sensor_drift": {"b": -1e-300}},
            {"coulomb_error": {"d_mu": -0.02}},
            {"transmission_compliance": {"k": float("inf"), "d": 0.0, "m_d": 0.1}},
            *(
                {
                    e.name: {f.name: 0.5 for f in e.fits if f.only_with != "coulomb_force"}
                    for e in ls.effects()
                    if joint not in e.excludes
                }
                for joint in ("transmission_backlash", "transmission_compliance")
            ),
        ],
    )
    def test_every_effect_comes_back_bit_for_bit(self, tmp_path, found, effects):
        augmented = Robot(found.nominal.parameters, found.nominal.other, effects)
        for given in (NOMINAL, None):
            self.text(tmp_path / "a.toml", augmented, given)
            assert ls.load_robot(tmp_path / "a.toml") == augmented

    def test_a_file_with_effects_of_its_own(self, tmp_path, found):
        augmented = Robot(found.nominal.parameters, found.nominal.other,
                          {"drive_lag": {"T": 0.02}, **EFFECTS})  # fmt: skip
        forms = ("\n[effects.drive_lag]\nT = 0.02\n", "\neffects.drive_lag.T = 0.02\n")
        table = NOMINAL + forms[0]
        assert self.text(tmp_path / "a.toml", augmented, table).startswith(table)
        assert ls.load_robot(tmp_path / "a.toml") == augmented
        dotted = "effects.drive_lag.T = 0.02\n" + NOMINAL
        self.text(tmp_path / "a.toml", augmented, dotted)
        assert ls.load_robot(tmp_path / "a.toml") == augmented

    def test_values_that_were_refitted_win_over_the_text(self, tmp_path, found):
        changed = Robot({**found.nominal.parameters, "mass": 0.3}, found.nominal.other, EFFECTS)
        self.text(tmp_path / "a.toml", changed, NOMINAL)
        assert ls.load_robot(tmp_path / "a.toml") == changed

    def test_a_bench(self, tmp_path):
        (tmp_path / "n.toml").write_text(
            "[robot]\nmass = 0.05\n[bench]\nkind = 'rotary'\ngravity_torque = 3.0\n"
            "[surface]\ncoulomb_force = 0.1"
        )
        robot = ls.load_robot(tmp_path / "n.toml")
        augmented = Robot(robot.parameters, robot.other, {"coulomb_error": {"d_force": 0.01}})
        for given in (None, (tmp_path / "n.toml").read_text()):
            self.text(tmp_path / "a.toml", augmented, given)
            assert ls.load_robot(tmp_path / "a.toml") == augmented


class TestCalibrated:
    """The model of a fit whose uncertain nominal values were fitted too."""

    def point(self, *factors):
        return replace(problem(measured({})).plain(), factors=np.array(factors))

    def test_exact_values_stay(self):
        found = calibrated(ROBOT, self.point(1.0, 1.0, 1.0, 0.0), EFFECTS)
        assert found == replace(ROBOT, effects=EFFECTS)

    def test_factors_go_into_the_nominal_values(self):
        found = calibrated(ROBOT, self.point(1.1, 0.9, 1.2, 0.0), {})
        assert found.parameters["mass"] == pytest.approx(0.275)
        assert found.parameters["mu_coulomb"] == pytest.approx(0.27)
        assert found.parameters["gain"] == pytest.approx(1.2)

    def test_a_clock_that_is_off_delays_the_drive(self):
        late = self.point(1.0, 1.0, 1.0, 0.003)
        assert calibrated(ROBOT, late, {}).effects == {"drive_delay": {"T": 0.003}}
        more = calibrated(ROBOT, late, {"drive_delay": {"T": 0.01}})
        assert more.effects["drive_delay"]["T"] == pytest.approx(0.013)

    def test_levels_of_friction_move_with_the_coulomb_level(self):
        effects = {"direction_dependent_friction": {"F_c_forward": 0.8, "F_c_backward": 0.7}}
        found = calibrated(ROBOT, self.point(1.1, 0.9, 1.0, 0.0), effects)
        # 0.3 * 0.25 kg * 9.81 m/s^2, and 0.99 of it.
        shift = -0.01 * 0.3 * 0.25 * 9.81
        assert found.effects["direction_dependent_friction"] == pytest.approx(
            {"F_c_forward": 0.8 + shift, "F_c_backward": 0.7 + shift}
        )

    def test_a_level_in_newton(self):
        other = {**ROBOT.other, "surface.coulomb_force": 0.5}
        parameters = {k: v for k, v in ROBOT.parameters.items() if k != "mu_coulomb"}
        found = calibrated(Robot(parameters, other), self.point(1.0, 0.9, 1.0, 0.0), {})
        assert found.other["surface.coulomb_force"] == pytest.approx(0.45)
