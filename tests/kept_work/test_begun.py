"""Folders of kept work: begun once, for one thing; what is half-made is swept."""

from __future__ import annotations

import subprocess
import sys
from typing import TYPE_CHECKING

import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.kept_work.begun import BEGUN, begin
from locosweep.kept_work.processes import over_processes
from locosweep.kept_work.staged import staged, sweep_staged
from locosweep.run_folder.commit import beside, host
from locosweep.run_folder.shards import dealt

if TYPE_CHECKING:
    from pathlib import Path


def test_the_same_goes_on_and_another_is_refused(tmp_path: Path) -> None:
    out = tmp_path / "a" / "check"
    for _ in range(2):
        begin(out, {"seed": 1, "only": None})
        (out / "made.txt").write_text("x")
    for other, words in (
        ({"seed": 2, "only": None}, "begun with seed 1, here it is 2: name another folder"),
        ({"seed": 1, "only": "pairs"}, 'begun with only null, here it is "pairs"'),
        ({"seed": 1, "only": None, "sizes": [3.0] * 99}, "begun with sizes null, here it is"),
    ):
        with pytest.raises(ls.InputError, match=words) as caught:
            begin(out, other, force=True)
        assert len(str(caught.value)) < 300


def test_a_folder_of_something_else_is_refused_unless_forced(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(ls.InputError, match="not empty"):
        begin(tmp_path, {"seed": 1})
    begin(tmp_path, {"seed": 1}, force=True)
    begin(tmp_path, {"seed": 1})


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"3", b"null", b"\xff\xfe\0", b"[" * 10**5])
def test_a_torn_word_is_one_line(content: bytes, tmp_path: Path) -> None:
    begin(tmp_path, {"seed": 1})
    (tmp_path / BEGUN).write_bytes(content)
    with pytest.raises(ls.DataFileError, match=r"begun\.json: altered or damaged"):
        begin(tmp_path, {"seed": 1})


def test_staged_files_replace_what_is_there_and_others_of_a_whole_go(tmp_path: Path) -> None:
    for name in ("case/runs.csv", "case/old.csv", "other/kept.csv"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("old")
    with staged(tmp_path, "case") as place:
        (place / "case").mkdir()
        (place / "case" / "runs.csv").write_text("new")
        assert (tmp_path / "case" / "runs.csv").read_text() == "old"
    assert (tmp_path / "case" / "runs.csv").read_text() == "new"
    assert not (tmp_path / "case" / "old.csv").exists()
    assert (tmp_path / "other" / "kept.csv").exists()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["case", "other"]


def test_an_error_leaves_what_was_there(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("old")

    def fail() -> None:
        with staged(tmp_path) as place:
            (place / "a.txt").write_text("half")
            raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        fail()
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("a.txt", "old")]


def test_what_dead_processes_left_half_made_is_swept(tmp_path: Path) -> None:
    dead = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"],
                          capture_output=True, text=True, check=True).stdout.strip()  # fmt: skip
    for pid in (dead, "1"):
        (tmp_path / f"work.{host()}-{pid}-00ff.partial" / "sub").mkdir(parents=True)
    assert sweep_staged(tmp_path) == 1
    assert [p.name for p in tmp_path.iterdir()] == [f"work.{host()}-1-00ff.partial"]


def noted(i: int, file: Path) -> int:
    with file.open("a") as lines:
        lines.write(f"{i}\n")
    return i


def test_a_shard_has_its_own_first_and_all_results_in_order(tmp_path: Path) -> None:
    seen: list[int] = []
    file = tmp_path / "order.txt"
    calls = [(i, file) for i in range(5)]
    found = over_processes(noted, calls, 1, shard=(1, 2), each=lambda i, _: seen.append(i))
    assert found == [0, 1, 2, 3, 4]
    assert sorted(seen) == found
    # In the order in which the one process took them: those that end together are told at once.
    assert file.read_text().split() == [str(i) for i in dealt(5, (1, 2))]
    assert file.read_text().split()[:2] == ["1", "3"]


@pytest.mark.slow
def test_a_blind_check_goes_on_and_two_seeds_do_not_mix(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "check")
    draw = ["blind-check", "--cases", "0", "--gap-free", "2", "--draw-only", "--quiet",
            "--threads", "1", "--out", out]  # fmt: skip
    assert main([*draw, "--seed", "1", "--shard", "1/2"]) == 0
    seal = (tmp_path / "check" / "sealed.json").read_text()
    times = {p: p.stat().st_mtime_ns for p in (tmp_path / "check").rglob("truth.json")}
    assert len(times) == 2
    assert main([*draw, "--seed", "1", "--shard", "0/2"]) == 0
    assert {p: p.stat().st_mtime_ns for p in (tmp_path / "check").rglob("truth.json")} == times
    capsys.readouterr()
    for force in ([], ["--force"]):
        assert main([*draw, "--seed", "2", *force]) == 2
        assert capsys.readouterr().err == (
            f"locosweep: {out} was begun with seed 1, here it is 2: name another folder\n"
        )
    assert (tmp_path / "check" / "sealed.json").read_text() == seal


@pytest.mark.slow
def test_shards_of_a_blind_check_at_once_judge_the_same(tmp_path: Path) -> None:
    def begun(out: str, *more: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [sys.executable, "-m", "locosweep", "blind-check", "--cases", "0", "--gap-free", "2",
             "--seed", "5", "--quiet", "--threads", "1", "--out", out, *more],
            cwd=tmp_path, stdout=subprocess.DEVNULL,
        )  # fmt: skip

    assert begun("whole").wait(timeout=600) == 0
    shards = [begun("dealt", "--shard", f"{i}/2") for i in range(2)]
    assert [shard.wait(timeout=600) for shard in shards] == [0, 0]
    names = ["sealed.json", "wrong.txt", *(f"diagnoses/free_000{i}/report.json" for i in range(2))]
    for name in names:
        whole, dealt = (tmp_path / out / name for out in ("whole", "dealt"))
        assert whole.read_bytes() == dealt.read_bytes()


def test_a_folder_that_another_one_begins_just_now_is_free(tmp_path: Path) -> None:
    other = beside(tmp_path / BEGUN)
    other.touch()
    begin(tmp_path, {"seed": 1})
    (tmp_path / "foreign").touch()
    begin(tmp_path, {"seed": 1})
    (tmp_path / BEGUN).unlink()
    with pytest.raises(ls.InputError, match="is not empty"):
        begin(tmp_path, {"seed": 1})
