"""Sweep files: everything that one sweep needs, as TOML that reads back exactly."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Self, overload

from locosweep.errors import InputError
from locosweep.files import toml
from locosweep.registry import parameter, quantities, quantity, reductions, unknown
from locosweep.specs.simulation import SIMULATION, Simulation
from locosweep.specs.span import Span
from locosweep.specs.spec_file import SpecFile

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from locosweep.grid import Grid
    from locosweep.result import Result
    from locosweep.run_folder.run import Run

_FORMAT = "locosweep.sweep/1"


@dataclass(frozen=True)
class Spec(SpecFile):
    """One sweep: quantities, axes, fixed values, and what is folded away.

    Attributes
    ----------
    quantities : tuple of str
        What to compute, at least one.
    axes : tuple of (str, Span or tuple of float)
        Names and values of the axes, in order.
    fixed : tuple of (str, float)
        The parameters that are not swept.
    over : str, optional
        Axis to reduce, together with `reduce`.
    reduce : tuple of str
        How.
    q : float, optional
        Which quantile.
    dtype : {"float64", "float32"}
        Type of the result.
    simulation : Simulation
        Law, drive and method of quantities that are simulated.

    Raises
    ------
    InputError
        Whatever `Grid` and `sweep` would refuse about names and values.

    Examples
    --------
    >>> from locosweep.specs.sweep import Span, Spec
    >>> spec = Spec(("mean_velocity",), (("segments", Span(2, 8)),),
    ...             (("mu_static", 0.5), ("mu_coulomb", 0.3)), "segments", ("argmax",))
    >>> Spec.from_toml(spec.to_toml()) == spec
    True
    >>> float(spec.run().values)
    3.0
    """

    _kind = "sweep file"

    quantities: tuple[str, ...]
    axes: tuple[tuple[str, Span | tuple[float, ...]], ...] = ()
    fixed: tuple[tuple[str, float], ...] = ()
    over: str | None = None
    reduce: tuple[str, ...] = ()
    q: float | None = None
    dtype: str = "float64"
    simulation: Simulation = field(default_factory=Simulation)

    def __post_init__(self) -> None:
        _names("quantities", self.quantities, empty=False)
        _names("reduce", self.reduce, empty=True)
        for name in self.quantities:
            quantity(name)
        for name in self.reduce:
            if name not in reductions():
                raise unknown("reduction", name, reductions())
        given = [name for name, _ in (*self.axes, *self.fixed)]
        for i, name in enumerate(given):
            parameter(name)
            if name in given[:i]:
                raise InputError(f"{name} is given twice: allowed is one axis or one value")
        for name, values in self.axes:
            if isinstance(values, tuple):
                if not values:
                    raise InputError(f"axis {name} is empty: it needs at least one value")
                for value in values:
                    parameter(name).check(value)
            else:
                values.check(name)
        for name, value in self.fixed:
            parameter(name).check(value)
        if (self.over is None) != (not self.reduce):
            raise InputError("over and reduce go together: the axis to fold away, and how")
        if self.over is not None and self.over not in dict(self.axes):
            raise unknown("axis", self.over, dict(self.axes))
        if self.q is not None and "quantile" not in self.reduce:
            raise InputError(f"q is {self.q:g}: allowed only together with reduce 'quantile'")
        if "quantile" in self.reduce and not 0 <= (math.nan if self.q is None else self.q) <= 1:
            given_q = "missing" if self.q is None else f"{self.q:g}"
            raise InputError(f"q is {given_q}: allowed is a number from 0 to 1")
        if self.simulation.given and not any(quantity(name).simulated for name in self.quantities):
            raise InputError(
                f"{self.simulation.given[0]} is given, but {', '.join(self.quantities)} is not "
                f"simulated: allowed beside one of {', '.join(simulated())}"
            )
        if self.dtype not in ("float64", "float32"):
            raise InputError(f"dtype is {self.dtype!r}: allowed are float64, float32")

    def grid(self) -> Grid:
        """Return the grid with all values."""
        from locosweep.grid import Grid

        axes: dict[str, Any] = {
            name: list(values) if isinstance(values, tuple) else values.values(name)
            for name, values in self.axes
        }
        return Grid(**axes, **dict(self.fixed))

    @overload
    def run(self, *, out: str | os.PathLike[str], **options: Any) -> Run: ...

    @overload
    def run(self, **options: Any) -> Result: ...

    def run(self, **options: Any) -> Result | Run:
        """Sweep; takes the options of `sweep` (out, threads, progress, token, ...)."""
        from locosweep import memory
        from locosweep.engine import sweep

        if not isinstance(options.get("out"), str | os.PathLike):
            # Before the axes themselves take time and memory.
            memory.check(self._bytes(), options.get("memory_limit"), "the result")
        found: Result | Run = sweep(
            self.quantities,
            self.grid(),
            over=self.over,
            reduce=self.reduce or None,
            q=self.q,
            dtype=self.dtype,
            **self.simulation.options(),
            **options,
        )
        return found

    def _bytes(self) -> int:
        """Bytes of the values in memory."""
        counts = {
            name: len(values) if isinstance(values, tuple) else values.check(name)
            for name, values in self.axes
        }
        cells = math.prod(count for name, count in counts.items() if name != self.over)
        outputs = len(self.quantities) * max(1, len(self.reduce))
        return cells * outputs * (4 if self.dtype == "float32" else 8)

    def to_toml(self) -> str:
        """Return the text of a sweep file."""
        return toml.write(
            {
                "format": _FORMAT,
                "quantities": self.quantities,
                "over": self.over,
                "reduce": self.reduce or None,
                "q": self.q,
                "dtype": self.dtype,
                "simulation": {key: getattr(self.simulation, key) for key in SIMULATION},
                "axes": {name: _written(values) for name, values in self.axes},
                "fixed": dict(self.fixed),
            }
        )

    @classmethod
    def _of(cls, document: dict[str, Any], folder: Path) -> Self:
        return cls(**_read(document, folder))

    def _moved(self, folder: Path) -> Self:
        return replace(self, simulation=self.simulation.moved(folder))


def simulated() -> list[str]:
    """Names of the quantities that are found by simulation."""
    return [q.name for q in quantities() if q.simulated]


def _names(key: str, names: tuple[str, ...], *, empty: bool) -> None:
    if not names and not empty:
        raise InputError(f"{key} is empty: name at least one")
    for i, name in enumerate(names):
        if name in names[:i]:
            raise InputError(f"{key} names '{name}' twice")


def _written(values: Span | tuple[float, ...]) -> object:
    if isinstance(values, tuple):
        return values
    return {"from": values.start, "to": values.stop, "count": values.count}


_KEYS = ("format", "quantities", "over", "reduce", "q", "dtype", "simulation", "axes", "fixed")
_SPAN_KEYS = ("from", "to", "count")


def _read(document: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the arguments of a Spec."""
    toml.check_keys("key", document, _KEYS)
    toml.check_format(document, _FORMAT)
    if "quantities" not in document:
        raise InputError("quantities is missing: a list of names")
    over, q = document.get("over"), document.get("q")
    simulation = toml.table(document, "simulation")
    toml.check_keys("key in [simulation]", simulation, SIMULATION)
    words: dict[str, Any] = {k: toml.word(f"[simulation] {k}", v) for k, v in simulation.items()}
    axes, fixed = (toml.table(document, key) for key in ("axes", "fixed"))
    for name in (*axes, *fixed):
        parameter(name)
    return {
        "quantities": _words("quantities", document["quantities"]),
        "axes": tuple((name, _axis(f"[axes] {name}", value)) for name, value in axes.items()),
        "fixed": tuple((n, toml.number(f"[fixed] {n}", value)) for n, value in fixed.items()),
        "over": None if over is None else toml.word("over", over),
        "reduce": _words("reduce", document.get("reduce", [])),
        "q": None if q is None else toml.number("q", q),
        "dtype": toml.word("dtype", document.get("dtype", "float64")),
        "simulation": Simulation(**words, folder=folder),
    }


def _axis(where: str, value: object) -> Span | tuple[float, ...]:
    if isinstance(value, list):
        return tuple(toml.number(f"{where}[{i}]", one) for i, one in enumerate(value))
    if not isinstance(value, dict):
        raise InputError(f"{where} is {value!r}: allowed is a list or {{ from, to, count }}")
    toml.check_keys(f"key in {where}", value, _SPAN_KEYS)
    for key in ("from", "to"):
        if key not in value:
            raise InputError(f"{where} has no '{key}': allowed is {{ from, to, count }}")
    count = value.get("count")
    if count is not None and (isinstance(count, bool) or not isinstance(count, int)):
        raise InputError(f"{where} count is {count!r}: allowed is a whole number")
    start, stop = (toml.number(f"{where} {key}", value[key]) for key in ("from", "to"))
    return Span(start, stop, count)


def _words(where: str, value: object) -> tuple[str, ...]:
    if isinstance(value, str):
        return (value,)
    if not isinstance(value, list):
        raise InputError(f"{where} is {value!r}: allowed is a list of words in quotes")
    return tuple(toml.word(f"{where}[{i}]", one) for i, one in enumerate(value))
