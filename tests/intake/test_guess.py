"""Guesses about columns from their names and values."""

import numpy as np
import polars as pl
import pytest

from locosweep.errors import InputError
from locosweep.intake.guess import guess_columns, guess_units, numbers_of

COUNT = 60
T = np.arange(COUNT) * 0.01


def guessed(columns=None, **values):
    frame = pl.DataFrame(values)
    found, left = guess_columns(frame.columns, frame, columns or {}, "log.csv")
    return {role: name for role, (name, _) in found.items()}, left


def test_names_and_what_a_user_says():
    values = {"time": T, "cmd": 0 * T, "pos": T, "enc": T}
    assert guessed(**values)[0] == {"t": "time", "drive": "cmd", "x": "pos"}
    said = guessed({"x": "enc"}, **values)[0]
    assert said == {"x": "enc", "t": "time", "drive": "cmd"}


def test_time_is_what_rises_where_no_name_tells():
    assert guessed(a=T, cmd=0 * T, pos=np.sin(9 * T))[0]["t"] == "a"
    # A column that is called time but falls is none.
    assert guessed(time=-T, a=T, cmd=0 * T, pos=np.sin(9 * T))[0]["t"] == "a"


def test_labels_that_differ_in_every_row_name_no_run():
    values = {"t": T, "drive": 0 * T, "x": T}
    assert "run" not in guessed(run=np.arange(COUNT), **values)[0]
    assert guessed(run=np.arange(COUNT) // 30, **values)[0]["run"] == "run"


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"time": T, "cmd": T, "pos": T, "Position": T}, None),
        ({"time": T, "cmd": T, "encoder1": T, "encoder2": T},
         "x may be encoder1 or encoder2: --column x=encoder1 settles it"),
        ({"time": T, "cmd": T}, "no column seems to be x: --column x=NAME says it"),
        ({"time": T, "pos": T}, "no column seems to be drive"),
        ({"cmd": T, "pos": T}, "no column seems to be t"),
        ({"time": T, "cmd": T, "pos": ["a"] * COUNT}, "no column seems to be x"),
    ],
)  # fmt: skip
def test_what_no_name_tells_is_asked_for(values, words):
    if words is None:
        assert guessed(**values)[0]["x"] == "Position"
        return
    with pytest.raises(InputError, match=f"log.csv: {words}"):
        guessed(**values)


def test_other_columns_that_are_alike_are_left_out_and_named():
    found, left = guessed(t=T, drive=T, x=T, force1=T, force2=T)
    assert "force" not in found
    assert left == ["force may be force1 or force2: --column force=NAME takes one"]


@pytest.mark.parametrize(
    ("t", "x", "units"),
    [
        (T, T, ("s", "m")),
        (np.arange(COUNT) * 10.0, T, ("ms", "m")),
        (1764075181 + T, T, ("s", "m")),
        (1764075181000 + np.arange(COUNT) * 10.0, T, ("ms", "m")),
        (T, 40.0 * T, ("s", "mm")),
    ],
)
def test_units_by_size(t, x, units):
    names = {"t": ("time", ""), "x": ("pos", "")}
    found = guess_units(names, {}, {}, {"t": t, "x": x})
    assert (found["t"][0], found["x"][0]) == units


def test_units_by_what_is_known():
    names = {"t": ("t_ms", ""), "x": ("pos_um", ""), "drive": ("u_V", "")}
    values = {"t": T, "x": T}
    found = guess_units(names, {"x": "cm"}, {"t": "us"}, values)
    assert {role: unit for role, (unit, _) in found.items()} == {"t": "us", "x": "cm", "drive": "V"}
    assert guess_units(names, {}, {}, values)["x"] == ("um", "by its name")


def test_numbers_of_odd_columns():
    assert numbers_of(pl.Series(["1,5", " 2.5", "x", None]))[:2].tolist() == [1.5, 2.5]
    assert np.isnan(numbers_of(pl.Series([[1.0]])))
    assert np.isnan(numbers_of(pl.Series(["2026-11-25T12:00:00", "x"]))).all()
