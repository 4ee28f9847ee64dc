"""Kinds of motion, read off the measured position."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.data.noise import Noise
    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

REGIMES = ("at_rest", "breakaway", "sliding_forward", "sliding_backward", "reversal")
"""Kinds of motion that a sample belongs to."""
_SLOPES = 0.05
"""Deviation of smoothed speeds, in mean speeds: about a hundredth of the largest."""
_AFTER = 5
"""Samples after a break-away, and around a reversal, that belong to it."""


@dataclass(frozen=True)
class MeasuredMotion:
    """Smoothed motion of a run at its samples, and the deviation of its speed."""

    x: Floats
    v: Floats
    deviation: float
    width: int = 1
    """Samples that a value is smoothed over."""

    @property
    def resting_speed(self) -> float:
        """Speed up to which the head counts as at rest, m/s."""
        return 3.0 * self.deviation + 0.01 * float(np.abs(self.v).max(initial=0.0))

    def sliding_distance(self, before: float = 0.0) -> Floats:
        """Return the distance moved forward since the last rest or turn; `before` at the start."""
        forward = self.v > self.resting_speed
        last = np.maximum.accumulate(np.where(forward, -1, np.arange(self.x.size)))
        base = np.where(last < 0, self.x[0] - before, self.x[last])
        found: Floats = np.where(forward, np.maximum(self.x - base, 0.0), 0.0)
        return found


def measured_motion(run: Run, noise: Noise, accuracy: float = _SLOPES) -> MeasuredMotion:
    """Smooth the measured position of a run as wide as the noise of x asks for.

    `accuracy` is the deviation of speeds that is wanted, in mean speeds of the run.
    """
    t, x = run.t, run.channels["x"]
    ok = np.isfinite(x)
    x = np.interp(t, t[ok], x[ok]) if ok.any() else np.zeros_like(t)
    step = float(np.median(np.diff(t)))
    fast = max(float(np.ptp(x)) / max(t[-1] - t[0], 1e-12), 1e-12)
    width = int(np.ceil((3.5 * noise.sd / (accuracy * fast * step)) ** (2.0 / 3.0)))
    width = int(np.clip(width | 1, 5, max(5, (t.size // 8) | 1)))
    even = np.linspace(t[0], t[-1], t.size)
    smooth, slope = _local_parabolas(np.interp(even, t, x), width)
    speed = slope / (even[1] - even[0])
    deviation = noise.sd * np.sqrt(12.0 / width**3) / step
    x, v = np.interp(t, even, smooth), np.interp(t, even, speed)
    return MeasuredMotion(x, v, float(deviation), width)


def misfit_of_speed(run: Run, noise: Noise) -> Floats:
    """Return measured speeds less the slopes of the position, where the head moves; m/s."""
    v = run.channels.get("v")
    if v is None:
        return np.zeros(0)
    motion = measured_motion(run, noise)
    moves = (np.abs(motion.v) > motion.resting_speed) & np.isfinite(v)
    return v[moves] - motion.v[moves]


def _local_parabolas(
    x: NDArray[np.float64], width: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Smooth even samples by least-squares parabolas over `width` of them, an odd number.

    Returns values and slopes per sample (Savitzky and Golay 1964); the first and the last
    parabola reach to the ends. SciPy has this filter too, in a package whose import adds
    more than half to that of the diagnosis.
    """
    half = width // 2
    at = np.arange(-half, half + 1.0)
    powers = np.vander(at, 3, increasing=True)
    weights = np.linalg.pinv(powers)
    value, slope = (np.correlate(x, row, mode="valid") for row in weights[:2])
    first, last = weights @ x[:width], weights @ x[-width:]
    before, after = powers[:half], powers[half + 1 :]
    turns = np.array([0.0, 1.0, 2.0])[:, None] * np.vstack([np.zeros(width), powers.T[:2]])
    return (
        np.concatenate([before @ first, value, after @ last]),
        np.concatenate([first @ turns[:, :half], slope, last @ turns[:, half + 1 :]]),
    )


def regimes_of(motion: MeasuredMotion) -> NDArray[np.int64]:
    """Say for every sample of a motion what kind it belongs to (`REGIMES`)."""
    sign = np.where(np.abs(motion.v) <= motion.resting_speed, 0, np.sign(motion.v)).astype(int)
    kind = np.where(sign == 0, 0, np.where(sign > 0, 2, 3))
    found = kind.copy()
    for i in np.flatnonzero(np.diff(sign) != 0):
        if sign[i] == 0:
            before = sign[max(0, i - 4 * _AFTER) : i]
            moved = before[before != 0]
            turned = moved.size > 0 and moved[-1] != sign[i + 1]
            found[i + 1 : i + 1 + _AFTER] = 4 if turned else 1
        elif sign[i + 1] != 0:
            found[max(0, i + 1 - _AFTER) : i + 1 + _AFTER] = 4
    return found.astype(np.int64)
