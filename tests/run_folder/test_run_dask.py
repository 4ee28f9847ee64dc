"""Runs that the processes of a real Dask cluster fill, one of which is killed."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from run_cases import CLOSED

import locosweep as ls
from locosweep.cli import main

DRIVER = Path(__file__).with_name("dask_driver.py")


def drive(mode: str, folder: Path) -> dict[str, Any]:
    done = subprocess.run(
        [sys.executable, str(DRIVER), mode, str(folder)],
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer


@pytest.mark.slow
def test_workers_give_the_bits_of_one_process(tmp_path: Path) -> None:
    found = drive("fill", tmp_path / "run")
    assert found["same"]
    assert found["files"]
    assert len(found["writers"]) == 3
    assert sum(found["writers"]) == found["chunks"] > 10
    assert found["told"] == [2 * 147, 2 * 147]
    assert found["steps"] == found["chunks"]


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_its_chunk(tmp_path: Path) -> None:
    found = drive("kill", tmp_path / "run")
    assert found["gone"]
    assert found["same"]
    assert found["faults"] == 0
    # The worker that was killed may not have written yet; another one takes its place.
    assert len(found["writers"]) >= 2


@pytest.mark.slow
def test_a_worker_that_cannot_write_says_where(tmp_path: Path) -> None:
    error = drive("fail", tmp_path / "run")["error"]
    assert f"{tmp_path}/run/data.zarr/mean_velocity/c." in error
    assert "Is a directory" in error
    assert "chunks are kept" in error
    assert "\n" not in error


@pytest.mark.slow
def test_workers_see_that_a_folder_was_made_anew(tmp_path: Path) -> None:
    assert drive("again", tmp_path / "run") == {"complete": True, "same": True, "faults": 0}


@pytest.mark.slow
def test_the_command_takes_the_address_of_a_scheduler(tmp_path: Path) -> None:
    assert drive("command", tmp_path / "run") == {
        "code": 0, "out": "run/\n", "err": "", "complete": True
    }  # fmt: skip


def test_no_scheduler_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = tmp_path / "s.toml"
    ls.Spec(("resistance",), (("mass", (0.1, 0.2)),), (("mu_coulomb", 0.3),)).save(spec)
    out = str(tmp_path / "run/")
    assert main(["sweep", str(spec), "--out", out, "--dask", "nonsense://x"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "--dask nonsense://x: no scheduler answers" in error


def test_a_client_beside_a_shard_or_token_is_refused(tmp_path: Path) -> None:
    for other in ({"shard": (0, 2)}, {"token": ls.CancelToken()}):
        with pytest.raises(ls.InputError, match="are both given"):
            ls.sweep(**CLOSED, out=tmp_path / "run", client=object(), **other)
    with pytest.raises(ls.InputError, match="client is given"):
        ls.sweep(**CLOSED, client=object())
