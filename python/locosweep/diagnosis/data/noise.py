"""Sensor noise of each channel, and runs of readings that one quantisation step holds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.files.channels import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

_THIRD = np.sqrt(20.0)
"""Standard deviation of third differences of white noise of deviation 1."""


@dataclass(frozen=True)
class Noise:
    """Noise of one channel, in its unit."""

    sd: float
    """Standard deviation of a sample, quantisation included."""
    gaussian: float
    """Part of `sd` that differs from sample to sample at rest."""
    step: float
    """Quantisation step; 0 where none shows."""
    stated: bool
    """True if the nominal file states it."""

    @property
    def stuck(self) -> float:
        """Standard deviation of the error that averaging at rest does not remove.

        A quantiser with noise of deviation s and step q errs on average by
        q/(pi sqrt(2)) exp(-2 pi^2 s^2/q^2): little from s = q/2 on.
        """
        if self.step == 0.0:
            return 0.0
        ratio = self.gaussian / self.step
        return float(self.step / (np.pi * np.sqrt(2.0)) * np.exp(-2.0 * (np.pi * ratio) ** 2))


def noise_of(channel: str, runs: Sequence[Run], sensor: Mapping[str, float]) -> Noise:
    """Return a channel's noise as the file states it, or as estimated from the readings."""
    kind = CHANNELS[channel].sensor
    stated = sensor.get(f"{kind}_noise")
    step = sensor.get(f"{kind}_resolution", 0.0)
    seen, grain = _seen([run.channels[channel] for run in runs if channel in run.channels])
    # A grain finer than a thousandth of the noise is how the file was printed.
    step = max(step, grain if grain > 0.3 * seen else 0.0)
    if stated is None:
        sd = max(seen, step / np.sqrt(12.0), 1e-12)
        gaussian = np.sqrt(max(sd**2 - step**2 / 12.0, 0.0))
        return Noise(float(sd), float(gaussian), float(step), stated=False)
    sd = float(np.hypot(stated, step / np.sqrt(12.0)))
    return Noise(max(sd, 1e-12), float(stated), float(step), stated=True)


def _seen(readings: list[Floats]) -> tuple[float, float]:
    """Return the deviation of white noise, from third differences, and the smallest step."""
    thirds, grains = [], []
    for values in readings:
        known = values[np.isfinite(values)]
        if known.size < 8:
            continue
        thirds.append(np.abs(np.diff(known, 3)))
        steps = np.abs(np.diff(np.unique(known)))
        span = float(np.ptp(known))
        steps = steps[steps > 1e-9 * max(span, 1e-300)]
        if steps.size:
            grains.append(float(steps.min()))
    if not thirds:
        return 0.0, 0.0
    third = np.concatenate(thirds)
    deviation = float(np.median(third)) / 0.6745 / _THIRD
    return deviation, min(grains, default=0.0)


def stretches(values: Floats, width: float) -> NDArray[np.intp]:
    """Count stretches within which a reading stays in a band of `width`, sample by sample."""
    number = np.zeros(values.size, dtype=np.intp)
    low = high = values[0] if values.size else 0.0
    count = 0
    for i, value in enumerate(values.tolist()):
        if not np.isfinite(value):
            number[i] = count
            continue
        low, high = min(low, value), max(high, value)
        if high - low > width:
            count += 1
            low = high = value
        number[i] = count
    return number
