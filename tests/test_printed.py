"""What files hold cannot steer a terminal, turn a line round, or become a formula."""

import json

import numpy as np
import polars as pl
import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.cli.options import note, show
from locosweep.errors import printable
from locosweep.files.atomic import write_frame
from locosweep.files.runs import load_runs

T = np.arange(30) * 0.01
EVIL = "a\x1b[2J\x9b31m\u202eb\r\nc"
SEEN = "a\\x1b[2J\\x9b31m\\u202eb  c"


def evil_runs(label=EVIL):
    return pl.DataFrame({"run": label, "t": -T, "drive": 0.0, "x": 0.0})


def test_text_in_one_line_without_control_characters():
    assert printable(EVIL) == SEEN
    assert printable("Größe µm 走") == "Größe µm 走"


def test_errors_show_labels_columns_and_cells_as_they_are_harmless():
    with pytest.raises(ls.DataFileError) as caught:
        load_runs(evil_runs())
    assert f"run {SEEN}, row 2, column t" in str(caught.value)
    with pytest.raises(ls.InputError) as caught:
        load_runs(evil_runs().rename({"t": EVIL}))
    assert "\x1b" not in str(caught.value)
    with pytest.raises(ls.InputError) as caught:
        ls.sweep(EVIL)
    assert "\x1b" not in str(caught.value)


def test_commands_print_nothing_that_steers(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    evil_runs().write_parquet("r.parquet")
    assert main(["simulate", "--model", "m\x1b.toml", "--runs", "r", "--out", "o.csv"]) == 2
    (tmp_path / "n.toml").write_text("[robot]\nmass=0.2\n[surface]\nmu_coulomb=0.3\n")
    assert main(["diagnose", "r.parquet", "--nominal", "n.toml", "--out", "d", "--quiet"]) == 2
    assert main(["quantities", EVIL]) == 2
    note(EVIL)
    done = capsys.readouterr()
    assert SEEN.replace("  ", " ") in done.err
    for char in "\x1b\x9b\u202e\r":
        assert char not in done.err
    assert done.err.count("\n") == 4


def test_results_are_printed_in_their_lines(capsys):
    show(False, {}, "one\ntwo", "\x1b[2J", None)
    assert capsys.readouterr().out == "one\ntwo\n\\x1b[2J\n"
    show(True, {"run": "\x9b\x1b\x7f"})
    out = capsys.readouterr().out
    assert not set("\x9b\x1b\x7f") & set(out)
    assert json.loads(out) == {"run": "\x9b\x1b\x7f"}


@pytest.mark.parametrize(
    ("label", "written"),
    [
        ("=1+1", "'=1+1"), ("@SUM(A1)", "'@SUM(A1)"), ("+a", "'+a"), ("-a", "'-a"),
        ("\t=1", "' =1"), ("-1", "-1"), ("+2.5e3", "+2.5e3"), ("run 1", "run 1"),
        ("\x1b[2J", "\\x1b[2J"), ("a=b", "a=b"),
    ],
)  # fmt: skip
def test_labels_in_csv_are_no_formulas(tmp_path, label, written):
    frame = pl.DataFrame({"run": [label, "other", None], "x": [-1.5, 2.0, 3.0]})
    write_frame(tmp_path / "r.csv", frame)
    read = pl.read_csv(tmp_path / "r.csv", infer_schema=False)
    assert read["run"].to_list() == [written, "other", None]
    assert read["x"].to_list() == ["-1.5", "2.0", "3.0"]
    # Parquet holds no formulas, and keeps what it is given.
    write_frame(tmp_path / "r.parquet", frame)
    assert pl.read_parquet(tmp_path / "r.parquet")["run"][0] == label
