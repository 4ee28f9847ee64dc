"""The augmented model as a file that reads back to the same model."""

import pytest

import locosweep as ls
from diagnosis_case import EFFECTS, NOMINAL
from locosweep.diagnosis.report.model_file import write_augmented
from locosweep.files.robot import Robot


class TestAugmented:
    def text(self, path, augmented, nominal=None):
        write_augmented(augmented, path, nominal)
        return path.read_text(encoding="utf-8")

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
            {e.name: {p.name: 0.5 for p in e.parameters} for e in ls.effects()},
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
