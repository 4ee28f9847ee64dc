"""What names of columns say."""

import pytest

from locosweep.files.runs import wanted_columns
from locosweep.intake.names import ROLES, fits, speaks_for, unit_in, words_of

ALLOWED = wanted_columns()


def role_of(name):
    """The role that a name speaks for most."""
    scores = {role: speaks_for(name, role, ALLOWED) for role in ROLES}
    spoken = {role: score for role, score in scores.items() if score is not None}
    return max(spoken, key=spoken.get, default=None)


@pytest.mark.parametrize(
    ("name", "role"),
    [
        ("t", "t"), ("Zeit [s]", "t"), ("time_ms", "t"), ("Timestamp", "t"), ("t_unix_ms", "t"),
        ("millis", "t"),
        ("x", "x"), ("Position_mm", "x"), ("Weg/mm", "x"), ("Istposition_mm", "x"),
        ("headDisplacement (mm)", "x"), ("theta_deg", "x"), ("x_rear", "x_rear"),
        ("pos_rear_mm", "x_rear"), ("body position", "x_rear"), ("drive", "drive"),
        ("Soll_N", "drive"), ("Sollkraft_N", "drive"), ("motorCmd", "drive"), ("u", "drive"),
        ("motor_current_A", "drive"), ("position_setpoint", None), ("x_soll", None),
        ("speed_cmd", None), ("speed_cmd_percent", "drive"), ("Sollkraft_x_N", "drive"),
        ("torque_N_m", "drive"), ("DUTY_PCT", "drive"), ("POS_MM", "x"), ("pos_1", "x"),
        ("pos_a", "x"), ("pos_act", "x"), ("pos_pin", "x"), ("force_A", "force"), ("x_A", "x"),
        ("load_position_mm", "x"), ("speed_mm_per_s", "v"), ("Kraft (N)", "force"),
        ("loadcell", "force"), ("speed_mm_s", "v"), ("v [mm/s]", "v"), ("Leistung W", "power"),
        ("Versuch", "run"), ("run", "run"), ("slope_deg", "slope_deg"), ("tilt [deg]", "slope_deg"),
        ("Temperatur", None), ("index", None), ("Position_kN", None), ("time_mm", None),
        ("speed_s", None), ("target", None),
    ],
)  # fmt: skip
def test_roles(name, role):
    assert role_of(name) == role


def test_a_setpoint_in_length_is_no_drive_and_no_position():
    assert role_of("Position_soll_mm") is None


@pytest.mark.parametrize(
    ("name", "parts"),
    [
        ("Position_mm", ("Position", "mm")), ("speed mm/s", ("speed", "mm/s")),
        ("speed_mm_s", ("speed", "mm/s")), ("x [mm]", ("x", "mm")), ("x(mm)", ("x", "mm")),
        ("mm", ("mm", "")), ("pos_left", ("pos_left", "")), ("x (left)", ("x (left)", "")),
        ("", ("", "")), ("torque_N_m", ("torque", "N m")), ("cmd_NM", ("cmd_NM", "")),
        ("v_mm_per_s", ("v", "mm/s")), ("omega deg/s", ("omega", "deg/s")), ("T_ms", ("T", "ms")),
        ("pos_1", ("pos_1", "")), ("pos_a", ("pos_a", "")), ("cmd_b", ("cmd_b", "")),
        ("enc_counts", ("enc_counts", "")), ("Weg/mm", ("Weg", "mm")), ("A/B", ("A/B", "")),
    ],
)  # fmt: skip
def test_units_at_the_end_of_names(name, parts):
    assert unit_in(name) == parts


def test_words_and_units():
    assert words_of("IstPosition2_raw") == ["ist", "position", "raw"]
    assert words_of("Sollkraft") == ["soll", "kraft"]
    assert words_of("Solo") == ["solo"]
    assert fits("x", "mm", ("m", "rad"))
    assert not fits("x", "N", ("m", "rad"))
