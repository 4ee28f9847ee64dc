"""CSV files as loggers and spreadsheets write them."""

import polars as pl
import pytest

from locosweep.errors import DataFileError
from locosweep.files.csv_text import frame_of, parsed


def read(data, separator=None):
    text = parsed(data if isinstance(data, bytes) else data.encode(), "log.csv", separator)
    return text, frame_of(text, "log.csv", range(len(text.names)))


ROWS = [["0", "1", "2"], ["0.5", "-1e-3", ""], ["1", "7", "8"]]


@pytest.mark.parametrize("separator", [",", ";", "\t", "|"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("code", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_every_dialect_reads_the_same(separator, end, code):
    lines = ["t,drive,größe".replace(",", separator), *(separator.join(row) for row in ROWS)]
    text, frame = read((end.join(lines) + end).encode(code))
    assert text.names == ["t", "drive", "größe"]
    assert text.separator == separator
    assert [[cell or "" for cell in row] for row in frame.rows()] == ROWS
    assert frame.dtypes == [pl.String] * 3


def test_comments_and_blank_lines_are_left_out_wherever_they_stand():
    text, frame = read('# a rig\n\n% 2026\n// again\nt,x\n0,"1"\n\n# pause\n1,2\n\n')
    assert text.names == ["t", "x"]
    assert frame.rows() == [("0", "1"), ("1", "2")]
    assert text.comments == 1


def test_a_separator_that_excel_states_is_no_row():
    assert read("sep=;\nt;x\n0;1\n")[0].names == ["t", "x"]


def test_names_in_a_comment_as_numpy_writes_them():
    text, frame = read("# t,x\n0,1\n2,3\n")
    assert text.names == ["t", "x"]
    assert frame.rows() == [("0", "1"), ("2", "3")]


def test_a_comma_within_names_is_no_separator():
    assert read("t;x, left;drive\n0;1,5;2\n1;2;3\n")[0].names == ["t", "x, left", "drive"]
    assert read("t, s;x, m\n0,1;0,2\n")[0].separator == ";"


def test_a_separator_that_is_given_counts():
    assert read("a;b,c\n1;2,3\n", "comma")[0].names == ["a;b", "c"]


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "empty"),
        (b"# only a comment\n\n", "empty"),
        (b"0,1\n2,3\n", "its first line holds numbers"),
        (b"0,5;1,5\n2,5;3,5\n", "its first line holds numbers"),
        (b"t,x\n0,1\n2\n", "row 2 has 1 values, there are 2 names"),
        (b"t,x\n0,1\n\n# note\n2\n", "row 2 has 1 values"),
        (b't,x\n0,"1"\n"2"\n', "row 2 has 1 values"),
        (b"t,x\n0,1\n2,3,4\n", "row 2 has 3 values"),
        (b"t,x\n0,1,0,2\n", "row 1 has 4 values, there are 2 names: decimal commas need another"),
        (b't,x\n0,"1\n2,3\n', "row 1: unexpected end of data"),
        (b"t,x\n0,1\n2,\0\n", "line 3: a NUL byte"),
        (b"t,x\n0,\xff\x1b[2J\n", "line 2: neither UTF-8 nor Latin-1"),
        (b"a;b,c\nu;v,w\nx;y,z\n", "separated by semicolon or comma: --separator settles it"),
        (b"\xff\xfet\xd8", "not text"),
    ],
)
def test_what_is_refused_is_named(data, words):
    with pytest.raises(DataFileError, match=f"log.csv: .*{words}") as caught:
        read(data)
    assert "\n" not in str(caught.value)


def test_some_columns_alone():
    text = parsed(b"a,b,c\n1,2,3\n", "log.csv")
    assert frame_of(text, "log.csv", [2, 0]).to_dict(as_series=False) == {"0": ["1"], "2": ["3"]}
