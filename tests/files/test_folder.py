"""Folders that are written as a whole."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from locosweep.files.folder import filling

if TYPE_CHECKING:
    from collections.abc import Callable

NAMES = ("report.html", "report.json", "runs.png")


def fill(folder: Path, text: str, names: tuple[str, ...] = NAMES) -> None:
    with filling(folder, NAMES, force=True) as made:
        for name in names:
            (made / name).write_text(text)


def test_files_of_another_result_go_and_others_stay(tmp_path: Path) -> None:
    fill(tmp_path, "first")
    (tmp_path / "notes.txt").write_text("mine")
    fill(tmp_path, "second", NAMES[:2])
    there = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert there == {"report.html": "second", "report.json": "second", "notes.txt": "mine"}


@pytest.mark.parametrize("moves", [0, 1, 2])
def test_what_is_cut_between_two_files_leaves_no_parts_of_two_results(
    moves: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path, "first")
    move: Callable[..., Path] = Path.replace
    left = [moves]

    def cut(path: Path, target: Path) -> Path:
        if not left[0]:
            raise KeyboardInterrupt
        left[0] -= 1
        return move(path, target)

    monkeypatch.setattr(Path, "replace", cut)
    with pytest.raises(KeyboardInterrupt):
        fill(tmp_path, "second")
    assert [path.read_text() for path in tmp_path.iterdir()] == ["second"] * moves
