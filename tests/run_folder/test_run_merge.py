"""Runs of one sweep in several folders become one, with the same bits."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING, Any

import pytest
from run_cases import ALL, CLOSED, REDUCED, data_files, same

import locosweep as ls
from locosweep.cli import main
from locosweep.run_folder.merge import merge
from locosweep.run_folder.verify import verify

if TYPE_CHECKING:
    from pathlib import Path


def part(folder: Path, spec: dict[str, Any], keep: set[int]) -> Path:
    """A run of which only some chunks were finished."""
    run = ls.sweep(**spec, out=folder)
    (log,) = (folder / "log").iterdir()
    lines = log.read_bytes().splitlines(keepends=True)
    log.write_bytes(b"".join(
        line for line in lines
        if b'"chunk":' not in line or int(line.split(b":")[1].split(b",")[0]) in keep
    ))  # fmt: skip
    for chunk in set(range(run.manifest.plan.count)) - keep:
        for path in (folder / "data.zarr").rglob(run.manifest.plan.key(chunk)):
            path.unlink()
    return folder


@pytest.mark.parametrize("name", ["closed", "reduced", "simulated"])
@pytest.mark.parametrize("count", [1, 2, 5])
def test_shards_merged_are_the_whole(name: str, count: int, tmp_path: Path) -> None:
    spec = {**ALL[name], "chunk": 3 if name == "simulated" else 20}
    whole = ls.sweep(**spec, out=tmp_path / "whole")
    chunks = whole.manifest.plan.count
    parts = [part(tmp_path / f"part{i}", spec, set(range(i, chunks, count))) for i in range(count)]
    run = merge(parts, tmp_path / "merged")
    assert run.complete
    assert data_files(run.folder) == data_files(whole.folder)
    assert verify(run.folder).faults == ()
    assert same(run, ls.sweep(**ALL[name]))
    assert run.status_counts() == whole.status_counts()


def test_a_merge_goes_on_and_takes_what_is_there(tmp_path: Path) -> None:
    spec = {**REDUCED, "chunk": 5}
    a = part(tmp_path / "a", spec, {0, 1, 2})
    b = part(tmp_path / "b", spec, {2, 3})
    assert len(merge([a], tmp_path / "out").state.done) == 3
    run = merge([b, a], tmp_path / "out")
    assert sorted(run.state.done) == [0, 1, 2, 3]
    assert all(len(lines) == 1 for lines in run.state.done.values())
    assert ls.sweep(**spec, out=run.folder).complete
    assert same(ls.open_run(run.folder), ls.sweep(**REDUCED))


def test_what_does_not_belong_together_is_refused(tmp_path: Path) -> None:
    first = part(tmp_path / "first", {**CLOSED, "chunk": 40}, {0})
    for name, other, words in (
        ("sweep", {**CLOSED, "mu_coulomb": 0.2, "chunk": 40}, "another sweep than .*first"),
        ("chunks", {**CLOSED, "chunk": 50}, r"other chunks than .*first \(give .*--chunk\)"),
    ):
        with pytest.raises(ls.InputError, match=f"{name} has {words}: allowed are runs of one"):
            merge([first, part(tmp_path / name, other, {0})], tmp_path / "out")
    with pytest.raises(ls.InputError, match="at least one"):
        merge([], tmp_path / "out")
    with pytest.raises(ls.DataFileError, match="no such folder"):
        merge([tmp_path / "none"], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_nothing_that_was_altered_is_copied(tmp_path: Path) -> None:
    source = part(tmp_path / "a", {**CLOSED, "chunk": 40}, {0, 1, 2})
    root = source / "data.zarr" / "mean_velocity"
    shutil.copy(root / "c.0.0.0", root / "c.1.0.0")
    with pytest.raises(ls.DataFileError, match=r"c\.1\.0\.0 was altered.*chunks are kept"):
        merge([source], tmp_path / "out")
    assert verify(tmp_path / "out").faults == ()


def test_the_command_merges(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for i in range(2):
        part(tmp_path / f"p{i}", {**CLOSED, "chunk": 40}, {i})
    out = str(tmp_path / "out/")
    assert main(["merge", str(tmp_path / "p0"), str(tmp_path / "p1"), "--out", out]) == 0
    assert capsys.readouterr().out == "2 of 6 chunks, 4 missing\n"
    assert main(["merge", str(tmp_path / "p0"), "--out", str(tmp_path / "x.parquet")]) == 2
    assert "ends as a file's name does" in capsys.readouterr().err


def test_a_damaged_chunk_of_a_source_is_told(tmp_path: Path) -> None:
    source = ls.sweep(**CLOSED, chunk=100, out=tmp_path / "source")
    file = next((source.folder / "data.zarr").rglob(source.manifest.plan.key(1)))
    file.write_bytes(file.read_bytes()[:-8])
    with pytest.raises(ls.DataFileError, match="chunk 1 is damaged"):
        merge([source.folder], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_damaged_chunk_that_another_source_has_is_taken_from_there(tmp_path: Path) -> None:
    bad, good = (ls.sweep(**CLOSED, chunk=100, out=tmp_path / name) for name in ("bad", "good"))
    file = next((bad.folder / "data.zarr").rglob(bad.manifest.plan.key(1)))
    file.write_bytes(file.read_bytes()[:-8])
    assert merge([bad.folder, good.folder], tmp_path / "out").complete
