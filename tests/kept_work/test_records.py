"""Records of work that is kept."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from locosweep.kept_work.records import keep, kept
from locosweep.validation.draw import draw_cases

if TYPE_CHECKING:
    from pathlib import Path

KEY = {"seed": 1, "code": "abc"}


def _record(folder: Path) -> Path:
    (folder / "made.csv").write_text("t,x\n0,1\n")
    keep(folder / "sealed" / "record.json", KEY, [folder / "made.csv"], seconds=0.5)
    return folder / "sealed" / "record.json"


def test_a_record_says_what_was_kept(tmp_path: Path) -> None:
    known = kept(_record(tmp_path), KEY)
    assert known is not None
    assert known["seconds"] == 0.5


def test_a_folder_may_be_moved(tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    _record(tmp_path / "here")
    moved = (tmp_path / "here").rename(tmp_path / "there")
    assert kept(moved / "sealed" / "record.json", KEY) is not None


def test_work_for_another_key_is_done_again(tmp_path: Path) -> None:
    assert kept(_record(tmp_path), {**KEY, "seed": 2}) is None


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b"null", b"3", b"{}", b'{"key": 1, "files": 2}', b"\xff\xfe\0"]
)
def test_a_torn_or_foreign_record_is_none(content: bytes, tmp_path: Path) -> None:
    record = _record(tmp_path)
    record.write_bytes(content)
    assert kept(record, KEY) is None
    assert kept(record, 1) is None


def test_an_altered_or_missing_file_is_made_again(tmp_path: Path) -> None:
    record = _record(tmp_path)
    (tmp_path / "made.csv").write_text("t,x\n0,2\n")
    assert kept(record, KEY) is None
    (tmp_path / "made.csv").unlink()
    assert kept(record, KEY) is None


@pytest.mark.slow
def test_a_case_that_was_altered_is_drawn_again(tmp_path: Path) -> None:
    (name,) = draw_cases(tmp_path, 0, 5, gap_free=1)
    sealed = tmp_path / "sealed" / name
    files = [tmp_path / name / "runs.csv", *(sealed / f for f in ("truth.json", "check.csv"))]
    whole = [file.read_bytes() for file in files]
    seal = (tmp_path / "sealed.json").read_text()
    for file, content in zip([*files, sealed / "drawn.json"], [*whole, b"{" * 40], strict=True):
        file.write_bytes(content[: len(content) // 2])
        draw_cases(tmp_path, 0, 5, gap_free=1)
        assert [f.read_bytes() for f in files] == whole
        assert (tmp_path / "sealed.json").read_text() == seal
