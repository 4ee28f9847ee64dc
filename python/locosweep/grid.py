"""Grids: named axes in order and fixed values for the rest."""

from __future__ import annotations

import math
from numbers import Real
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from locosweep import _core
from locosweep.errors import InputError
from locosweep.registry import parameter, unknown

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray


_ROBOT = "robot"
"""Keyword that is no parameter."""


class Grid:
    """Parameters of a sweep: one-dimensional values are axes, numbers are fixed.

    Parameters
    ----------
    **parameters
        By name (see ``locosweep.parameters()``). A number fixes the parameter, a
        sequence, range or array makes it an axis; the order of the axes is the
        order of the arguments. Units are SI (degrees in names that end in
        ``_deg``); objects with ``to`` and ``magnitude`` (Pint) are converted. ``robot``, from
        ``locosweep.load_robot``, fixes what is not given otherwise.

    Attributes
    ----------
    axes : dict of str to ndarray
        The axes in order.
    fixed : dict of str to float
        The parameters given as numbers.

    Raises
    ------
    InputError
        An unknown name, a value outside its range (with its index), an empty
        axis, an array that is not one-dimensional or not real.

    Examples
    --------
    >>> import numpy as np, locosweep as ls
    >>> grid = ls.Grid(mu_static=0.5, mu_coulomb=0.3, segments=range(2, 9))
    >>> grid.shape
    (7,)
    """

    __slots__ = ("_robot_given", "axes", "fixed")

    def __init__(self, **parameters: Any) -> None:
        self._robot_given = parameters.get(_ROBOT) is not None
        self.axes: dict[str, NDArray[np.float64]] = {}
        self.fixed: dict[str, float] = {}
        for name, value in _with_robot(parameters).items():
            number, values = _read(name, value)
            if values is None:
                self.fixed[name] = number
            else:
                self.axes[name] = values
        _core.Sweep(list(self.axes.items()), list(self.fixed.items()), [])

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each axis."""
        return tuple(len(values) for values in self.axes.values())

    @property
    def size(self) -> int:
        """Number of points."""
        return int(np.prod(self.shape, dtype=object))

    def with_fixed(self, parameters: Mapping[str, Any]) -> Grid:
        """Return a grid with further parameters (fixed values or axes, at the end)."""
        if not parameters:
            return self
        twice = self.axes.keys() | self.fixed.keys() | ({_ROBOT} if self._robot_given else set())
        for name in parameters:
            if name in twice:
                raise InputError(f"{name} is given twice: in the grid and beside it")
        grid = Grid(**self.axes, **self.fixed, **parameters)
        grid._robot_given |= self._robot_given
        return grid

    def __repr__(self) -> str:
        axes = [f"{name}[{len(values)}]" for name, values in self.axes.items()]
        fixed = [f"{name}={value:g}" for name, value in self.fixed.items()]
        return f"Grid({', '.join(axes + fixed)})"


def _with_robot(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Put the values of a robot in for the parameters that are not given."""
    given = dict(parameters)
    robot = given.pop(_ROBOT, None)
    if robot is None:
        return given
    own = getattr(robot, "parameters", None)
    if not isinstance(own, dict):
        raise InputError(f"robot is {robot!r}: allowed is what locosweep.load_robot returns")
    return given | {name: value for name, value in own.items() if name not in given}


def _read(name: str, value: Any) -> tuple[float, NDArray[np.float64] | None]:
    """Turn what a user gave into a number or an axis."""
    if _is_number(value):
        return float(real_array(name, value)), None
    if hasattr(value, "magnitude") and hasattr(value, "to"):
        unit = parameter(name).unit
        try:
            value = value.to("dimensionless" if unit == "1" else unit).magnitude
        except (TypeError, ValueError, AttributeError) as error:
            # Units that do not fit, or that nobody knows: so say Pint and packages like it.
            raise InputError(f"{name} is {value}: {error}") from None
    array = real_array(name, value)
    if array.ndim > 1:
        raise InputError(
            f"{name} has {array.ndim} dimensions: allowed is a number or one dimension"
        )
    if array.ndim == 0:
        return float(array), None
    array.flags.writeable = False
    return 0.0, array


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool | np.bool_)


