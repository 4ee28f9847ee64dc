"""CSV files as loggers and spreadsheets write them."""

import re

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


def test_names_in_a_comment_as_rostopic_writes_them():
    text, frame = read(
        "%time,frame,pos\n1764075181000000000,base,0.5\n1764075181010000000,base,1\n"
    )
    assert text.names == ["time", "frame", "pos"]
    assert frame.rows()[0] == ("1764075181000000000", "base", "0.5")
    assert read("# 7 runs, rig 3, new\nt,name,x\n0,a,1\n")[0].names == ["t", "name", "x"]


@pytest.mark.parametrize(
    "head", ["% t [s]   F [N]   pos x\n", "t\tF\tx\n", "# t F x\n", "  t  F  x  \n"]
)
def test_columns_between_blanks(head):
    text, frame = read(head + "  0.00  -1.5   2e-3\n   0.01   1     3  \n")
    assert len(text.names) == 3
    assert frame.rows() == [("0.00", "-1.5", "2e-3"), ("0.01", "1", "3")]


ABOVE = "Device,USB-6001\nRate,100 Hz\n\nChannels,2\n"
LABVIEW = (
    "LabVIEW Measurement\t\nDecimal_Separator\t,\n***End_of_Header***\t\n\t\nSamples\t9\t9\t\n"
    "Date\t2025/11/25\t2025/11/25\t\nY_Unit_Label\tNewton\tMillimeter\t\n***End_of_Header***\t\t\t\n"
)


@pytest.mark.parametrize(
    ("above", "head", "row", "count"),
    [
        (ABOVE, "t,drive,x", "0.5,1,2", 3),
        (ABOVE, "t,drive,x\ns,N,mm", "0.5,1,2", 3),
        (LABVIEW, "X_Value\tForce\tPosition\tComment", "0,5\t1,5\t2,5\t", 7),
        ("Rig v1.2 ready\n", "t;x", "0,5;1,5", 1),
    ],
)
def test_lines_above_the_names_are_left_out(above, head, row, count):
    text, frame = read(above + head + "\n" + "\n".join([row] * 30))
    assert ["".join(text.names), text.above] == [
        "".join(re.split(r"[,;\t]", head.split("\n")[0])), count
    ]  # fmt: skip
    assert frame.height == 30 + head.count("\n")
    # A row that is too long is none of them.
    with pytest.raises(DataFileError, match="row 30 has"):
        read(head + "\n" + "\n".join([row] * (29 - head.count("\n"))) + f"\n{row},1;1\t1\n{row}")


def test_the_serial_monitor_of_arduino():
    lines = ["12:53:00.900 -> Rig v1.2 ready", "12:53:00.950 -> millis,pos"]
    lines += [f"12:53:01.{k:03d} -> {k},0.5" for k in range(30)]
    text, frame = read("\n".join(lines))
    assert (text.names, text.above, frame.rows()[7]) == (["millis", "pos"], 1, ("7", "0.5"))


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
