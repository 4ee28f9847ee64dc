"""Levels of the load that are there, of which a picture shows some."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_APART = 0.1
"""Least distance of two levels, as a share of the higher one: strokes to and fro under one weight
differ by less."""
_PARTS = 100
"""Parts of the range of loads in which samples are counted; levels are one part apart, or more."""
_RARE = 0.001
"""Share of the samples below which a part lies between levels: the load on its way."""


def load_levels(load: Floats, most: int) -> list[tuple[float, float]]:
    """Return the ranges [N] of up to `most` levels of the load, rising.

    Levels are what gaps part. Of many, those spread evenly from the lowest to the highest are
    returned; a load that varies without gaps is cut into parts of as many samples.

    Examples
    --------
    >>> import numpy as np
    >>> from locosweep.friction_fit.levels import load_levels
    >>> load_levels(np.array([20.0, 20.5, 21.0, 60.0, 61.0]), 3)
    [(20.0, 21.0), (60.0, 61.0)]
    """
    found = _parted(np.sort(load))
    if len(found) > most:
        chosen = np.linspace(0, len(found) - 1, most).round().astype(int)
        return [found[i] for i in chosen]
    low, high = found[0]
    if len(found) == 1 and high - low > 2.0 * _APART * abs(float(np.median(load))):
        edges = np.quantile(load, np.linspace(0.0, 1.0, most + 1)).tolist()
        return [(a, b) for a, b in pairwise(edges) if b > a]
    return found


def _parted(load: Floats) -> list[tuple[float, float]]:
    """Return the ranges of rising loads between gaps."""
    counts, edges = np.histogram(load, _PARTS)
    # In few samples each one counts.
    usual = counts > _RARE * load.size
    kept = load[usual[np.clip(np.searchsorted(edges, load, side="right") - 1, 0, _PARTS - 1)]]
    size = np.maximum(np.abs(kept[1:]), np.abs(kept[:-1]))
    least = np.maximum(_APART * size, (load[-1] - load[0]) / _PARTS)
    cuts = np.flatnonzero(np.diff(kept) > least)
    firsts, lasts = np.append(0, cuts + 1), np.append(cuts, kept.size - 1)
    return [(float(kept[a]), float(kept[b])) for a, b in zip(firsts, lasts, strict=True)]
