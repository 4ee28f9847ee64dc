"""Drive commands: steps, staircases, ramps, sines, chirps, multisines, gait pulses, triangles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.validation.rigs import log_uniform

if TYPE_CHECKING:
    from numpy.random import Generator
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

KINDS = ("steps", "staircase", "ramp", "sine", "chirp", "multisine", "gait", "triangle")


def sample_times(rng: Generator, rate: float, duration: float, *, jitter: bool) -> Floats:
    """Draw the times of the samples, s from 0, in whole microseconds."""
    t = np.arange(round(duration * rate) + 1) / rate
    if jitter:
        t[1:-1] += rng.uniform(-0.3, 0.3, t.size - 2) / rate
    times: Floats = np.round(t, 6)
    return times


def _levels(t: Floats, starts: Floats, levels: Floats) -> Floats:
    at = np.searchsorted(starts, t, side="right") - 1
    return np.where(at >= 0, levels[np.maximum(at, 0)], 0.0)


def _wave(rng: Generator, kind: str, t: Floats, *, both: bool) -> Floats:
    """Return one drive of both signs, or only a positive one."""
    end = float(t[-1])
    signs = rng.choice([-1.0, 1.0], 40) if both else np.ones(40)
    if kind == "steps":
        starts = np.cumsum(rng.uniform(0.05, 0.35, 40) * end / 3)
        levels = np.where(np.arange(40) % 2 == 0, rng.uniform(0.6, 1.0, 40) * signs, 0.0)
        return _levels(t, starts, levels)
    if kind == "staircase":
        count = int(rng.integers(4, 9))
        starts = np.linspace(0.05, 0.95, count + 1)[:-1] * end
        levels = rng.permutation(np.linspace(0.3, 1.0, count)) * signs[:count]
        if rng.random() < 0.5:
            levels = np.sort(levels)
        return _levels(t, starts, levels)
    if kind == "ramp":
        count = int(rng.integers(1, 4))
        phase = (t / end * count) % 1.0
        sign = signs[np.minimum((t / end * count).astype(int), count - 1)]
        ramp: Floats = sign * np.clip(1.3 * phase - 0.05, 0.0, 1.0) * (phase < 0.85)
        return ramp
    if kind == "triangle":
        phase = (t / end * float(rng.integers(1, 4))) % 1.0
        if both:
            return np.interp(phase, [0.0, 0.25, 0.75, 1.0], [0.0, 1.0, -1.0, 0.0])
        return np.interp(phase, [0.0, 0.5, 1.0], [0.0, 1.0, 0.0])
    if kind == "gait":
        period = log_uniform(rng, 0.25, 1.5)
        duty = rng.uniform(0.25, 0.6)
        turn = rng.integers(1, 4)
        phase = (t / period) % 1.0
        pulse = np.where(
            phase < duty, np.abs(np.sin(np.pi * phase / duty)) ** rng.choice([0.5, 1.0, 2.0]), 0.0
        )
        if both:
            pulse *= np.where(((t / period).astype(int) // turn) % 2 == 0, 1.0, -1.0)
        return pulse
    if kind == "sine":
        wave = np.sin(
            2 * np.pi * log_uniform(rng, 0.4, 4.0) * t + rng.choice([0.0, rng.uniform(0, 6.28)])
        )
    elif kind == "chirp":
        low, high = log_uniform(rng, 0.2, 0.8), log_uniform(rng, 2.0, 8.0)
        wave = np.sin(2 * np.pi * (low * t + 0.5 * (high - low) * t * t / end))
    else:
        count = int(rng.integers(3, 7))
        waves = [
            np.sin(2 * np.pi * log_uniform(rng, 0.3, 6.0) * t + rng.uniform(0, 6.28))
            for _ in range(count)
        ]
        wave = np.sum(waves, axis=0)
        wave /= np.abs(wave).max()
    whole: Floats = wave if both else 0.5 * (1.0 + wave)
    return whole


def draw_shape(rng: Generator, kind: str, t: Floats, *, one_way: bool) -> Floats:
    """Draw one drive of a kind at the times of a run, from -1 to 1, or 0 to 1 if one-way."""
    values = _wave(rng, kind, t, both=not one_way)
    # Most rigs are switched on at rest, some are caught in the middle.
    if rng.random() < 0.75:
        quiet = rng.uniform(0.02, 0.1) * t[-1]
        values = np.where(t < quiet, 0.0, values)
    return values
