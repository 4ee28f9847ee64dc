"""Sweep files: everything that one sweep needs, as TOML that reads back exactly."""

from __future__ import annotations

import json
import math
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from locosweep.errors import DataFileError, InputError
from locosweep.registry import parameter, quantities, quantity, reductions, unknown
from locosweep.specs.simulation import SIMULATION, Simulation
from locosweep.specs.span import Span

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable, Mapping

    from locosweep.grid import Grid
    from locosweep.result import Result

__all__ = ["Span", "Spec"]

_FORMAT = "locosweep.sweep/1"


@dataclass(frozen=True)
class Spec:
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
        for place, name in enumerate(given):
            parameter(name)
            if name in given[:place]:
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

    def run(self, **options: Any) -> Result:
        """Sweep; takes the options of `sweep` (threads, progress, token, ...)."""
        from locosweep import memory
        from locosweep.engine import sweep

        counts = {
            name: len(values) if isinstance(values, tuple) else values.check(name)
            for name, values in self.axes
        }
        cells = math.prod(count for name, count in counts.items() if name != self.over)
        outputs = len(self.quantities) * max(1, len(self.reduce))
        size = 4 if self.dtype == "float32" else 8
        # Before the axes themselves take time and memory.
        memory.check(cells * outputs * size, options.get("memory_limit"), "the result")
        return sweep(
            self.quantities,
            self.grid(),
            over=self.over,
            reduce=self.reduce or None,
            q=self.q,
            dtype=self.dtype,
            **self.simulation.options(),
            **options,
        )

    def to_toml(self) -> str:
        """Return the text of a sweep file."""
        lines = [f"format = {_text(_FORMAT)}", f"quantities = {_list(map(_text, self.quantities))}"]
        if self.over is not None:
            lines.append(f"over = {_text(self.over)}")
            lines.append(f"reduce = {_list(map(_text, self.reduce))}")
        if self.q is not None:
            lines.append(f"q = {_number(self.q)}")
        lines.append(f"dtype = {_text(self.dtype)}")
        if self.simulation.given:
            lines += ["", "[simulation]"]
        for name in self.simulation.given:
            lines.append(f"{name} = {_text(getattr(self.simulation, name))}")
        if self.axes:
            lines += ["", "[axes]"]
        for name, values in self.axes:
            if isinstance(values, tuple):
                text = _list(map(_number, values))
            else:
                text = f"{{ from = {_number(values.start)}, to = {_number(values.stop)}"
                text += " }" if values.count is None else f", count = {values.count} }}"
            lines.append(f"{name} = {text}")
        if self.fixed:
            lines += ["", "[fixed]"]
        lines += [f"{name} = {_number(value)}" for name, value in self.fixed]
        return "\n".join(lines) + "\n"

    @classmethod
    def from_toml(cls, text: str, *, source: str = "sweep file") -> Spec:
        """Read the text of a sweep file.

        Parameters
        ----------
        text : str
            TOML.
        source : str
            What to call it in messages.

        Raises
        ------
        DataFileError
            Not TOML, an unknown key (with the nearest known one), a value of the
            wrong kind, or anything that `Spec` refuses.
        """
        try:
            document = tomllib.loads(text)
        except (tomllib.TOMLDecodeError, RecursionError) as error:
            raise DataFileError(f"{source}: not TOML: {error}") from None
        try:
            return _read(document)
        except InputError as error:
            raise DataFileError(f"{source}: {error}") from None

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Spec:
        """Read a sweep file."""
        path = Path(path)
        try:
            text = path.read_bytes().decode("utf-8-sig")
        except OSError as error:
            raise DataFileError(f"{path}: {error.strerror or error}") from None
        except UnicodeDecodeError as error:
            raise DataFileError(f"{path}: not TOML: {error}") from None
        spec = cls.from_toml(text, source=str(path))
        return replace(spec, simulation=spec.simulation.beside(path.parent))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a sweep file, in one step."""
        from locosweep.files.atomic import replacing

        moved = replace(self, simulation=self.simulation.moved(Path(path).parent))
        with replacing(path) as temporary:
            temporary.write_text(moved.to_toml(), encoding="utf-8", newline="\n")


def simulated() -> list[str]:
    """Names of the quantities that are found by simulation."""
    return [q.name for q in quantities() if q.simulated]


def _names(key: str, names: tuple[str, ...], *, empty: bool) -> None:
    if not names and not empty:
        raise InputError(f"{key} is empty: name at least one")
    for place, name in enumerate(names):
        if name in names[:place]:
            raise InputError(f"{key} names '{name}' twice")


def _text(word: str) -> str:
    # The escapes of JSON are those of TOML, apart from DEL, which JSON leaves bare.
    return json.dumps(word, ensure_ascii=True).replace("\x7f", "\\u007f")


def _number(value: float) -> str:
    return repr(int(value)) if isinstance(value, int) else repr(float(value))


def _list(words: Iterable[str]) -> str:
    return f"[{', '.join(words)}]"


_KEYS = ("format", "quantities", "over", "reduce", "q", "dtype", "simulation", "axes", "fixed")
_SPAN_KEYS = ("from", "to", "count")


def _read(document: Mapping[str, Any]) -> Spec:
    _known("key", document, _KEYS)
    form = document.get("format", _FORMAT)
    if form != _FORMAT:
        raise InputError(f"format is {form!r}: this version reads {_FORMAT!r}")
    if "quantities" not in document:
        raise InputError("quantities is missing: a list of names")
    over, q = document.get("over"), document.get("q")
    return Spec(
        quantities=_strings("quantities", document["quantities"]),
        axes=tuple((name, _axis(name, value)) for name, value in _table(document, "axes").items()),
        fixed=tuple(
            (name, _float(f"[fixed] {name}", value))
            for name, value in _table(document, "fixed").items()
        ),
        over=None if over is None else _string("over", over),
        reduce=_strings("reduce", document.get("reduce", [])),
        q=None if q is None else _float("q", q),
        dtype=_string("dtype", document.get("dtype", "float64")),
        simulation=_simulation(document.get("simulation", {})),
    )


def _simulation(table: object) -> Simulation:
    if not isinstance(table, dict):
        raise InputError("simulation is not a table: write [simulation]")
    _known("key in [simulation]", table, SIMULATION)
    words: dict[str, Any] = {k: _string(f"[simulation] {k}", word) for k, word in table.items()}
    return Simulation(**words)


def _known(kind: str, given: Iterable[str], known: tuple[str, ...]) -> None:
    for key in given:
        if key not in known:
            raise unknown(kind, key, known)


def _table(document: Mapping[str, Any], key: str) -> dict[str, Any]:
    table = document.get(key, {})
    if not isinstance(table, dict):
        raise InputError(f"{key} is not a table: write [{key}]")
    for name in table:
        parameter(name)
    return table


def _axis(name: str, value: object) -> Span | tuple[float, ...]:
    where = f"[axes] {name}"
    if isinstance(value, list):
        return tuple(_float(f"{where}[{i}]", one) for i, one in enumerate(value))
    if not isinstance(value, dict):
        raise InputError(f"{where} is {value!r}: allowed is a list or {{ from, to, count }}")
    _known(f"key in {where}", value, _SPAN_KEYS)
    for key in ("from", "to"):
        if key not in value:
            raise InputError(f"{where} has no '{key}': allowed is {{ from, to, count }}")
    count = value.get("count")
    if count is not None and (isinstance(count, bool) or not isinstance(count, int)):
        raise InputError(f"{where} count is {count!r}: allowed is a whole number")
    return Span(_float(f"{where} from", value["from"]), _float(f"{where} to", value["to"]), count)


def _float(where: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{where} is {value!r}: allowed is a number")
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{where} is too large: allowed is a number below 1.8e308") from None


def _string(where: str, value: object) -> str:
    if not isinstance(value, str):
        raise InputError(f"{where} is {value!r}: allowed is a word in quotes")
    return value


def _strings(where: str, value: object) -> tuple[str, ...]:
    if isinstance(value, str):
        return (value,)
    if not isinstance(value, list):
        raise InputError(f"{where} is {value!r}: allowed is a list of words in quotes")
    return tuple(_string(f"{where}[{i}]", one) for i, one in enumerate(value))
