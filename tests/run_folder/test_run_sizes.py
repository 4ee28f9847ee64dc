"""Sizes of the files of a run, as the core reads them from folders."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
import zlib
from pathlib import Path

import pytest
from run_cases import CLOSED

import locosweep as ls
from locosweep import _core

RENAMES = """
import os, sys
while True:
    for name in range(50):
        path = os.path.join(sys.argv[1], f"{name}.partial")
        open(path, "w").close()
        os.replace(path, os.path.join(sys.argv[1], f"done{name}"))
"""


def test_they_are_those_of_the_file_system(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "c.0.0").write_bytes(b"12345")
    (tmp_path / "a" / "käfer").write_bytes(b"")
    (tmp_path / "a" / "link").symlink_to(tmp_path / "nowhere")
    names = ["c.0.0", "käfer", "link", "no"]
    link = (tmp_path / "a" / "link").lstat().st_size
    folders = [tmp_path / "a", tmp_path / "b"]
    assert _core.other_sizes(folders, names, [[5, 1, link, 0], [5, 0, 0, 0]]) == [
        {1: 0, 3: None}, dict.fromkeys(range(4)),
    ]  # fmt: skip
    assert _core.other_sizes(folders, [], [[], []]) == [{}, {}]


def test_a_folder_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(NotADirectoryError) as error:
        _core.other_sizes([tmp_path, tmp_path / "file"], ["x"], [[1], [1]])
    assert (error.value.errno, error.value.filename) == (errno.ENOTDIR, str(tmp_path / "file"))
    assert error.value.strerror == os.strerror(errno.ENOTDIR)


@pytest.mark.parametrize("size", ["-1", "1" + "0" * 30, "1" + "0" * 4000])
def test_a_size_that_no_file_has_is_a_damaged_chunk(size: str, tmp_path: Path) -> None:
    run = ls.sweep(**CLOSED, chunk=40, out=tmp_path / "run")
    (log,) = (tmp_path / "run" / "log").iterdir()
    lines = log.read_bytes().splitlines()
    text = lines[1].rpartition(b"\t")[0]
    record = json.loads(text)
    told = text.replace(f",{record['files']['mean_velocity'][1]}]".encode(), f",{size}]".encode())
    lines[1] = told + b"\t%08x" % zlib.crc32(told)
    log.write_bytes(b"\n".join(lines) + b"\n")
    again = ls.open_run(tmp_path / "run", allow_missing=True)
    assert list(again.state.damaged) == [record["chunk"]]
    assert again.state.done_count == run.state.done_count - 1


def test_a_run_says_which_of_its_folders_is_none(tmp_path: Path) -> None:
    ls.sweep(**CLOSED, chunk=40, out=tmp_path / "run")
    array = tmp_path / "run" / "data.zarr" / "mean_velocity"
    array.rename(tmp_path / "away")
    array.write_bytes(b"")
    with pytest.raises(ls.InputError, match=r"mean_velocity: .*ot a directory$"):
        ls.open_run(tmp_path / "run")


def test_files_that_others_rename_meanwhile_hide_no_file(tmp_path: Path) -> None:
    there = [f"c.{i}" for i in range(200)]
    for name in there:
        (tmp_path / name).write_bytes(b"1")
    with subprocess.Popen([sys.executable, "-c", RENAMES, str(tmp_path)]) as other:
        try:
            while not (tmp_path / "done49").exists():
                assert other.poll() is None
            for _ in range(300):
                assert _core.other_sizes([tmp_path], there, [[1] * 200]) == [{}]
        finally:
            other.kill()
