"""Progress of a run over the chunks that it still misses, so that the time left is true."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from locosweep.progress import Meter, progress_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from locosweep.progress import Progress
    from locosweep.run_folder.cells import Cells
    from locosweep.run_folder.plan import Plan


class WorkDone:
    """Evaluations that are done of those that were missing when this process began.

    Attributes
    ----------
    within : callable or None
        Progress of the chunk that is being computed, for the kernel to call.
    """

    def __init__(
        self, cells: Cells, plan: Plan, missing: Sequence[int], shown: bool | Progress
    ) -> None:
        self._per_cell = cells.points_per_cell
        self._plan = plan
        self._total = sum(plan.cells(chunk) for chunk in missing) * self._per_cell
        self._done = self._seen = self._without = 0
        self._begin = time.perf_counter()
        self._call = progress_of(shown, ", ".join(cells.request.quantities))
        self._meter = self._call if isinstance(self._call, Meter) else None
        self._fail = None if self._meter else getattr(self._call, "fail", None)
        self.within: Callable[[int, int, float], object] | None = None
        if self._call is not None:
            self.within = self._within
            if not missing:
                self._call(0, 0, 0.0)

    def _within(self, done: int, _total: int, _rate: float) -> None:
        self._show(min(done, max(self._total - self._done - 1, 0)))

    def finish(self, chunk: int, without: int) -> None:
        """Count a chunk that was computed, with the cells of its first output without a value."""
        cells = self._plan.cells(chunk)
        self._done = min(self._done + cells * self._per_cell, self._total)
        self._seen += cells
        self._without += without
        if self._meter is not None:
            self._meter.note(f"{self._without / self._seen:.1%} without a value")
        elif self._fail is not None:
            self._fail(self._without)
        self._show(0)

    def _show(self, within: int) -> None:
        if self._call is not None:
            done = self._done + within
            taken = max(time.perf_counter() - self._begin, 1e-9)
            self._call(done, self._total, done / taken)

    def close(self) -> None:
        """Erase the bar where it is not finished."""
        if self._meter is not None:
            self._meter.close()
