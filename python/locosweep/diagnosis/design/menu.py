"""The menu of further runs that a diagnosis may propose, each a record of what it changes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from locosweep.files.runs import Run

FORCE_NOISE = 0.01
"""Noise of a force sensor that is added, in the drive's largest force."""


@dataclass(frozen=True)
class Change:
    """A further run: a run so far, with one thing changed."""

    name: str
    what: str
    """What to do, for people."""
    driven: Callable[[Run], Run] | None = None
    """The run with its new drive; None if the drive stays."""
    mass: float = 1.0
    """Factor on the mass of the head, by a known payload."""
    turned: bool = False
    """True if the robot is turned round: its slope has the other sign."""
    steeper_deg: float = 0.0
    """What the slope of the ground has more."""
    added: str = ""
    """Channel that a further sensor measures."""

    @property
    def on_slope(self) -> bool:
        """True if it takes a slope, which not every rig has."""
        return self.turned or self.steeper_deg != 0.0

    def of(self, run: Run, slope_deg: float) -> Run:
        """Return a run with its new drive and slope; `slope_deg` is that of a run without one."""
        made = run if self.driven is None else self.driven(run)
        if not self.on_slope:
            return made
        slope = slope_deg if run.slope_deg is None else run.slope_deg
        return replace(made, slope_deg=(-slope if self.turned else slope) + self.steeper_deg)


def _reversed(run: Run) -> Run:
    return replace(run, drive=-run.drive)


def _back(run: Run) -> Run:
    """Drive the run, and then with the opposite drive."""
    return _one_after_another(run, run.drive, -run.drive)


def _later(run: Run) -> Run:
    """Wait as long as the run takes, and drive it then."""
    return _one_after_another(run, np.zeros_like(run.drive), run.drive)


def _slower(run: Run) -> Run:
    return replace(run, t=run.t[0] + 3.0 * (run.t - run.t[0]))


def _dwelling(run: Run) -> Run:
    """Pause four times, for a tenth of the run's length."""
    pause = np.zeros(max(1, run.t.size // 10))
    parts = np.array_split(run.drive, 5)
    return _one_after_another(run, *[part for p in parts for part in (p, pause)][:-1])


def _one_after_another(run: Run, *drives: np.ndarray) -> Run:
    step = float(np.median(np.diff(run.t)))
    drive = np.concatenate(drives)
    return replace(run, t=run.t[0] + step * np.arange(drive.size), drive=drive, channels={})


def _chirp(run: Run) -> Run:
    t = run.since_start
    span = max(float(t[-1]), 1e-9)
    top = float(np.abs(run.drive).max())
    last = 0.1 / max(float(np.median(np.diff(t))), 1e-9)
    turns = 0.3 / span * t * span + 0.5 * (min(last, 20.0) - 0.3) * t**2 / span
    return replace(run, drive=top * np.sin(2.0 * np.pi * turns))


AGAIN = Change("again", "repeat one of these runs exactly")
BACK = Change("back", "drive the same run, and then back over the same way", _back)
MENU = (
    Change("reverse", "drive it backward: the same run with the opposite drive", _reversed),
    BACK,
    Change("later", "wait as long as the run takes, and repeat it then", _later),
    Change("turn round", "turn the robot round on the same ground and repeat the run", turned=True),
    Change("payload", "repeat the run with a known payload of 30 % of the head's mass", mass=1.3),
    Change("incline", "repeat the run on ground that is 5 degrees steeper", steeper_deg=5.0),
    Change("slower", "repeat the run three times slower", _slower),
    Change("dwell", "repeat the run with four pauses without drive", _dwelling),
    Change("chirp", "a chirp from 0.3 Hz upward with the run's largest drive", _chirp),
    Change(
        "force sensor",
        "repeat the run with a sensor of the force between drive and head",
        added="force",
    ),
)
"""Runs that may be proposed."""
