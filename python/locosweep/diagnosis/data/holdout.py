"""Split of the runs into training and validation data."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.files.runs import Run

_TAIL = 0.7
"""Share of a single run's readings that fits see; its rest validates."""


def known_labels(runs: Sequence[Run], asked: Sequence[str] | None) -> None:
    """Refuse labels of runs to be kept that no run has."""
    labels = [run.label for run in runs]
    for label in asked or ():
        if label not in labels:
            raise InputError(f"holdout: no run {label}: there are {', '.join(labels)}")


def hold_out(
    runs: Sequence[Run], asked: Sequence[str] | None, gaps: Sequence[float]
) -> tuple[tuple[int, ...], float, bool]:
    """Return the validation runs, the training fraction, and whether the user chose them.

    `asked` names the validation runs; without it they are chosen here, a quarter of all.
    One run is split in time instead: the training fraction is then below 1. `gaps` are the
    squared errors of the nominal model per sample, run by run.
    """
    if asked:
        held = tuple(i for i, run in enumerate(runs) if run.label in asked)
        if len(held) == len(runs):
            raise InputError("holdout: all runs are kept from the fit: leave at least one")
        return held, 1.0, True
    if len(runs) == 1:
        size = runs[0].t.size
        read = np.flatnonzero(np.isfinite(runs[0].channels["x"]))
        all_read = read.size == size
        return (), _TAIL if all_read else float(read[int(_TAIL * read.size)]) / size, False
    # The runs whose gap is most like that of all, but not the richest, which fits need,
    # and no slope that only they have.
    size = np.log(np.maximum(np.array(gaps), 1e-300))
    middle = np.log(max(float(np.mean(gaps)), 1e-300))
    slopes = [run.slope_deg for run in runs]
    order = sorted(
        range(len(runs)),
        key=lambda i: (
            slopes.count(slopes[i]) == 1,
            len(runs) > 2 and size[i] == size.max(),
            abs(size[i] - middle),
            i,
        ),
    )
    count = max(1, len(runs) // 4)
    return tuple(sorted(order[:count])), 1.0, False
