"""The files of one chunk: written and hashed, statuses counted."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import numpy as np

from locosweep.run_folder import arrays
from locosweep.run_folder.commit import write_file

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from locosweep.run_folder.cells import Block, Cells
    from locosweep.run_folder.plan import Plan


def commit_chunk(
    folder: Path,
    plan: Plan,
    cells: Cells,
    chunk: int,
    blocks: list[Block],
    stop: Callable[[], bool] | None = None,
) -> dict[str, tuple[str, int]]:
    """Write the files of a chunk under their names; return hash and bytes of each."""
    files = {}
    for name, array in zip(arrays.array_names(cells), (a for b in blocks for a in b), strict=True):
        parts = arrays.encode(array, plan.chunk, status=array.dtype == np.uint8)
        digest = hashlib.sha256()
        for part in parts:
            digest.update(part)
        write_file(folder / arrays.STORE / name / plan.key(chunk), parts, stop)
        files[name] = (digest.hexdigest(), sum(len(part) for part in parts))
    return files


def count_statuses(cells: Cells, blocks: list[Block]) -> dict[str, dict[str, int]]:
    """Count the cells of each status, by output."""
    found = {}
    for output, (_, codes) in zip(cells.outputs, blocks, strict=True):
        left, code, counts = codes.size, 0, {}
        # Few codes occur, mostly the lowest: faster than a histogram.
        while left and code < arrays.NOT_COMPUTED:
            here = int(np.count_nonzero(codes == code))
            if here:
                counts[str(code)] = here
            left -= here
            code += 1
        found[output.name] = counts
    return found
