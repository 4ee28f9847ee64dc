"""Runs from several files, a folder, standard input, and frames of any maker."""

import io
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas
import polars as pl
import pytest

from locosweep.errors import DataFileError, InputError
from locosweep.files import raw
from locosweep.files.runs import load_runs, runs_from_frame
from locosweep.files.sources import files_of, frame_of, names_of

T = np.arange(25) * 0.01
PLAIN = pl.DataFrame({"t": T, "drive": 0.5, "x": T**2})


class ArrowTable:
    """What a table of pyarrow shows of itself."""

    def __arrow_c_stream__(self, requested_schema=None):
        return PLAIN.__arrow_c_stream__(requested_schema)


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def labels(data, **options):
    return [run.label for run in load_runs(data, **options)[0]]


def test_a_file_is_a_run_where_it_has_no_column_of_them():
    Path("a").mkdir()
    PLAIN.write_csv("a/run2.csv")
    PLAIN.write_csv("a/run10.csv")
    PLAIN.write_parquet("a/late.parquet")
    Path("a/notes.txt").write_text("no runs")
    Path("a/.hidden.csv").write_text("no runs")
    assert labels("a") == ["late", "run2", "run10"]
    assert labels(["a/run2.csv", "a/late.parquet"]) == ["run2", "late"]
    # One file alone needs no name.
    assert labels("a/run2.csv") == ["0"]


def test_labels_that_come_in_several_files_have_the_file_before_them():
    two = pl.concat([PLAIN.with_columns(run=pl.lit(one)) for one in ("1", "2")])
    two.write_csv("mon.csv")
    two.write_csv("tue.csv")
    PLAIN.with_columns(run=pl.lit("own")).write_csv("wed.csv")
    given = ["mon.csv", "tue.csv", "wed.csv"]
    assert labels(given) == ["mon:1", "mon:2", "tue:1", "tue:2", "own"]


def test_files_of_one_name_have_their_folder_before_them():
    assert names_of([Path("a/r.csv.gz"), Path("b/r.csv"), Path("c.csv")]) == ["a/r", "b/r", "c"]


def test_standard_input(monkeypatch):
    raw._standard_input.cache_clear()
    stream = io.TextIOWrapper(io.BytesIO(PLAIN.write_csv(separator=";").encode()))
    monkeypatch.setattr(sys, "stdin", stream)
    np.testing.assert_array_equal(load_runs("-")[0][0].t, T)
    # Its digest reads it once more.
    assert raw.stored(Path("-")).startswith(b"t;drive;x")
    raw._standard_input.cache_clear()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ([], "runs is empty"),
        ("empty", "empty: no file in it ends in .csv"),
        (["r.csv", "r.csv"], "r.csv is given twice"),
        (["r.csv", 5], "runs has a int: allowed are paths"),
        (["r.csv", "gone.csv"], "gone.csv: no such file"),
        (5, "runs is a int: allowed are files, frames and mappings"),
        (np.zeros((3, 3)), "runs is a ndarray"),
    ],
)
def test_what_is_no_source(given, words):
    Path("empty").mkdir()
    PLAIN.write_csv("r.csv")
    with pytest.raises(InputError, match=words):
        load_runs(given)


def test_frames_of_every_maker():
    arrays = {name: PLAIN[name].to_numpy() for name in PLAIN.columns}
    gone = pandas.DataFrame(arrays).astype({"x": "Float64"})
    gone.loc[3, "x"] = pandas.NA
    structured = np.rec.fromarrays(list(arrays.values()), names=list(arrays))
    for frame in (pandas.DataFrame(arrays), ArrowTable(), PLAIN.lazy(), arrays, structured):
        (run,), notices = load_runs(frame)
        np.testing.assert_array_equal(run.channels["x"], T**2)
        assert notices == []
    (run,), _ = load_runs(gone)
    assert np.flatnonzero(np.isnan(run.channels["x"])).tolist() == [3]
    named = pandas.DataFrame({**arrays, "run": ["a"] * 25}).rename(columns={"x": "pos"})
    (run,), _ = load_runs(named, {"x": "pos"}, {"x": "mm"})
    assert (run.label, run.channels["x"][10]) == ("a", T[10] ** 2 * 1e-3)


def test_pandas_without_arrow():
    script = (
        "import sys; sys.modules['pyarrow'] = None; import pandas, numpy; "
        "from locosweep.files.runs import load_runs; "
        "f = pandas.DataFrame({'t': numpy.arange(25.0), 'drive': 0.0, 'x': 0.0, 'run': 'a'}); "
        "print(load_runs(f)[0][0].label)"
    )
    done = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True)
    assert done.stdout == b"a\n"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"run": [["a"]] * 25}, "column run has type List.*: allowed are text and numbers"),
        ({"run": [b"\xff"] * 25}, "column run has type Binary"),
        ({"run": [{"a": 1}] * 25}, "column run has type Struct"),
        ({"run": ["a" * 201] * 25}, "row 1, column run: a label of more than 200 characters"),
        ({"x": [[1.0]] * 25}, "column x has type List"),
        ({"x": [b"1"] * 25}, "column x has type Binary"),
        ({"x": [True] * 25}, "column x has type Boolean"),
    ],
)
def test_columns_of_odd_kinds(changes, words):
    frame = PLAIN.with_columns(pl.Series(name, values) for name, values in changes.items())
    frame.write_parquet("r.parquet")
    for given in (frame, "r.parquet"):
        with pytest.raises(DataFileError, match=words):
            load_runs(given)


@pytest.mark.parametrize("frame", [PLAIN.head(0), PLAIN.select([]), pl.DataFrame()])
def test_empty_frames_and_files(frame):
    frame.write_parquet("r.parquet")
    with pytest.raises(InputError, match="runs: no "):
        runs_from_frame(frame)
    with pytest.raises(DataFileError, match=r"r\.parquet: no "):
        load_runs("r.parquet")


def test_whole_numbers_without_a_limit():
    with pytest.raises(InputError, match="runs: "):
        load_runs({"t": T, "drive": T, "x": [10**400] * 25})
    Path("r.csv").write_text("t,drive,x\n" + f"0,0,{10**400}\n" * 25)
    with pytest.raises(DataFileError, match="row 1, column x: infinite"):
        load_runs("r.csv")


def test_arrow_streams_are_taken_once():
    frame = frame_of(PLAIN.lazy())
    assert frame.equals(PLAIN)
    assert files_of("r.csv") == [Path("r.csv")]
