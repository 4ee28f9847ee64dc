"""Several processes on one folder, with shards and without: the same bits."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import TYPE_CHECKING, Any

import pytest
from run_cases import CLOSED, data_files, partials, same

import locosweep as ls
from locosweep import _core
from locosweep.run_folder import manifest
from locosweep.run_folder.shards import Order
from locosweep.run_folder.state import State
from locosweep.run_folder.verify import verify

if TYPE_CHECKING:
    from pathlib import Path

SPEC: dict[str, Any] = {**CLOSED, "chunk": 30}
ONE = """
import json, sys
sys.path[:0] = json.loads(sys.argv[1])
from run_cases import CLOSED
import locosweep as ls
shard = json.loads(sys.argv[3])
run = ls.sweep(**CLOSED, chunk=30, out=sys.argv[2], threads=1,
               shard=None if shard is None else tuple(shard))
print(run.complete)
"""


def begin(folder: Path, shard: tuple[int, int] | None) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-W", "error", "-c", ONE, json.dumps(sys.path), str(folder),
         json.dumps(shard)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def computed(folder: Path) -> dict[str, list[int]]:
    """Chunks that each writer logged."""
    found = manifest.read(folder)
    return {w.name: [one.chunk for one in w.done] for w in State(folder, found).writers}


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_shards_one_after_another_give_the_bits_of_one_run(count: int, tmp_path: Path) -> None:
    wanted = data_files(ls.sweep(**SPEC, out=tmp_path / "one").folder)
    folder = tmp_path / "shared"
    for i in range(count):
        run = ls.sweep(**SPEC, out=folder, shard=(i, count))
        # The first one that is done takes what the others have not begun.
        assert run.complete
    assert data_files(folder) == wanted
    assert len(computed(folder)) == 1


def test_a_shard_deals_round_robin_and_then_takes_from_the_end(tmp_path: Path) -> None:
    found = ls.sweep(**SPEC, out=tmp_path / "run").manifest
    for log in (tmp_path / "run" / "log").iterdir():
        log.unlink()
    for path in (tmp_path / "run" / "data.zarr").rglob("c.*.*"):
        path.unlink()
    count = found.plan.count
    assert count > 6
    order = list(Order(State(tmp_path / "run", found), (1, 3)))
    own = list(range(1, count, 3))
    assert order[: len(own)] == own
    others = order[len(own) :]
    assert sorted(order) == list(range(count))
    turn = others.index(max(others))
    assert others[turn:] + others[:turn] == sorted(others, reverse=True)


def test_a_shard_looks_at_all_files_once_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A thousand shards that look at a hundred thousand files each stop a file system."""
    looks: list[object] = []
    sizes = _core.other_sizes

    def counted(*given: Any) -> Any:
        looks.append(given)
        return sizes(*given)

    monkeypatch.setattr(_core, "other_sizes", counted)
    for turn in range(2):
        looks.clear()
        assert ls.sweep(**SPEC, out=tmp_path / "run", shard=(turn, 2)).complete
        assert len(looks) == 1


def test_a_damaged_chunk_of_another_shard_is_computed_again(tmp_path: Path) -> None:
    wanted = data_files(ls.sweep(**SPEC, out=tmp_path / "run").folder)
    victim = tmp_path / "run" / "data.zarr" / "mean_velocity" / "c.0.0.0"
    for spoil in (victim.unlink, lambda: victim.write_bytes(b"x")):
        spoil()
        run = ls.sweep(**SPEC, out=tmp_path / "run", shard=(1, 2))
        assert run.complete
        assert not run.state.damaged
        assert data_files(run.folder) == wanted


@pytest.mark.slow
@pytest.mark.parametrize("shards", [[(0, 2), (1, 2)], [None] * 8, [(0, 3), (1, 3)]])
def test_processes_at_once_on_one_folder_give_the_same_bits(
    shards: list[tuple[int, int] | None], tmp_path: Path
) -> None:
    wanted = data_files(ls.sweep(**SPEC, out=tmp_path / "one").folder)
    folder = tmp_path / "shared"
    processes = [begin(folder, shard) for shard in shards]
    for process in processes:
        out, err = process.communicate(timeout=120)
        assert process.returncode == 0, err
        assert out == "True\n"
    assert data_files(folder) == wanted
    assert partials(folder) == []
    assert verify(folder).faults == ()
    assert same(ls.open_run(folder), ls.sweep(**CLOSED))


@pytest.mark.slow
def test_what_a_killed_shard_left_is_taken_by_another(tmp_path: Path) -> None:
    wanted = data_files(ls.sweep(**SPEC, out=tmp_path / "one").folder)
    folder = tmp_path / "shared"
    dying = begin(folder, (0, 2))
    while not list(folder.glob("data.zarr/mean_velocity/c.*")):
        assert dying.poll() is None
    dying.kill()
    dying.communicate()
    assert ls.sweep(**SPEC, out=folder, shard=(1, 2)).complete
    assert data_files(folder) == wanted
