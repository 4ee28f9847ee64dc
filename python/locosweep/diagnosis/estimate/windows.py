"""Windows along a run, and which of many take part in fits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.shooting import knows_start

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

TURNS = 2.0
"""Longest window over the shortest time in which an error grows by e; within a window
it grows by half as many."""
LEAD = 0.15
"""Part of a window that is replayed at either end without counting."""
LEAST = 24
"""Samples of a window, at least."""
_RESTING = 8
"""One in so many windows may be one in which the head rests."""


def growth_rates(run: Run, nominal: dict[str, float]) -> Floats:
    """Rate at which errors grow along a measured run, 1/s: that of a pendulum above its pivot."""
    torque = nominal.get("gravity_torque", 0.0)
    x = run.channels["x"]
    falls = -torque * np.cos(np.where(np.isfinite(x), x, 0.0)) / nominal["mass"]
    rates: Floats = np.sqrt(np.maximum(falls, 0.0))
    return rates


def windows_along(
    run: Run, lead: int, seconds: float, nominal: dict[str, float]
) -> list[tuple[int, int]]:
    """Windows whose counting parts follow each other."""
    since = run.since_start
    width = np.diff(since, prepend=0.0)
    grown = np.cumsum(growth_rates(run, nominal) * width)
    found = []
    a = 0
    while a + 2 * lead + 8 <= run.t.size:
        end = int(np.searchsorted(since, since[a + lead] + seconds))
        end = min(end, int(np.searchsorted(grown, grown[a] + 0.5 * TURNS)))
        end = max(end, a + lead + LEAST // 2)
        b = min(end + lead, run.t.size)
        if run.t.size - b < lead + 8:
            b = run.t.size
        # Over a gap in the data nothing is known about the motion.
        whole = np.diff(run.t[a:b])
        kept = whole.max() <= max(10.0 * np.median(whole), 0.1 * seconds)
        known = (
            knows_start(run, a, LEAD * seconds) and np.isfinite(run.channels["x"][a:b]).sum() >= 8
        )
        if b - a >= 2 * lead + 8 and kept and known:
            found.append((a, b))
        if b == run.t.size:
            break
        a = b - 2 * lead
    return found


def chosen_windows(
    runs: Sequence[Run], windows: dict[int, list[tuple[int, int, int]]], most: int, noise: float
) -> list[tuple[int, int, int]]:
    """Pick windows from every run alike, over its drive levels, speeds and times."""
    left = most
    chosen = []
    # Of many runs each has few windows: rests are counted over all, and rounded.
    due = 0.5
    order = sorted(windows, key=lambda r: sum(b - a for _, a, b in windows[r]))
    for k, r in enumerate(order):
        mine = windows[r]
        size = float(np.mean([b - a for _, a, b in mine]))
        count = max(1, int(left / (len(order) - k) / size))
        due += count / _RESTING
        picked = _varied(runs[r], mine, count, int(due), noise)
        due -= int(due)
        left -= sum(b - a for _, a, b in picked)
        chosen += picked
    return sorted(chosen)


def _varied(
    run: Run, windows: list[tuple[int, int, int]], count: int, rests_due: int, noise: float
) -> list[tuple[int, int, int]]:
    """Pick windows over drive levels and travels; so many of rest, more if few others move."""
    x = run.channels["x"]
    travel = np.array([np.nanmax(x[a:b]) - np.nanmin(x[a:b]) for _, a, b in windows])
    drive = np.array([np.sqrt(np.mean(run.drive[a:b] ** 2)) for _, a, b in windows])
    rests = travel <= 8.0 * noise
    moving, resting = np.flatnonzero(~rests), np.flatnonzero(rests)
    few = min(max(rests_due, count - moving.size), count)
    picks = [resting[i] for i in spread(resting.size, few)]
    if moving.size:
        # Even steps through windows in order of drive, then travel, then time meet
        # all of these in proportion.
        level = np.searchsorted(np.quantile(drive[moving], (1 / 3, 2 / 3)), drive[moving])
        far = np.searchsorted(np.quantile(travel[moving], (1 / 3, 2 / 3)), travel[moving])
        order = moving[np.lexsort((moving, far, level))]
        picks += [order[i] for i in spread(order.size, count - len(picks))]
    return [windows[i] for i in sorted(picks)]


def spread(count: int, wanted: int) -> list[int]:
    """Numbers below `count`, evenly spread."""
    if wanted >= count:
        return list(range(count))
    return [int((i + 0.5) * count / wanted) for i in range(max(wanted, 0))]
