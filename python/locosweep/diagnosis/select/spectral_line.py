"""A line in the spectrum of residuals: hum of the mains, or a vibration, looks like noise else.

Means over blocks of samples, which the whiteness test compares, take a fast oscillation away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import norm

from locosweep.diagnosis.select.whiteness import WhitenessTest, residuals_by_run, whiteness_test

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

_FEWEST = 64
"""Readings of a run that are needed: of fewer, one line among so many says little."""
_COARSE = 2.0
"""Step of a reading, in deviations of its noise, from which it makes lines of its own: a sensor
that moves evenly reads a saw tooth. Noise of half a step leaves 1 % of its first harmonic."""


@dataclass(frozen=True)
class SpectralLine:
    """The strongest line in the spectra of a fit's whitened residuals."""

    channel: str
    run: int
    period: float
    """In samples, 2 or more: a faster oscillation is folded there."""
    rms: float
    """Root mean square of the oscillation, in deviations of the noise."""
    share: float
    """Of the squares of that run's residuals."""
    deviations: float
    """Normal deviate of its power, the largest of all."""

    @property
    def test(self) -> WhitenessTest:
        """The line as a test of residuals for more than white noise."""
        return WhitenessTest(self.channel, round(self.period), self.deviations, self.rms)

    def told(self, problem: Problem) -> str:
        """Return a warning about the line, with its frequency."""
        run = problem.runs[self.run]
        rate = 1.0 / float(np.median(np.diff(run.t)))
        return (
            f"run {run.label}: what the model leaves of {self.channel} oscillates at "
            f"{rate / self.period:.3g} Hz, or at a frequency that {rate:.4g} readings a second "
            "fold there: hum of the mains, or a vibration?"
        )


def spectral_line(problem: Problem, residual: Floats) -> SpectralLine | None:
    """Return the strongest line in the spectra of residuals that are noise else.

    Powers of white noise are exponentially distributed, about a mean that their median gives
    (after Fisher, Proc. Royal Society A 125, 1929). Coarse readings are left out.
    """
    if whiteness_test(problem, residual).rejected:
        return None
    best: tuple[float, SpectralLine] | None = None
    tried = 0
    for channel, run, values in residuals_by_run(problem, residual):
        noise = problem.noise[channel]
        if values.size < _FEWEST or noise.step > _COARSE * noise.gaussian:
            continue
        powers = np.abs(np.fft.rfft(values - values.mean())[1:-1]) ** 2
        tried += powers.size
        k = int(np.argmax(powers))
        power = float(powers[k]) * np.log(2.0) / max(float(np.median(powers)), 1e-300)
        if best is None or power > best[0]:
            square = 2.0 * float(powers[k]) / values.size**2
            share = square / float(np.mean(values**2))
            period = values.size / (k + 1)
            best = power, SpectralLine(channel, run, period, np.sqrt(square), share, 0.0)
    if best is None:
        return None
    found = replace(best[1], deviations=_deviations(best[0], tried))
    return found if found.test.rejected else None


def _deviations(power: float, tried: int) -> float:
    """Return the normal deviate of the largest of so many powers of unit mean."""
    tail = np.log(tried) - power
    if tail < np.log(np.finfo(float).tiny):
        # Far out, the tail of a normal variable falls as exp(-z^2 / 2).
        return float(np.sqrt(-2.0 * tail))
    return float(norm.isf(-np.expm1(-np.exp(tail))))
