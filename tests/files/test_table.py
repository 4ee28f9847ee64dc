"""Wanted columns of files and frames: names, units that the file states, decimal commas."""

import gzip

import numpy as np
import polars as pl
import pytest

from locosweep.errors import DataFileError, InputError
from locosweep.files.csv_form import CsvForm
from locosweep.files.runs import load_runs

COUNT = 30


def written(tmp_path, head, row, count=COUNT):
    """A file whose rows are made of their number."""
    file = tmp_path / "log.csv"
    file.write_text("\n".join([head, *(row(k) for k in range(count))]) + "\n")
    return file


def test_decimal_commas(tmp_path):
    file = written(tmp_path, "t;drive;x", lambda k: f"{k},0;0,5;{k},125".replace(".", ","))
    (run,), notices = load_runs(file)
    assert run.drive[0] == 0.5
    assert run.channels["x"][3] == 3.125
    assert notices == [f"{file}: read with decimal commas"]


@pytest.mark.parametrize(
    ("form", "x"), [(CsvForm(decimal="comma"), 1.234), (CsvForm(decimal="point"), 1234.0)]
)
def test_digits_in_groups_and_decimal_commas_look_alike(tmp_path, form, x):
    file = written(tmp_path, "t;drive;x", lambda k: f"{k};0;1,234")
    words = "row 1, column x: '1,234' may be 1.234 or 1234: --decimal comma or --decimal point"
    with pytest.raises(DataFileError, match=words):
        load_runs(file)
    (run,), _ = load_runs(file, form=form)
    assert run.channels["x"][0] == x


@pytest.mark.parametrize(
    ("head", "row", "x"),
    [
        # One number that is sure settles the file.
        ("t;drive;x", lambda k: f"{k};{'0,25' if k == 20 else '0'};1,234", 1.234),
        ("t;drive;x", lambda k: f"{k};0;0,123", 0.123),
        ("t,drive,x", lambda k: f'{k},"0,5","2,25"', 2.25),
    ],
)
def test_commas_that_are_decimal(tmp_path, head, row, x):
    (run,), _ = load_runs(written(tmp_path, head, row))
    assert run.channels["x"][0] == x


def test_commas_among_points_are_groups_and_refused(tmp_path):
    file = written(tmp_path, "t;drive;x", lambda k: f"{k}.5;0;1,234")
    words = "row 1, column x: '1,234' is not a number: --decimal point takes its commas as groups"
    with pytest.raises(DataFileError, match=words):
        load_runs(file)
    assert load_runs(file, form=CsvForm(decimal="point"))[0][0].channels["x"][0] == 1234.0
    mixed = written(tmp_path, "t;drive;x", lambda k: f"{k};0;1,234.5")
    with pytest.raises(DataFileError, match=r"'1,234\.5' is not a number: --decimal point"):
        load_runs(mixed)
    file = written(tmp_path, "t;drive;x", lambda k: f"{k}.5;0;1,25")
    with pytest.raises(DataFileError, match=r"row 1, column t: '0\.5' has a decimal point, others"):
        load_runs(file)


def test_no_group_of_digits_begins_with_zero(tmp_path):
    file = written(tmp_path, "t;drive;x", lambda k: f"{k};0;0,123")
    with pytest.raises(DataFileError, match="row 1, column x: '0,123' is not a number"):
        load_runs(file, form=CsvForm(decimal="point"))


def test_a_column_may_bear_another_name_of_ours(tmp_path):
    file = written(tmp_path, "t,v,x", lambda k: f"{k},5,{k}")
    for data in (file, pl.read_csv(file)):
        (run,), _ = load_runs(data, {"drive": "v"})
        assert (run.drive[0], list(run.channels)) == (5.0, ["x"])
        with pytest.raises(InputError, match="no column x beside that for drive: there are t, v"):
            load_runs(data, {"drive": "x"})
        with pytest.raises(InputError, match="column: drive and x are both v: allowed is one"):
            load_runs(data, {"drive": "v", "x": "v"})
    file = written(tmp_path, "t,v [V],x", lambda k: f"{k},5,{k}")
    (run,), _ = load_runs(file, {"drive": "v [V]"})
    assert (run.drive[0], list(run.channels)) == (5.0, ["x"])


