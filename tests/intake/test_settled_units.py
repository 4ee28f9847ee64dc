"""Units over all files of a log: what they say, what sizes tell, and that they agree."""

import numpy as np
import polars as pl
import pytest

from locosweep.errors import InputError
from locosweep.files.csv_form import CsvForm
from locosweep.intake.sheet import opened
from locosweep.intake.units import settled_units

COUNT = 60
T = np.arange(COUNT) * 0.01


def settled(tmp_path, *files, given=None):
    """Units by role of each file, of which the columns are given."""
    sheets = []
    for k, columns in enumerate(files):
        path = tmp_path / f"{k}.csv"
        pl.DataFrame(columns, strict=False).write_csv(path)
        sheets.append(opened(path, {}, given or {}, CsvForm()))
    found = settled_units(sheets, given or {})
    return [{role: unit for role, (unit, _) in own.items()} for own in found]


def one(tmp_path, given=None, **columns):
    return settled(tmp_path, columns, given=given)[0]


@pytest.mark.parametrize(
    ("t", "unit"),
    [
        (T, "s"), (np.arange(COUNT) * 10.0, "ms"), (np.arange(COUNT) * 10.0 + 0.25, "ms"),
        (1_200_000_000 + np.arange(COUNT) * 10_000, "us"),
        (np.arange(COUNT) * 10_000_000 + 1_600_000_000_000_000, "ns"), (1764075181 + T, "s"),
        (1764075181000 + np.arange(COUNT) * 10.0, "ms"),
    ],
)  # fmt: skip
def test_times_by_size(tmp_path, t, unit):
    assert one(tmp_path, time=t, cmd=T, pos=T)["t"] == unit


def test_times_by_name(tmp_path):
    assert one(tmp_path, millis=T, cmd=T, pos=T)["t"] == "ms"
    assert one(tmp_path, time_us=T, cmd=T, pos=T)["t"] == "us"


@pytest.mark.parametrize(
    ("name", "x", "unit"),
    [("pos", T, "m"), ("pos", 40.0 * T, "mm"), ("theta", T, "rad"), ("angle", 40.0 * T, "deg")],
)
def test_positions_by_size_and_name(tmp_path, name, x, unit):
    assert one(tmp_path, t=T, cmd=T, **{name: x})["x"] == unit


@pytest.mark.parametrize("name", ["encoder", "enc_counts", "pos_ticks"])
def test_counts_are_asked_for(tmp_path, name):
    columns = {"t": T, "cmd": T, name if name != "enc_counts" else "encoder_counts": T}
    with pytest.raises(InputError, match="may be in any unit or plain counts: --unit x=mm"):
        settled(tmp_path, columns)
    assert settled(tmp_path, columns, given={"x": "mm"})[0]["x"] == "mm"


@pytest.mark.parametrize(
    ("drive", "x", "unit"),
    [
        ("cmd", "pos", "N"), ("cmd", "theta", "N m"), ("voltage", "pos", "V"), ("strom", "x", "A"),
        ("duty", "pos", "1"), ("torque", "pos", "N m"), ("u_V", "pos", "V"),
    ],
)  # fmt: skip
def test_drives_by_name(tmp_path, drive, x, unit):
    assert one(tmp_path, t=T, **{drive: T, x: T})["drive"] == unit


def test_other_readings_go_by_the_position(tmp_path):
    found = one(tmp_path, t=T, cmd=T, pos=40.0 * T, pos_rear=T, speed=T)
    assert (found["x_rear"], found["v"]) == ("mm", "mm/s")
    assert one(tmp_path, t=T, cmd=T, theta_deg=T, omega=T)["v"] == "deg/s"
    # The body of a rotary bench is not turned.
    assert one(tmp_path, t=T, cmd=T, theta_deg=T, pos_rear=T)["x_rear"] == "m"


def test_what_is_known_comes_first(tmp_path):
    columns = {"t_ms": T, "u_V": T, "pos_um": T}
    assert one(tmp_path, {"t": "us", "x": "cm"}, **columns) == {"t": "us", "x": "cm", "drive": "V"}
    assert one(tmp_path, **columns)["x"] == "um"


def test_one_guess_for_all_files(tmp_path):
    far, near = {"t": T, "cmd": T, "pos": 40.0 * T}, {"t": T, "cmd": T, "pos": T}
    assert [found["x"] for found in settled(tmp_path, far, near)] == ["mm", "mm"]
    said = {"t": T, "cmd": T, "pos_mm": T}
    assert [found["x"] for found in settled(tmp_path, far, said)] == ["mm", "mm"]
    cm = {"t": T, "cmd": T, "pos_cm": T}
    assert [found["x"] for found in settled(tmp_path, cm, said)] == ["cm", "mm"]


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        ({"cmd": T, "pos_mm": T}, {"cmd": T, "pos": T},
         r"1\.csv: x is in m \(nothing .*\), but in mm .*0\.csv: --unit x=UNIT says one for all"),
        ({"cmd": T, "pos_deg": T}, {"cmd": T, "pos_mm": T},
         r"1\.csv: x is in mm .* but in deg .*0\.csv: allowed are files of one rig"),
        ({"cmd_V": T, "x": T}, {"cmd_N": T, "x": T},
         r"1\.csv: drive is in N \(by its name\), but in V .*0\.csv: allowed are files of one rig"),
    ],
)  # fmt: skip
def test_files_that_differ_are_refused(tmp_path, first, second, words):
    with pytest.raises(InputError, match=words):
        settled(tmp_path, {"t": T, **first}, {"t": T, **second})
