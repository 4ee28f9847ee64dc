"""Ranges of an axis as a command or a sweep file gives them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from locosweep.errors import InputError
from locosweep.registry import parameter

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_MOST = 10_000_000
"""Values that one axis may have."""


@dataclass(frozen=True)
class Span:
    """Evenly spaced values of an axis, both ends included.

    Attributes
    ----------
    start, stop : float
        The ends; `stop` may be the lower one when there is a count.
    count : int, optional
        How many values. Without it, every whole number between the ends, which
        only whole parameters have.

    Examples
    --------
    >>> from locosweep.specs.sweep import Span
    >>> Span(2, 5).values("segments")
    array([2., 3., 4., 5.])
    >>> Span(0.0, 10.0, 3).values("slope_deg")
    array([ 0.,  5., 10.])
    """

    start: float
    stop: float
    count: int | None = None

    def check(self, name: str) -> int:
        """Return the number of values; InputError for an end or a count that does not fit."""
        record = parameter(name)
        for end in (self.start, self.stop):
            record.check(end)
        text = f"{name} from {self.start:g} to {self.stop:g}"
        if not (math.isfinite(self.start) and math.isfinite(self.stop)):
            raise InputError(f"{text}: allowed are finite ends")
        count = self.count
        if count is None:
            if not record.integer:
                raise InputError(f"{text} has no count: allowed is that for whole numbers only")
            count = int(self.stop) - int(self.start) + 1
            if count < 1:
                raise InputError(f"{text} is empty: the lower end comes first")
        if not 1 <= count <= _MOST:
            raise InputError(f"{text} has {count} values: allowed are 1 to {_MOST}")
        if count == 1 and self.start != self.stop:
            raise InputError(f"{text} has 1 value: allowed are 2 or more where the ends differ")
        length = abs(int(self.stop) - int(self.start)) if record.integer else 0
        if count > 1 and length % (count - 1):
            raise InputError(
                f"{text} in {count} values is not whole: allowed are counts that are 1 more than "
                f"a divisor of {length}"
            )
        return count

    def values(self, name: str) -> NDArray[np.float64]:
        """Return the values for a parameter, checked."""
        import numpy as np

        from locosweep import memory

        count = self.check(name)
        memory.check(8 * count, None, f"axis {name}")
        return np.linspace(self.start, self.stop, count, dtype=np.float64)
