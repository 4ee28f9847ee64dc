"""Parameters that are known as distributions, and points drawn from them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import stats
from scipy.stats import qmc

from locosweep.errors import InputError
from locosweep.grid import real_array
from locosweep.registry import parameter

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_FORMS = "LOW:HIGH, normal:MEAN:DEVIATION, lognormal:MEDIAN:FACTOR, triangular:LOW:MODE:HIGH"
_NUMBERS = {"between": 2, "normal": 2, "lognormal": 2, "triangular": 3}
"""Numbers that each form takes."""
_INSIDE = 1e-12
"""Least distance of a probability from 0 and 1, where many distributions have no finite value."""
_LARGEST = 2**20
"""Points of a sample at most: they are drawn at one go, which Ctrl-C waits for. Ten unknowns take
0.2 s: `sequence(10, 2**20, 0)` on one of two busy processors of an AMD EPYC."""


@dataclass(frozen=True, eq=False)
class Unknown:
    """One parameter that is known as a distribution.

    Attributes
    ----------
    name : str
        The parameter.
    share_of : str or None
        The parameter that its values are multiplied with.
    quantile : callable
        Values at probabilities.
    """

    name: str
    share_of: str | None
    quantile: Callable[[Floats], Floats]

    @property
    def key(self) -> str:
        """What the user called it."""
        return f"{self.name}/{self.share_of}" if self.share_of else self.name


def unknowns(given: Mapping[str, Any]) -> list[Unknown]:
    """Read distributions by the name of their parameter.

    Parameters
    ----------
    given : mapping of str to distribution
        As in `locosweep.propagate`.

    Raises
    ------
    InputError
        An unknown parameter, a form that is not known, or numbers that make no distribution.

    Examples
    --------
    >>> from locosweep.uncertainty.unknowns import unknowns
    >>> one = unknowns({"slope_deg": "normal:5:2"})[0]
    >>> float(one.quantile(0.5))
    5.0
    """
    if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given):
        raise InputError(f"unknown is {given!r}: allowed are distributions by names of parameters")
    if not given:
        raise InputError("unknown is empty: name at least one parameter and its distribution")
    found = []
    for key, value in given.items():
        name, slash, of = key.partition("/")
        record = parameter(name)
        if slash:
            parameter(of)
        law = _distribution(key, value, integer=record.integer and not slash)
        if not slash:
            law = _within(key, law, *record.range)
        found.append(Unknown(name, of if slash else None, law.ppf))
    names = [one.name for one in found]
    for one in found:
        if names.count(one.name) > 1:
            raise InputError(f"unknown gives {one.name} twice: allowed is once")
        if one.share_of in names and any(o.name == one.share_of and o.share_of for o in found):
            raise InputError(
                f"unknown {one.key!r} is a share of another share: allowed is a share of a "
                "parameter that is fixed or has a distribution of its own"
            )
    return found


def _distribution(key: str, value: Any, *, integer: bool) -> Any:
    """Return a distribution of SciPy."""
    if isinstance(value, str):
        return _formed(key, value, integer=integer)
    if hasattr(value, "ppf") and hasattr(value, "cdf"):
        return value
    numbers = real_array(f"unknown {key!r}", value)
    if numbers.ndim == 1 and numbers.size == 2:
        return _between(key, *numbers.tolist(), integer=integer)
    if numbers.ndim != 1 or not numbers.size or not np.isfinite(numbers).all():
        raise InputError(
            f"unknown {key!r} is {value!r}: allowed are {_FORMS} as text, two bounds, several "
            "finite values, or a distribution of scipy.stats"
        )
    return _Values(np.sort(numbers))


def _formed(key: str, text: str, *, integer: bool) -> Any:
    head, *rest = text.split(":")
    form, numbers = (head, rest) if head in _NUMBERS else ("between", [head, *rest])
    try:
        values = [float(one) for one in numbers]
    except ValueError:
        values = []
    if len(values) != _NUMBERS[form] or not all(map(math.isfinite, values)):
        raise InputError(f"unknown {key!r} is {text!r}: allowed are {_FORMS}")
    if form == "between":
        return _between(key, *values, integer=integer)
    if form == "triangular":
        low, mode, high = values
        if not low <= mode <= high or low == high:
            raise InputError(f"unknown {key!r} is {text!r}: allowed is LOW <= MODE <= HIGH")
        return stats.triang((mode - low) / (high - low), low, high - low)
    middle, spread = values
    least = 1.0 if form == "lognormal" else 0.0
    if spread <= least:
        words = "a factor above 1" if form == "lognormal" else "a deviation above 0"
        raise InputError(f"unknown {key!r} is {text!r}: allowed is {words}")
    if form == "normal":
        return stats.norm(middle, spread)
    if middle <= 0.0:
        raise InputError(f"unknown {key!r} is {text!r}: allowed is a median above 0")
    return stats.lognorm(math.log(spread), scale=middle)


def _between(key: str, low: float, high: float, *, integer: bool) -> Any:
    if not (low < high and math.isfinite(high - low)):
        raise InputError(f"unknown {key!r} is {low:g}:{high:g}: allowed is LOW < HIGH, both finite")
    if integer:
        if not (low.is_integer() and high.is_integer()):
            raise InputError(f"unknown {key!r} is {low:g}:{high:g}: allowed are whole numbers")
        return stats.randint(int(low), int(high) + 1)
    return stats.uniform(low, high - low)


@dataclass(frozen=True, eq=False)
class _Values:
    """Equally likely values, in order."""

    values: Floats

    def ppf(self, chance: Floats) -> Floats:
        """Return the value at each probability."""
        count = self.values.size
        where = np.ceil(np.asarray(chance) * count).astype(int) - 1
        found: Floats = self.values[np.clip(where, 0, count - 1)]
        return found

    def cdf(self, value: float) -> float:
        """Return the share of values that are not above one."""
        return float(np.searchsorted(self.values, value, side="right")) / self.values.size


@dataclass(frozen=True, eq=False)
class _Truncated:
    """A distribution within a range."""

    law: Any
    low: float
    high: float

    def ppf(self, chance: Floats) -> Floats:
        """Return the value at each probability."""
        values = self.law.ppf(self.low + np.asarray(chance) * (self.high - self.low))
        return np.asarray(values, np.float64)


def _within(key: str, law: Any, low: float, high: float) -> Any:
    """Truncate a distribution to the range of its parameter."""
    below, up_to = float(law.cdf(np.nextafter(low, -np.inf))), float(law.cdf(high))
    if not below < up_to:
        raise InputError(
            f"unknown {key!r} has no value in the parameter's range: allowed is {low:g} to {high:g}"
        )
    return _Truncated(law, below, up_to)


def points(
    found: Sequence[Unknown], chances: Floats, fixed: Mapping[str, float]
) -> dict[str, Floats]:
    """Return the values of parameters at points.

    Parameters
    ----------
    found : sequence of Unknown
        Read by `unknowns`.
    chances : ndarray, shape (points, unknowns)
        Probabilities, evenly spread between 0 and 1.
    fixed : mapping of str to float
        Parameters that are known.

    Raises
    ------
    InputError
        A share of a parameter that has no value.
    """
    inside = np.clip(chances, _INSIDE, 1.0 - _INSIDE)
    drawn = {
        one.name: np.ascontiguousarray(one.quantile(inside[:, i]), np.float64)
        for i, one in enumerate(found)
    }
    whole = dict(drawn)
    for one in found:
        if one.share_of is None:
            continue
        other: Floats | float | None = drawn.get(one.share_of, fixed.get(one.share_of))
        if other is None:
            other = parameter(one.share_of).default
        if other is None:
            raise InputError(
                f"unknown {one.key!r} is a share of {one.share_of}, which has no value: allowed "
                "is a parameter that is fixed or unknown"
            )
        whole[one.name] = drawn[one.name] * other
    return whole


def sequence(dimensions: int, count: int, seed: int, replicate: int = 0) -> Floats:
    """Return scrambled Sobol points, shape (count, dimensions); the same for the same seed."""
    random = np.random.default_rng([seed, replicate])
    engine = qmc.Sobol(dimensions, scramble=True, rng=random)
    drawn: Floats = engine.random_base2(count.bit_length() - 1)
    return drawn


def power_of_two(name: str, value: int) -> int:
    """Refuse a number of points that leaves a Sobol sequence unbalanced."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 2:
        raise InputError(f"{name} is {value!r}: allowed is a power of two from 2 upward")
    if value & (value - 1) or value > _LARGEST:
        near = min(1 << (int(value).bit_length() - 1), _LARGEST)
        raise InputError(f"{name} is {value}: allowed is a power of two up to 2^20, such as {near}")
    return int(value)


def whole_seed(seed: int) -> int:
    """Refuse what seeds no generator."""
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"seed is {seed!r}: allowed is a whole number from 0 upward")
    return int(seed)
