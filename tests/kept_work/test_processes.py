"""Work over processes and the digest of code."""

from __future__ import annotations

import math
import os

import pytest

from locosweep.kept_work.processes import code_digest, over_processes


def test_results_come_in_the_order_of_their_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    seen: list[tuple[int, int]] = []
    calls = [(12, 18), (7, 21), (5, 3)]
    found = over_processes(math.gcd, calls, 1, lambda *counts: seen.append(counts))
    assert found == [6, 7, 1]
    assert seen == [(1, 3), (2, 3), (3, 3)]
    assert os.environ["OMP_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ


def test_workers_have_one_thread_each() -> None:
    assert over_processes(os.getenv, [("OMP_NUM_THREADS",)], 1) == ["1"]


def test_an_error_of_a_worker_is_raised() -> None:
    with pytest.raises(ValueError, match=r"domain|nonnegative"):
        over_processes(math.sqrt, [(4.0,), (-1.0,)], 1)


def test_nothing_to_do() -> None:
    assert over_processes(math.gcd, [], 1) == []


def test_the_digest_is_of_files_and_of_what_they_run_on() -> None:
    one = code_digest("validation/drives.py", engine=False)
    assert one == code_digest("validation/drives.py", engine=False)
    assert one != code_digest("validation/rigs.py", engine=False)
    assert one != code_digest("validation/drives.py", engine=True)
    whole = code_digest("validation", engine=False)
    assert whole not in (one, code_digest("files", engine=False))
