"""Sensor noise of each channel, and runs of readings that one quantisation step holds."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.stamp_jitter import stamp_jitter
from locosweep.diagnosis.data.white_noise import OVERSTATED, noise_beyond, white_level
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
    """True if the nominal file states it, and the readings do not show far more."""
    late: float = 0.0
    """Deviation in s by which readings are early or late, beside `sd`."""

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
    """Return a channel's noise as the file states it, or as estimated from the readings.

    Readings that all show more than `UNDERSTATED` times the stated noise are believed.
    """
    kind = CHANNELS[channel].sensor
    stated = sensor.get(f"{kind}_noise")
    step = sensor.get(f"{kind}_resolution", 0.0)
    seen, grain = _seen([run.channels[channel] for run in runs if channel in run.channels])
    # A grain much finer than the noise is how the file was printed.
    step = max(step, grain if grain > 0.3 * seen else 0.0)
    late = stamp_jitter(channel, runs) if CHANNELS[channel].sensor == "position" else 0.0
    if stated is None:
        sd = max(seen, step / np.sqrt(12.0), 1e-12)
        gaussian = np.sqrt(max(sd**2 - step**2 / 12.0, 0.0))
        return Noise(float(sd), float(gaussian), float(step), stated=False, late=late)
    sd = max(float(np.hypot(stated, step / np.sqrt(12.0))), 1e-12)
    # Of readings that are early or late, what all windows in motion show is not at rest.
    more = noise_beyond(sd, channel, runs) if late == 0.0 else 0.0
    if more > 0.0:
        gaussian = float(np.sqrt(max(more**2 - step**2 / 12.0, 0.0)))
        return Noise(more, gaussian, float(step), stated=False, late=late)
    return Noise(sd, float(stated), float(step), stated=True, late=late)


def noise_warnings(runs: Sequence[Run], sensor: Mapping[str, float]) -> list[str]:
    """Return a warning for each channel whose readings contradict the noise that is stated."""
    said = []
    for channel, record in CHANNELS.items():
        stated = sensor.get(f"{record.sensor}_noise")
        if stated is None or not any(channel in run.channels for run in runs):
            continue
        noise = noise_of(channel, runs, sensor)
        if noise.late > 0.0:
            said.append(
                f"{channel}: the noise of the readings grows with the speed, as if they were "
                f"{noise.late:.2g} s early or late: fast readings count for less"
            )
        if not noise.stated:
            said.append(
                f"{channel}: all readings show noise of {noise.sd:.2g}, {noise.sd / stated:.2g} "
                f"times the stated {stated:.2g}: that of the readings counts"
            )
            continue
        seen = white_level(channel, runs)
        seen = float(np.hypot(seen, noise.step / np.sqrt(12.0))) if seen > 0.0 else 0.0
        if 0.0 < seen < OVERSTATED * noise.sd:
            said.append(
                f"{channel}: the readings show noise of {seen:.2g}, the nominal file states "
                f"{stated:.2g}, which counts: gaps below it stay unseen"
            )
    return said


def grain_of(channel: str, runs: Sequence[Run]) -> float:
    """Return the smallest step between readings: of a quantiser, or of printed digits."""
    return _seen([run.channels[channel] for run in runs if channel in run.channels])[1]


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


def weights_of(y: Floats, noise: Noise, starts_at: NDArray[np.intp]) -> Floats:
    """Return the inverse deviation of every reading, 0 where there is none.

    `starts_at` has the first sample of each run, and one beyond the last.
    """
    weight = np.where(np.isfinite(y), 1.0 / noise.sd, 0.0)
    if noise.stuck > 0.05 * noise.sd:
        # Samples at rest repeat one error of the quantiser: together they
        # count for as many as have the variance of their mean.
        for a, b in pairwise(starts_at):
            number = stretches(y[a:b], noise.step * 1.01 + 4.0 * noise.gaussian)
            read = np.isfinite(y[a:b])
            counts = np.maximum(np.bincount(number, read), 1.0)[number]
            effective = noise.sd**2 / (noise.sd**2 / counts + noise.stuck**2)
            weight[a:b] *= np.sqrt(np.minimum(1.0, effective / counts))
    return weight
