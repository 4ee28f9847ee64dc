"""A line in the spectrum of residuals that look like noise otherwise: a hum, or a vibration.

Means over blocks of samples, which the whiteness test compares, take a fast oscillation away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import norm

from locosweep.diagnosis.select.thresholds import WHITENESS_LIMIT
from locosweep.diagnosis.select.whiteness import LEAST_NOISE, counted, whiteness_test

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

_ROUNDS = 8
"""Times that an oscillation has to come again in a run: what is slower is a trend."""
_BESIDE, _BETWEEN = 32, 2
"""Powers on either side of one that say how large noise is there, without those next to it, into
which a line spreads that falls between two frequencies. The more there are, the less a power has to
stand out, and the wider a stretch of the spectrum counts as flat."""
_FEWEST = 4 * _ROUNDS
"""Powers that a spectrum needs: of fewer, hardly any lies beyond `_ROUNDS`."""
_COARSE = 2.0
"""Step of a reading, in deviations of its noise, from which it makes lines of its own: a sensor
that moves evenly reads a saw tooth. Noise of half a step leaves 1 % of its first harmonic."""


@dataclass(frozen=True)
class SpectralLine:
    """The strongest line in the spectra of a fit's whitened residuals."""

    channel: str
    run: int
    period: float
    """In readings, 2 or more: a faster oscillation looks like a slower one."""
    rms: float
    """Root mean square of the oscillation, in deviations of the noise."""
    share: float
    """Of the squares of that channel's residuals in that run."""
    deviations: float
    """Normal deviate of its power, the most unlikely of all."""

    def told(self, problem: Problem) -> str:
        """Return a warning about the line, with its frequency."""
        run = problem.runs[self.run]
        t = run.t[counted(problem, self.channel, self.run)]
        rate = (t.size - 1) / float(t[-1] - t[0])
        return (
            f"run {run.label}: what the model leaves of {self.channel} oscillates at "
            f"{rate / self.period:.3g} Hz, or at a higher frequency that {rate:.4g} readings a "
            "second show as this: hum of the mains, or a vibration?"
        )


def spectral_line(problem: Problem, residual: Floats) -> SpectralLine | None:
    """Return the strongest line in the spectra of residuals that are noise otherwise, if any.

    Powers of noise are exponentially distributed, alike next to each other (after Fisher, Proc.
    Royal Society A 125, 1929). One of them over the mean of n others has 2 and 2 n degrees of
    freedom: it is beyond f with probability (1 + f / n)^-n, whatever the noise. Channels are left
    out whose steps are coarse.
    """
    if whiteness_test(problem, residual).rejected:
        return None
    best: SpectralLine | None = None
    least, tried, at = 0.0, 0, 0
    for channel in problem.channels:
        noise = problem.noise[channel]
        for run in problem.fitted:
            length = int(problem.lengths[run])
            values = residual[at : at + length][counted(problem, channel, run)]
            at += length
            powers = _powers(values)
            if powers.size < _FEWEST or noise.step > _COARSE * noise.gaussian:
                continue
            tails = _log_tails(powers, LEAST_NOISE * values.size)
            tried += tails.size
            k = int(np.argmin(tails))
            if tails[k] < least:
                round_ = k + _ROUNDS
                square = 2.0 * float(powers[round_ - 1]) / values.size**2
                least, best = (
                    float(tails[k]),
                    SpectralLine(
                        channel,
                        run,
                        values.size / round_,
                        float(np.sqrt(square)),
                        square / float(np.mean(values**2)),
                        0.0,
                    ),
                )
    if best is None:
        return None
    found = replace(best, deviations=_deviations(least + np.log(tried)))
    return found if found.deviations > WHITENESS_LIMIT else None


def _powers(values: Floats) -> Floats:
    """Return squares of the Fourier sums of values, from one round to one in two values."""
    if values.size < 2:
        return np.zeros(0)
    powers: Floats = np.abs(np.fft.rfft(values - values.mean())[1:]) ** 2
    if values.size % 2 == 0:
        # A real sum: its square varies as much as half of a complex one's.
        powers[-1] *= 0.5
    return powers


def _log_tails(powers: Floats, least: float) -> Floats:
    """Return logarithms of the probability under noise of powers beyond the first few.

    What noise is near each is the mean of the powers on either side, `least` at least.
    """
    k = np.arange(_ROUNDS - 1, powers.size)
    sums = np.cumsum(np.concatenate([np.zeros(1), powers]))

    def within(a: NDArray[np.intp], b: NDArray[np.intp]) -> tuple[Floats, NDArray[np.intp]]:
        a, b = (np.clip(i, 0, powers.size) for i in (a, b))
        return sums[b] - sums[a], b - a

    below, fewer = within(k - _BESIDE, k - _BETWEEN)
    above, more = within(k + _BETWEEN + 1, k + _BESIDE + 1)
    count = fewer + more
    mean = np.maximum((below + above) / count, least)
    return np.asarray(-count * np.log1p(powers[k] / mean / count))


def _deviations(log_tail: float) -> float:
    """Return the normal deviate of a tail, as of the least of many; below 0 where it is likely."""
    if log_tail < np.log(np.finfo(float).tiny):
        # Far out, the tail of a normal variable falls as exp(-z^2 / 2).
        return float(np.sqrt(-2.0 * log_tail))
    return float(norm.isf(-np.expm1(-np.exp(log_tail))))
