"""The menu of further runs that a diagnosis may propose."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.files.runs import Run

if TYPE_CHECKING:
    from collections.abc import Callable

PAYLOAD, _INCLINE = 1.3, 5.0
FORCE_NOISE = 0.01
"""Noise of a force sensor that is added, in the drive's largest force."""


def _reversed(run: Run, _: float) -> Run:
    return replace(run, drive=-run.drive)


def _same(run: Run, _: float) -> Run:
    return run


def _turned(run: Run, slope: float) -> Run:
    return replace(run, slope_deg=-(slope if run.slope_deg is None else run.slope_deg))


def _inclined(run: Run, slope: float) -> Run:
    return replace(run, slope_deg=(slope if run.slope_deg is None else run.slope_deg) + _INCLINE)


def _slower(run: Run, _: float) -> Run:
    return replace(run, t=run.t[0] + 3.0 * (run.t - run.t[0]))


def _dwelling(run: Run, _: float) -> Run:
    """Pause four times, for a tenth of the run's length."""
    step = float(np.median(np.diff(run.t)))
    pause = max(1, run.t.size // 10)
    parts = np.array_split(run.drive, 5)
    drive = np.concatenate([part for p in parts for part in (p, np.zeros(pause))][:-1])
    return replace(run, t=run.t[0] + step * np.arange(drive.size), drive=drive, channels={})


def _chirp(run: Run, _: float) -> Run:
    t = run.since_start
    span = max(float(t[-1]), 1e-9)
    top = float(np.abs(run.drive).max())
    last = 0.1 / max(float(np.median(np.diff(t))), 1e-9)
    turns = 0.3 / span * t * span + 0.5 * (min(last, 20.0) - 0.3) * t**2 / span
    return replace(run, drive=top * np.sin(2.0 * np.pi * turns))


MENU: tuple[tuple[str, Callable[[Run, float], Run], str], ...] = (
    ("reverse", _reversed, "drive it backward: the same run with the opposite drive"),
    ("turn round", _turned, "turn the robot round on the same ground and repeat the run"),
    ("payload", _same, "repeat the run with a known payload of 30 % of the head's mass"),
    ("incline", _inclined, "repeat the run on ground that is 5 degrees steeper"),
    ("slower", _slower, "repeat the run three times slower"),
    ("dwell", _dwelling, "repeat the run with four pauses without drive"),
    ("chirp", _chirp, "a chirp from 0.3 Hz upward with the run's largest drive"),
    ("force sensor", _same, "repeat the run with a sensor of the force between drive and head"),
)