def number(name: str, value: Any, allowed: str) -> float:
    """Refuse what is no finite number, and say what is `allowed`."""
    if not _is_number(value) or not math.isfinite(value):
        raise InputError(f"{name} is {value!r}: allowed is {allowed}")
    return float(value)


def real_array(name: str, value: Any) -> NDArray[np.float64]:
    """Return a copy as an array; text, truth values and masked arrays are no numbers."""
    if np.ma.isMaskedArray(value):
        raise InputError(
            f"{name} is a masked array: allowed are plain numbers (drop or fill first)"
        )
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise InputError(f"{name} is not an array of numbers: {error}") from None
    given = hasattr(value, "dtype")
    if array.dtype == object and not given and array.size and all(map(_is_number, array.flat)):
        # Whole numbers beyond 64 bits, and fractions, are numbers in a list as well as alone.
        try:
            array = array.astype(np.float64)
        except OverflowError:
            raise InputError(f"{name} has a number beyond 1.8e308: allowed is less") from None
    if array.dtype.kind not in "iuf":
        fault = f"has type {array.dtype}" if array.ndim else f"is {value!r}"
        raise InputError(f"{name} {fault}: allowed is a number, or several")
    return array.astype(np.float64, order="C", copy=True)


def index_of(name: str, axis: NDArray[np.float64], wanted: object, *, nearest: bool = False) -> int:
    """Return where in an axis a value stands; with `nearest`, where the value next to it does."""
    if isinstance(wanted, bool) or not isinstance(wanted, Real):
        raise InputError(f"{name} is {wanted!r}: allowed is one number, {few(axis)}")
    number = float(wanted)
    if nearest and np.isfinite(number):
        return int(np.argmin(np.abs(axis - number)))
    span = np.ptp(axis[np.isfinite(axis)]) if np.isfinite(axis).any() else 0.0
    near = np.isclose(axis, number, rtol=1e-9, atol=1e-12 * float(span))
    if not near.any():
        raise InputError(f"{name} is {number:g}: allowed are the values of that axis, {few(axis)}")
    return int(np.argmax(near))


class Selection(NamedTuple):
    """A part of a grid: where it stands along each axis, and what its axes are then."""

    indices: list[int | NDArray[np.intp]]
    """For each axis the index of the value that takes it away, or those of the values kept."""
    axes: dict[str, NDArray[np.float64]]
    fixed: dict[str, float]


def select(
    axes: Mapping[str, NDArray[np.float64]],
    fixed: Mapping[str, float],
    at: Mapping[str, Any],
    method: str | None = None,
) -> Selection:
    """Return the part of a grid at some values of its axes, see `Result.sel`.

    Raises
    ------
    InputError
        An unknown axis or method, or a value that does not stand in its axis.
    """
    if method not in (None, "nearest"):
        raise InputError(f"method is {method!r}: allowed are None and 'nearest'")
    for name in at:
        if name not in axes:
            raise unknown("axis", name, axes)
    near = method == "nearest"
    found = Selection([], {}, dict(fixed))
    for name, axis in axes.items():
        wanted = at.get(name, axis)
        if np.ndim(wanted) == 0:
            found.indices.append(index_of(name, axis, wanted, nearest=near))
            found.fixed[name] = float(axis[found.indices[-1]])
            continue
        some = np.arange(len(axis))
        if name in at:
            if not len(wanted):
                raise InputError(f"{name} is empty: allowed is a value or more, {few(axis)}")
            some = np.array([index_of(name, axis, one, nearest=near) for one in wanted], int)
        found.indices.append(some)
        found.axes[name] = axis[some]
    return found


def few(axis: NDArray[np.float64], most: int = 10) -> str:
    """Write the values of an axis in one line, those in the middle left out where many."""
    numbers = [f"{value:g}" for value in axis]
    if len(numbers) > most:
        numbers = [*numbers[: most - 2], "...", numbers[-1]]
    return ", ".join(numbers) if most > 3 else "|".join(numbers)