def test_a_row_of_units(tmp_path):
    file = written(tmp_path, "t;drive;x\nms;[N];(mm)", lambda k: f"{k};0;{k}")
    (run,), notices = load_runs(file)
    assert run.t[2] == 0.002
    assert run.channels["x"][2] == 0.002
    assert notices == [f"{file}: a row below the names gives units: t in ms, drive in N, x in mm"]
    # What a user says comes first.
    assert load_runs(file, units={"x": "cm"})[0][0].channels["x"][2] == 0.02


@pytest.mark.parametrize(
    ("cell", "x"), [("{}.5 mm", 3.5e-3), ("{}e1N", None), ("{}e3", 3e3), ("{} mmm", None)]
)
def test_units_in_cells(tmp_path, cell, x):
    file = written(tmp_path, "t,drive,x", lambda k: f"{k},0,{cell.format(k)}")
    if x is None:
        with pytest.raises(DataFileError, match=r"is not a number|unit of x: N measures"):
            load_runs(file)
        return
    assert load_runs(file)[0][0].channels["x"][3] == pytest.approx(x)
    mixed = written(tmp_path, "t,drive,x", lambda k: f"{k},0,{k} {'mm' if k else 'cm'}")
    with pytest.raises(DataFileError, match="row 1, column x: '0 cm' is not a number"):
        load_runs(mixed)


def test_units_in_brackets_behind_the_names(tmp_path):
    file = written(tmp_path, "t [ms],drive (N),x[mm],note (left)", lambda k: f"{k},0,{k},a")
    (run,), notices = load_runs(file)
    assert run.t[2] == run.channels["x"][2] == 0.002
    assert "columns not used: note (left)" in notices[0]


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ("t,drive,x\ns,N,furlongg", "row 1, column t: 's' is not a number"),
        ("t,drive,x\ns,N,kN", "unit of x: kN measures something else"),
        ("t,drive,x [kN]", "unit of x: kN measures something else"),
        ("t,drive,x\nt,drive,x", "row 1, column t: 't' is not a number"),
        ("t,drive,x\n-,1,-", "row 1, column t: '-' is not a number"),
        ("t,drive,x [mm],x (cm)", None),
        ("t,drive,x,x", "column x is there twice"),
    ],
)
def test_rows_that_are_no_units(tmp_path, head, words):
    width = head.splitlines()[0].count(",") + 1
    file = written(tmp_path, head, lambda k: ",".join([str(k)] * width))
    with pytest.raises(DataFileError, match=words or "column x is there twice"):
        load_runs(file)


def test_other_columns_may_share_a_name(tmp_path):
    file = written(tmp_path, "t,drive,x,note,note,", lambda k: f"{k},0,{k},,,")
    (run,), notices = load_runs(file)
    assert run.t.size == COUNT
    assert notices == [f"{file}: columns not used: note, note, "]


def test_gzip(tmp_path):
    plain = written(tmp_path, "t,drive,x", lambda k: f"{k},0,{k}")
    packed = tmp_path / "log.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    np.testing.assert_array_equal(load_runs(packed)[0][0].t, load_runs(plain)[0][0].t)
    packed.write_bytes(packed.read_bytes()[:-20])
    with pytest.raises(DataFileError, match=r"log\.csv\.gz: "):
        load_runs(packed)


def test_parquet_with_text_reads_as_csv_does(tmp_path):
    frame = pl.DataFrame({"t": [f"{k},5" for k in range(COUNT)], "drive": "0", "x": "0,25"})
    frame.write_parquet(tmp_path / "a.parquet")
    (run,), _ = load_runs(tmp_path / "a.parquet")
    assert (run.t[0], run.channels["x"][0]) == (0.5, 0.25)


def test_forms_that_are_none():
    with pytest.raises(InputError, match="separator is 'x': allowed are tab, semicolon, comma"):
        CsvForm(separator="x")
    with pytest.raises(InputError, match="decimal is ',': allowed are point, comma"):
        CsvForm(decimal=",")
