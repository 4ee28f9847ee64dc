"""Guesses about columns from their names and values."""

import numpy as np
import polars as pl
import pytest

from locosweep.errors import InputError
from locosweep.intake.guess import guess_columns, numbers_of

COUNT = 60
T = np.arange(COUNT) * 0.01


def guessed(columns=None, units=None, **values):
    frame = pl.DataFrame(values, strict=False)
    found, left = guess_columns(frame.columns, frame, columns or {}, units or {}, "log.csv")
    return {role: name for role, (name, _) in found.items()}, left


def test_names_and_what_a_user_says():
    values = {"time": T, "cmd": 0 * T, "pos": T, "enc": T}
    assert guessed(**values)[0] == {"t": "time", "drive": "cmd", "x": "pos"}
    said = guessed({"x": "enc"}, **values)[0]
    assert said == {"x": "enc", "t": "time", "drive": "cmd"}


def test_time_is_what_rises_where_no_name_tells():
    assert guessed(a=T, cmd=0 * T, pos=np.sin(9 * T))[0]["t"] == "a"
    # pandas writes an index without a name.
    assert guessed(**{"": T}, cmd=0 * T, pos=T)[0]["t"] == ""
    # A column that is called time but falls is none.
    assert guessed(time=-T, a=T, cmd=0 * T, pos=np.sin(9 * T))[0]["t"] == "a"


def test_labels_that_differ_in_every_row_name_no_run():
    values = {"t": T, "drive": 0 * T, "x": T}
    found, left = guessed(run=np.arange(COUNT), **values)
    assert "run" not in found
    assert left == ["run is not taken for run: it has 60 labels in 60 rows"]
    assert guessed(run=np.arange(COUNT) // 30, **values)[0]["run"] == "run"


def test_a_number_of_rows_is_no_time():
    with pytest.raises(InputError, match="no column seems to be t: --column t=NAME says it"):
        guessed(Nr=np.arange(COUNT), cmd=0 * T, pos=np.sin(9 * T))


def test_the_word_that_says_more_is_taken():
    assert guessed(time=T, cmd=T, pos=T, Position=T)[0]["x"] == "Position"


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"time": T, "cmd": T, "encoder1": T, "encoder2": T},
         "x may be encoder1 or encoder2: --column x=encoder1 settles it"),
        ({"time": T, "cmd": T, "pos_1": T, "pos_2": T}, "x may be pos_1 or pos_2"),
        ({"time": T, "cmd": T}, "no column seems to be x: --column x=NAME says it"),
        ({"time": T, "pos": T}, "no column seems to be drive"),
        ({"cmd": T, "pos": T}, "no column seems to be t"),
        ({"time": T, "cmd": T, "pos": ["a"] * COUNT},
         "no column can be x: pos: row 1 has 'a', which is no number"),
        ({"time": T, "cmd": T, "pos": [*map(str, T[:-1]), "OFF"]},
         "no column can be x: pos: row 60 has 'OFF'"),
        ({"time": T, "cmd": T, "pos": ["mm", "[mm]", *map(str, T[2:])]},
         r"no column can be x: pos: row 1 has '\[mm\]'"),
        ({"time": ["25/11/2025 12:00"] * COUNT, "cmd": 0 * T, "pos": 0 * T},
         "no column can be t: time: row 1 has '25/11/2025 12:00', which is no number and no time"),
        ({"time": -T, "cmd": T, "pos": -T}, "no column can be t: time: it does not rise"),
    ],
)  # fmt: skip
def test_what_no_name_tells_is_asked_for(values, words):
    with pytest.raises(InputError, match=f"log.csv: {words}"):
        guessed(**values)


def test_dates_spans_and_groups_of_digits_are_seen():
    plain = {"cmd": 0 * T, "pos": 0 * T}
    dates = [f"25.11.2025 12:53:{second:05.2f}" for second in T]
    assert guessed(Datum=dates, **plain)[0]["t"] == "Datum"
    spans = pl.Series(np.arange(COUNT) * 1000).cast(pl.Duration("us"))
    assert guessed(time=spans, **plain)[0]["t"] == "time"
    groups = [f"{1000 + k:,.1f}" for k in range(COUNT)]
    assert guessed(time=T, cmd=0 * T, pos=groups)[0]["x"] == "pos"


def test_what_a_column_measures_goes_by_the_rig():
    values = {"t": T, "cmd": 0 * T, "motor_rpm": T, "speed_rpm": T}
    assert "v" not in guessed(pos_mm=T, **values)[0]
    assert guessed(pos_deg=T, **values)[0]["v"] == "speed_rpm"
    assert guessed(theta=T, **values)[0]["v"] == "speed_rpm"
    assert guessed(pos=["deg", *map(str, T[1:])], **values)[0]["v"] == "speed_rpm"
    assert guessed(units={"x": "deg"}, pos=T, **values)[0]["v"] == "speed_rpm"


def test_a_column_that_cannot_be_one_is_named():
    found, left = guessed(t=T, drive=T, x=T, v=["a"] * COUNT)
    assert "v" not in found
    assert left == ["v is not taken for v: row 1 has 'a', which is no number"]


def test_other_columns_that_are_alike_are_left_out_and_named():
    found, left = guessed(t=T, drive=T, x=T, force1=T, force2=T)
    assert "force" not in found
    assert left == ["force may be force1 or force2: --column force=NAME takes one"]


def test_numbers_of_odd_columns():
    assert numbers_of(pl.Series(["1,5", " 2.5", "x", None]))[:2].tolist() == [1.5, 2.5]
    assert numbers_of(pl.Series(["1,234.5", "-1,000.0"])).tolist() == [1234.5, -1000.0]
    assert np.isnan(numbers_of(pl.Series([[1.0]])))
    assert np.isnan(numbers_of(pl.Series(["2026-11-25T12:00:00", "x"]))).all()
