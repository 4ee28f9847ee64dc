"""Ticks of the clock that wrote a log: which one belongs to a row, and when it was.

A log is mostly written by a clock that ticks evenly. Rows may miss, and stamps may be given on
the way into the file: one to a packet of rows, or each a little late.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ticks = NDArray[np.int64]

OFF_TICK = 0.45
"""Largest distance of a stamp from its tick, in ticks: from 0.5 on the tick is not known."""
SCATTER = 0.25
"""Largest deviation of stamps from their ticks, in ticks. Stamps that know of no tick scatter by
0.29 (evenly over one)."""
EXACT = 0.02
"""Deviation from their ticks, in ticks, up to which stamps are taken as they are: an edge of the
drive that is off by so little shifts no motion beyond the noise of its sensor."""
EVEN_STEPS = 0.9
"""Share of even steps from which a clock that wanders counts as one that ticks, step by step."""
SINGLE = 0.6
"""Share of steps that are one tick, at least: with fewer it is no row left out now and then."""
REPEATED = 0.1
"""Share of rows with the stamp of the row before, from which they come in packets. A log whose
rows are stamped one by one repeats a stamp by mistake, which is seldom."""
_FIRST = 48
"""Rows that a first step is found from."""
_NEAR_USUAL = (0.7, 1.3, 601)
"""Steps that are tried for it, in usual ones: stamps that were rounded make these a fifth wrong."""
_WINDOW, _POWERS = 9, 4
"""Rows of a window in which x is held against a cubic, and the coefficients of that."""


def tick_numbers(t: Floats) -> tuple[Ticks, float] | None:
    """Return the tick of every row of a clock that ticks evenly, and the ticks' distance in s.

    Stamps may lie beside their ticks (`OFF_TICK`), and ticks without a row are rows that miss.
    None where stamps show no such clock.
    """
    steps = np.diff(t)
    if steps.size < 2 or not (steps > 0.0).all():
        return None
    usual = float(np.median(steps))
    found = _evenly(t, usual)
    if found is not None:
        return found
    # A clock that wanders: no even ticks over the whole run, but even steps.
    jumps = np.maximum(np.rint(steps / usual), 1.0)
    off = np.abs(steps - jumps * usual) / usual
    if np.mean(off < 0.25 * OFF_TICK) < EVEN_STEPS or np.mean(jumps == 1.0) < SINGLE:
        return None
    return np.concatenate([[0], np.cumsum(jumps)]).astype(np.int64), usual


def _evenly(t: Floats, usual: float) -> tuple[Ticks, float] | None:
    """Count the ticks by a line through ever more rows, which makes it ever more exact."""
    since = t - t[0]
    count = min(_FIRST, t.size)
    # The ticks on which the first rows lie best, in whichever phase.
    tried = usual * np.linspace(*_NEAR_USUAL)
    turns = np.exp(2j * np.pi * since[:count] / tried[:, None]).mean(axis=1)
    best = int(np.argmax(np.abs(turns)))
    step = float(tried[best])
    start = float(np.angle(turns[best])) / (2.0 * np.pi) * step
    while True:
        part = since[:count]
        for _ in range(3):
            ticks = np.rint((part - start) / step)
            if ticks[-1] == ticks[0]:
                return None
            step, start = (float(c) for c in np.polyfit(ticks, part, 1))
            if not step > 0.0:
                return None
        if count == t.size:
            break
        count = min(2 * count, t.size)
    ticks = np.rint((since - start) / step)
    off = (since - start - ticks * step) / step
    if (np.diff(ticks) < 1.0).any() or np.mean(np.diff(ticks) == 1.0) < SINGLE:
        return None
    if np.abs(off).max() > OFF_TICK or off.std() > SCATTER:
        return None
    return (ticks - ticks[0]).astype(np.int64), step


def spread_packets(t: Floats) -> Floats | None:
    """Return even times of rows that came in packets with one stamp each.

    None where stamps do not repeat, or repeat in another way than those of packets of a clock
    that ticks evenly.
    """
    steps = np.diff(t)
    if (steps < 0.0).any() or np.mean(steps == 0.0) < REPEATED:
        return None
    first = np.flatnonzero(np.concatenate([[True], steps > 0.0]))
    if first.size < 3:
        return None
    stamps, sizes = t[first], np.diff(np.append(first, t.size))
    usual = float(np.median(sizes[1:-1]))
    # The last packet may be a part of one, the first is known to begin with its stamp no more
    # than the others: a line through where packets begin is that of the clock.
    gone = np.zeros(first.size)
    tick = float(np.median(np.diff(stamps) / sizes[:-1]))
    longer = np.diff(stamps) / tick - sizes[:-1]
    lost = np.rint(longer / usual)
    gone[1:] = np.cumsum(np.where(lost >= 1.0, lost * usual, 0.0))
    begins = first + gone
    step, start = (float(c) for c in np.polyfit(begins, stamps, 1))
    off = np.abs(stamps - start - begins * step)
    if not step > 0.0 or off.max() > max(float(sizes.max()), 1.0) * step:
        return None
    rows = np.arange(t.size) + np.repeat(gone, sizes)
    return np.asarray(start + rows * step, dtype=np.float64)


def times_of_ticks(t: Floats) -> Floats | None:
    """Return the times of the ticks; None where stamps lie on them, or show no even clock."""
    found = tick_numbers(t)
    if found is None:
        return None
    ticks, step = found
    rate, start = (float(c) for c in np.polyfit(ticks, t, 1))
    even = np.asarray(start + ticks * rate, dtype=np.float64)
    off = (t - even) / step
    return even if off.std() > EXACT and np.abs(off).max() < 0.5 else None


def evidence(x: Floats, even: Floats, stamps: Floats) -> float:
    """Return the log likelihood by which x was read at `even` times and not at the stamps.

    What follows a cubic more closely over the one than over the other was read then; what rests
    does not tell.
    """
    left = []
    for a in range(0, x.size - _WINDOW + 1, _WINDOW):
        part = x[a : a + _WINDOW]
        ok = np.isfinite(part)
        if ok.sum() > _POWERS + 1:
            times = (t[a : a + _WINDOW][ok] for t in (even, stamps))
            squares = [_beside_cubic(t, part[ok]) for t in times]
            left.append((*squares, float(ok.sum()) - _POWERS))
    over_even, over_stamps, free = np.sum(np.array(left).reshape(-1, 3), axis=0)
    variance = min(over_even, over_stamps) / max(free, 1.0)
    return float((over_stamps - over_even) / (2.0 * variance)) if variance > 0.0 else 0.0


def _beside_cubic(t: Floats, x: Floats) -> float:
    """Return the squares that a cubic leaves of x."""
    basis = np.vander((t - t[0]) / (t[-1] - t[0]), _POWERS)
    found, *_ = np.linalg.lstsq(basis, x, rcond=None)
    return float(np.sum((x - basis @ found) ** 2))
