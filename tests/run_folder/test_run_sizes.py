"""Sizes of the files of a run, as the core reads them from folders."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
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
    sizes = {e.name: e.stat(follow_symlinks=False).st_size for e in os.scandir(tmp_path / "a")}
    assert _core.file_sizes([tmp_path / "a", tmp_path / "b"]) == [sizes, {}]


def test_a_folder_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(NotADirectoryError) as error:
        _core.file_sizes([tmp_path, tmp_path / "file"])
    assert (error.value.errno, error.value.filename) == (errno.ENOTDIR, str(tmp_path / "file"))
    assert error.value.strerror == os.strerror(errno.ENOTDIR)


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
                (found,) = _core.file_sizes([tmp_path])
                assert [found.get(name) for name in there] == [1] * 200
        finally:
            other.kill()
