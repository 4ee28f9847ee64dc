"""Cells of a sweep as a page carries them: few enough to be mailed, each with value or status."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    Axes = Mapping[str, NDArray[np.float64]]

NOT_COMPUTED = 31
"""Status of a cell of a run folder that no chunk holds yet; the core's are below."""
_LEVELS = 65_504
"""Values that 16 bits hold beside 32 statuses; heat.js reads them so."""
_TEXT = 4 / 3
"""Letters of base64 for a byte."""


@dataclass(frozen=True)
class Packed:
    """Cells of one output as text.

    Attributes
    ----------
    text : str
        Base64 of float32, or of 16-bit codes between `low` and `high`.
    kind : {"float32", "uint16"}
        Which; a status is the payload of a NaN, or a code from 65504 on.
    low, high : float
        Ends of the values; 0 and 1 where no cell has one.
    """

    text: str
    kind: str
    low: float
    high: float


def chosen(axes: Axes, outputs: int, limit: int) -> tuple[dict[str, NDArray[np.intp]], str]:
    """Return which values of each axis a page shows, in rising order, and how it stores cells.

    Cells are stored as float32 while all fit into `limit` letters, else in 16 bits. If they do
    not fit so either, of axes longer than some length evenly chosen values are taken, both ends
    included.

    Raises
    ------
    InputError
        Not even two values of every axis fit.

    Examples
    --------
    >>> import numpy as np
    >>> from locosweep.plot.explorer.cells import chosen
    >>> axes = {"mu_static": np.linspace(0.3, 0.6, 200), "segments": np.arange(2.0, 9.0)}
    >>> some, kind = chosen(axes, 1, 3_000)
    >>> {name: len(index) for name, index in some.items()}, kind
    ({'mu_static': 160, 'segments': 7}, 'uint16')
    """
    lengths = [len(axis) for axis in axes.values()]
    cells = int(limit / _TEXT / max(1, outputs))
    kind = "float32" if 4 * prod(lengths) <= cells else "uint16"
    most = cells // (4 if kind == "float32" else 2)
    cap = max(lengths, default=1)
    if prod(lengths) > most:
        low, cap = 1, cap - 1
        while low < cap:
            middle = (low + cap + 1) // 2
            fits = prod(min(length, middle) for length in lengths) <= most
            low, cap = (middle, cap) if fits else (low, middle - 1)
        if cap < 2:
            raise InputError(
                f"{outputs} outputs over {len(lengths)} axes do not fit into a page of {limit} "
                "bytes: take fewer outputs, or fix an axis"
            )
    return {name: _evenly(axis, cap) for name, axis in axes.items()}, kind


def _evenly(axis: NDArray[np.float64], most: int) -> NDArray[np.intp]:
    order = np.argsort(axis, kind="stable")
    if len(axis) <= most:
        return order
    return order[np.linspace(0, len(axis) - 1, most).round().astype(np.intp)]


def packed(values: NDArray[np.floating], codes: NDArray[np.uint8], kind: str) -> Packed:
    """Return the cells of an output as text, in the order of the array.

    Examples
    --------
    >>> import numpy as np
    >>> from locosweep.plot.explorer.cells import packed
    >>> one = packed(np.array([1.0, np.nan, 3.0]), np.array([0, 2, 0], np.uint8), "uint16")
    >>> one.text, one.low, one.high
    ('AADi/9//', 1.0, 3.0)
    """
    works = np.isfinite(values)
    codes = np.where(codes > NOT_COMPUTED, NOT_COMPUTED, codes)
    low, high = 0.0, 1.0
    if works.any():
        low = float(np.min(values, where=works, initial=np.inf))
        high = float(np.max(values, where=works, initial=-np.inf))
    if kind == "float32":
        bits = values.astype("<f4").view("<u4")
        bits = np.where(works, bits, np.uint32(0x7FC00000) | codes.astype(np.uint32))
        return Packed(_base64(bits.astype("<u4")), kind, low, high)
    share = (np.where(works, values, low).astype(np.float64) - low) / ((high - low) or 1.0)
    levels = np.rint(share * (_LEVELS - 1)).astype("<u2")
    return Packed(
        _base64(np.where(works, levels, _LEVELS + codes.astype("<u2")).astype("<u2")),
        kind,
        low,
        high,
    )


def _base64(array: NDArray[np.unsignedinteger]) -> str:
    return base64.b64encode(array.tobytes()).decode("ascii")


def told(full: Axes, shown: Axes, kind: str, steps: Sequence[str]) -> list[str]:
    """Say what a page leaves out: values of axes, and digits; nothing if it leaves out nothing."""
    notes = []
    thinned = [f"{len(shown[name])} of {len(axis)} values of {name}"
               for name, axis in full.items() if len(shown[name]) < len(axis)]  # fmt: skip
    if thinned:
        notes.append(
            f"To keep this page small it holds {', '.join(thinned)}, evenly chosen with both "
            "ends. The commands above compute all."
        )
    if kind == "uint16":
        notes.append(f"Values are stored in 16 bits, rounded to steps of {', '.join(steps)}.")
    return notes
