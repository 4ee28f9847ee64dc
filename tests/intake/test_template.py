"""The first nominal file: what is missing is refused by name until it is there."""

import polars as pl
import pytest

import locosweep as ls
from locosweep.diagnosis.data.noise import Noise
from locosweep.intake.log import Log
from locosweep.intake.template import keys_of, nominal_text

NOISE = {"x": Noise(1.2e-5, 1.1e-5, 5e-6, stated=False)}


def log(x="mm", drive="N"):
    return Log(pl.DataFrame(), [], units={"t": "s", "x": x, "drive": drive}, noise=NOISE)


def read(tmp_path, text):
    file = tmp_path / "n.toml"
    file.write_text(text)
    return ls.load_robot(file)


def test_a_full_file_reads_back(tmp_path):
    text, missing = nominal_text(log(), {"mass": 0.25, "mu_coulomb": 0.3, "limit": 2.0})
    assert missing == []
    robot = read(tmp_path, text)
    assert robot.parameters["mass"] == 0.25
    assert robot.parameters["drive_limit"] == 2.0
    assert robot.other == {"sensor.position_noise": 1.1e-5, "sensor.position_resolution": 5e-6}


def test_what_is_missing_is_named_and_refused(tmp_path):
    text, missing = nominal_text(log(drive="V"), {})
    assert missing == ["robot.mass", "surface.mu_coulomb", "drive.gain"]
    with pytest.raises(ls.DataFileError, match=r"\[robot\] mass is '\?': allowed is a number"):
        read(tmp_path, text)
    assert nominal_text(log(), {"coulomb_force": 0.8})[1] == ["robot.mass"]


def test_a_rotary_bench(tmp_path):
    given = {"mass": 0.01, "coulomb_force": 0.02, "gravity_torque": 0.0, "gain": 2.0}
    robot = read(tmp_path, nominal_text(log(x="deg", drive="V"), given)[0])
    assert "moment of inertia [kg m^2]" in nominal_text(log(x="deg", drive="V"), given)[0]
    assert robot.other["bench.kind"] == "rotary"
    assert "mu_coulomb" not in robot.parameters
    assert nominal_text(log(x="deg", drive="N m"), {})[1] == [
        "robot.mass", "surface.coulomb_force", "bench.gravity_torque"
    ]  # fmt: skip
    assert "mu_coulomb" not in keys_of(rotary=True)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"masss": 1.0}, "--set: unknown key 'masss': did you mean 'mass'"),
        ({"mass": -1.0}, "mass is -1"),
        ({"mu_coulomb": 0.3, "coulomb_force": 1.0}, "mu_coulomb and coulomb_force: allowed is one"),
    ],
)
def test_values_that_are_refused(given, words):
    with pytest.raises(ls.InputError, match=words):
        nominal_text(log(), given)
