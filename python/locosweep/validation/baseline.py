"""The plain baseline: the bar that a diagnosis of real rigs has to beat.

Each listed effect is refitted alone, by least squares, on the same whole free runs or windows.
Named is the one with the fewest parameters within a tenth of the smallest error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.validation.rig_problem import errors_of, refits, see, weighed

if TYPE_CHECKING:
    from locosweep.validation.planting import Rig

ALIKE = 1.1
"""Error, in the smallest one, up to which fewer parameters count more: without it ripples of three
parameters win by a hair."""


@dataclass(frozen=True)
class Baseline:
    """What the baseline says: a name, empty where the model alone is as good, and its rivals."""

    name: str
    alike: tuple[str, ...]
    """All names within a tenth of the smallest error."""
    share: float
    """Share of the nominal model's error that the named effect takes away."""
    errors: dict[str, float]
    """Error of each refitted effect over that of the nominal model."""


def baseline(rig: Rig) -> Baseline:
    """Refit each listed effect alone; channels count in units of the nominal model's errors."""
    seen = see(rig)
    seen = weighed(seen, seen.plain_errors)
    fits = refits(seen)
    by_channel = errors_of(seen, fits)
    before = by_channel[""]
    errors = {
        name: float(np.sqrt(np.mean([(e / before[c]) ** 2 for c, e in own.items()])))
        for name, own in by_channel.items()
    }
    least = ALIKE * min(errors.values())
    alike = [name for name, error in errors.items() if error <= least]
    named = min(alike, key=lambda name: (len(fits[name].model.free), errors[name]))
    return Baseline(named, tuple(sorted(alike)), 1.0 - errors[named], errors)
