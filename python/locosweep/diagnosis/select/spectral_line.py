"""A line in the spectrum of residuals that look like noise otherwise: a hum, or a vibration.

Means over blocks of samples, which the whiteness test compares, take a fast oscillation away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import gammaln, logsumexp, ndtri_exp

from locosweep.diagnosis.select.thresholds import WHITENESS_LIMIT
from locosweep.diagnosis.select.whiteness import (
    LEAST_NOISE,
    counted,
    residuals_by_run,
    whiteness_test,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

# None of these numbers was tuned on cases.
_ROUNDS = 8
"""Times that an oscillation has to come again in a run: what is slower is a trend."""
_BESIDE, _BETWEEN = 32, 2
"""Powers on either side of one that say how large noise is there, without those next to it, into
which a line spreads that falls between two frequencies. The more there are, the less a power has to
stand out, and the wider a stretch of the spectrum counts as flat."""
_FEWEST = 8 * _ROUNDS
"""Readings that a run needs: of fewer, hardly any frequency is seen that comes so often."""
_COARSE = 2.0
"""Step of a reading, in deviations of its noise, from which it makes lines of its own: a sensor
that moves evenly reads a saw tooth. Noise of half a step leaves 1 % of its first harmonic."""
_TINY = 700.0
"""Amount of the logarithm of a tail beyond which the tail is no number of its own."""


@dataclass(frozen=True)
class SpectralLine:
    """The strongest line in the spectra of a fit's whitened residuals."""

    channel: str
    run: int
    period: float
    """In readings, 2 or more: a faster oscillation looks like a slower one."""
    share: float
    """Of the squares of that channel's residuals in that run."""
    deviations: float
    """Normal deviate of the most unlikely powers of its channel's runs together."""

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
    freedom: it is beyond f with probability (1 + f / n)^-n, whatever the noise. All runs of a
    channel count together, each with the most unlikely power of its own. Channels whose steps are
    coarse are left out.
    """
    if whiteness_test(problem, residual).rejected:
        return None
    found: dict[str, list[tuple[float, SpectralLine]]] = {}
    for channel, run, values in residuals_by_run(problem, residual):
        noise = problem.noise[channel]
        if values.size < _FEWEST or noise.step > _COARSE * noise.gaussian:
            continue
        tail, period, square = _most_unlikely(values)
        share = square / max(float(np.mean(values**2)), square, 1e-300)
        line = SpectralLine(channel, run, period, share, 0.0)
        found.setdefault(channel, []).append((tail, line))
    if not found:
        return None
    tails = {c: _log_of_product([tail for tail, _ in found[c]]) for c in found}
    channel = min(tails, key=lambda c: tails[c])
    deviations = -float(ndtri_exp(_log_of_least(tails[channel], len(tails))))
    if deviations <= WHITENESS_LIMIT:
        return None
    return replace(min(found[channel], key=lambda one: one[0])[1], deviations=deviations)


def _most_unlikely(values: Floats) -> tuple[float, float, float]:
    """Return the logarithm of the tail of a run's strongest line, its period and mean square."""
    powers = _powers(values)
    tails = _log_tails(powers, LEAST_NOISE * values.size)
    k = int(np.argmin(tails))
    tail, rounds = _log_of_least(float(tails[k]), tails.size), k + _ROUNDS
    return tail, values.size / rounds, 2.0 * float(powers[rounds - 1]) / values.size**2


def _powers(values: Floats) -> Floats:
    """Return squares of the Fourier sums of values, from one round to one in two values."""
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


def _log_of_least(log_tail: float, count: int) -> float:
    """Return the logarithm of the probability that the least of so many tails is below one."""
    if log_tail < -_TINY:
        return log_tail + float(np.log(count))
    if log_tail >= 0.0:
        return 0.0
    return float(np.log(-np.expm1(count * np.log1p(-np.exp(log_tail)))))


def _log_of_product(log_tails: Sequence[float]) -> float:
    """Return the logarithm of the probability that a product of tails is below theirs (Fisher)."""
    s, k = max(-sum(log_tails), 1e-300), np.arange(len(log_tails))
    return float(-s + logsumexp(k * np.log(s) - gammaln(k + 1)))
