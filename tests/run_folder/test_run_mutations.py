"""Chunk files altered at random: none is read, each is named, and repaired to the same bits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from chunk_mutations import KINDS, mutate

if TYPE_CHECKING:
    from pathlib import Path


@pytest.mark.parametrize(("count", "seed"), [(12, 3), pytest.param(500, 2, marks=pytest.mark.slow)])
def test_no_altered_chunk_is_read_and_each_is_repaired(
    count: int, seed: int, tmp_path: Path
) -> None:
    done, wrong = mutate(tmp_path, count, seed)
    assert wrong == []
    assert sum(done.values()) == count
    assert count < 100 or set(done) == set(KINDS)
