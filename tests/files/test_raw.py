"""Files that hold more than is read are refused before they fill the memory."""

import gzip
import io
import json
import subprocess
import sys

import polars as pl
import pytest

from locosweep.errors import DataFileError
from locosweep.files import raw, table
from locosweep.files.raw import contents, stored
from locosweep.files.runs import load_runs
from locosweep.files.toml import read

MEMORY = """
import json, sys
from locosweep.errors import DataFileError
from locosweep.files.runs import load_runs
try:
    load_runs(sys.argv[1])
    said = "read"
except DataFileError as error:
    said = str(error)
# Not ru_maxrss, which a process inherits from the one that started it.
peak = next(line for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(json.dumps([said, int(peak.split()[1]) / 1e6]))
"""


def reading(file):
    """What reading a file said, and the memory that it took, in GB."""
    done = subprocess.run(
        [sys.executable, "-c", MEMORY, file], check=True, capture_output=True, text=True
    )
    return json.loads(done.stdout)


@pytest.mark.parametrize("packed", [False, True])
def test_bytes_are_bounded(tmp_path, monkeypatch, packed):
    monkeypatch.setattr(raw, "MOST_BYTES", 1 << 20)
    file = tmp_path / "r.csv"
    data = b"t,drive,x\n" + b"0,0,0\n" * (1 << 18)
    file.write_bytes(gzip.compress(data) if packed else data)
    with pytest.raises(DataFileError, match=r"r\.csv: holds more than 1 MB of text: take parts"):
        load_runs(file)


def test_standard_input_is_bounded(monkeypatch):
    raw._standard_input.cache_clear()
    monkeypatch.setattr(raw, "MOST_BYTES", 1 << 20)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b" " * (1 << 21))))
    with pytest.raises(DataFileError, match="-: holds more than 1 MB"):
        load_runs("-")


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_values_are_bounded_by_the_columns_that_are_used(tmp_path, monkeypatch, ending):
    monkeypatch.setattr(raw, "MOST_VALUES", 99)
    file = tmp_path / f"r.{ending}"
    frame = pl.DataFrame({"t": [0.1 * k for k in range(33)], "drive": 0.0, "x": 0.0, "y": 0.0})
    write = {"csv": pl.DataFrame.write_csv, "parquet": pl.DataFrame.write_parquet}[ending]
    write(frame, file)
    assert load_runs(file)[0][0].t.size == 33
    write(frame.with_columns(v=pl.lit(0.0)), file)
    with pytest.raises(DataFileError, match="33 rows of 4 columns, allowed are"):
        load_runs(file)


def test_a_long_text_in_every_row(tmp_path, monkeypatch):
    monkeypatch.setattr(table, "MOST_BYTES", 1 << 20)
    file = tmp_path / "r.parquet"
    pl.DataFrame({"t": ["1" * 50_000] * 30, "drive": 0.0, "x": 0.0}).write_parquet(file)
    with pytest.raises(DataFileError, match="column t: more than 1 MB of text"):
        load_runs(file)


def test_names_without_end(tmp_path):
    file = tmp_path / "r.csv"
    file.write_bytes(b"t,drive,x" + b"," * (5 << 20) + b"\n0,0,0\n")
    with pytest.raises(DataFileError, match="line of names has more than 4 MB"):
        load_runs(file)


def test_a_toml_file_without_end(tmp_path):
    file = tmp_path / "n.toml"
    file.write_bytes(b"#" * (17 << 20))
    with pytest.raises(DataFileError, match=r"n\.toml: holds more than 16 MB"):
        read(file)


def test_plain_and_packed_bytes(tmp_path):
    file = tmp_path / "r.csv.gz"
    # Two members, as two packed files written one behind the other are.
    file.write_bytes(gzip.compress(b"a") + gzip.compress(b"b"))
    assert contents(file) == b"ab"
    assert stored(file).startswith(b"\x1f\x8b")
    with pytest.raises(DataFileError, match="none"):
        stored(tmp_path / "none")


@pytest.mark.slow
def test_bombs_take_little_memory(tmp_path):
    packed = tmp_path / "bomb.csv.gz"
    block = b"".join(b"%d,0,0\n" % (k % 10) for k in range(100_000))
    with gzip.open(packed, "wb", 6) as file:
        file.write(b"t,drive,x\n")
        for _ in range(600):
            file.write(block)
    said, memory = reading(packed)
    assert "holds more than 256 MB" in said
    assert memory < 1.0
    frame = pl.DataFrame({"t": pl.repeat(0.0, 60_000_000, eager=True)})
    frame.with_columns(drive="t", x="t").write_parquet(tmp_path / "bomb.parquet")
    said, memory = reading(tmp_path / "bomb.parquet")
    assert "60000000 rows of 3 columns" in said
    assert memory < 0.5


@pytest.mark.slow
def test_a_file_at_the_limit_takes_1200_mb_and_some(tmp_path):
    rows = raw.MOST_VALUES // 3
    t = (pl.int_range(rows, eager=True) * 0.001).round(3)
    pl.DataFrame({"t": t, "drive": 0.25, "x": 0.0012345}).write_csv(tmp_path / "r.csv")
    said, memory = reading(tmp_path / "r.csv")
    assert said == "read"
    assert memory < 1.5
