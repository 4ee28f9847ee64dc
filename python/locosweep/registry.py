"""Parameters, quantities, statuses and reductions, as the Rust core defines them."""

from __future__ import annotations

from difflib import get_close_matches
from enum import IntEnum
from functools import cache
from typing import TYPE_CHECKING, TypeVar

from locosweep import _core
from locosweep._core import Drive as Drive
from locosweep._core import Effect as Effect
from locosweep._core import Gait as Gait
from locosweep._core import Law as Law
from locosweep._core import Parameter as Parameter
from locosweep._core import Quantity as Quantity
from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable

_MOST_NAMED = 12
"""Names that an error lists all: one line of a terminal or two."""
_CLOSE = 4
"""Nearest names that an error lists of many."""
_LISTS = {
    "quantity": "quantities",
    "parameter": "parameters",
    "parameter of a gait": "parameters",
    "friction law": "laws",
    "law": "laws",
    "drive": "drives",
    "effect": "effects",
}
"""Commands that list all names of a kind."""

_Record = TypeVar("_Record", Parameter, Quantity, Law, Drive)


@cache
def _parameters() -> dict[str, Parameter]:
    return {p.name: p for p in _core.parameters()}


@cache
def _quantities() -> dict[str, Quantity]:
    return {q.name: q for q in _core.quantities()}


def parameters() -> list[Parameter]:
    """List all parameters of the closed forms.

    Returns
    -------
    list of Parameter
        Records with ``name``, ``symbol``, ``unit``, ``default``, ``range``,
        ``integer``, ``file_key`` and ``meaning``.

    Examples
    --------
    >>> import locosweep as ls
    >>> [p.name for p in ls.parameters() if p.unit == "kg"]
    ['mass']
    """
    return list(_parameters().values())


def quantities() -> list[Quantity]:
    """List all quantities that a sweep can compute.

    Returns
    -------
    list of Quantity
        Records with ``name``, ``symbol``, ``unit``, ``formula`` (TeX), ``source``,
        ``limits``, ``meaning``, ``integer``, ``larger_is_better`` and ``parameters``.

    Examples
    --------
    >>> import locosweep as ls
    >>> best = next(q for q in ls.quantities() if q.name == "optimal_segments")
    >>> best.source.split(";")[0]
    'paper, equations (7) and (8): the zero of d(mean velocity)/dN'
    """
    return list(_quantities().values())


def reductions() -> dict[str, str]:
    """Map the name of every reduction to its meaning.

    Examples
    --------
    >>> import locosweep as ls
    >>> "argmax" in ls.reductions()
    True
    """
    return dict(_core.reductions())


@cache
def _laws() -> dict[str, Law]:
    return {law.name: law for law in _core.laws()}


@cache
def _drives() -> dict[str, Drive]:
    return {drive.name: drive for drive in _core.drives()}


def laws() -> list[Law]:
    """List all friction laws.

    Returns
    -------
    list of Law
        Records with ``name``, ``kind`` (dry, smooth or bristle), ``formula``
        (TeX), ``source``, ``limits``, ``meaning``, ``parameters`` and ``exact``.

    Examples
    --------
    >>> import locosweep as ls
    >>> [law.name for law in ls.laws() if law.exact][:2]
    ['coulomb', 'coulomb_viscous']
    """
    return list(_laws().values())


def drives() -> list[Drive]:
    """List all drives: commanded forces of the actuator over time.

    Examples
    --------
    >>> import locosweep as ls
    >>> [p.name for p in ls.drives()[0].parameters]
    ['drive_force']
    """
    return list(_drives().values())


def effects() -> list[Effect]:
    """List the effects that a nominal model of a measured run may lack.

    Examples
    --------
    >>> from locosweep.registry import effects
    >>> [e.name for e in effects() if e.site == "body"]
    ['payload_mass', 'anchor_slip']
    """
    return _core.effects()


def gaits() -> list[Gait]:
    """List the gaits that a whole robot can be simulated with.

    Examples
    --------
    >>> from locosweep.registry import gaits
    >>> gaits()[0].name
    'single'
    """
    return _core.gaits()


def methods() -> dict[str, str]:
    """Map the name of every method of simulation to its meaning.

    Examples
    --------
    >>> import locosweep as ls
    >>> "exact" in ls.methods()
    True
    """
    return dict(_core.methods())


def law(name: str) -> Law:
    """Return one friction law by name; InputError with the nearest name if unknown."""
    return _one("law", name, _laws())


def drive(name: str) -> Drive:
    """Return one drive by name; InputError with the nearest name if unknown."""
    return _one("drive", name, _drives())


def parameter(name: str) -> Parameter:
    """Return one parameter by name; InputError with the nearest name if unknown."""
    return _one("parameter", name, _parameters())


def quantity(name: str) -> Quantity:
    """Return one quantity by name; InputError with the nearest name if unknown."""
    return _one("quantity", name, _quantities())


def _one(kind: str, name: str, known: dict[str, _Record]) -> _Record:
    if name not in known:
        raise unknown(kind, name, known)
    return known[name]


def words_of_name(name: str) -> str:
    """Return a name of the registry as words.

    Examples
    --------
    >>> from locosweep.registry import words_of_name
    >>> words_of_name("slope_deg"), words_of_name("mean_velocity")
    ('slope', 'mean velocity')
    """
    return name.removesuffix("_deg").replace("_", " ")


def unknown(kind: str, given: str, known: Iterable[str]) -> InputError:
    """Build the error for an unknown name, with the nearest known ones; few are named all."""
    names = list(known)
    if not names:
        return InputError(f"unknown {kind} '{given}': there is none")
    near = _core.nearest(given, names)
    hint = f"did you mean '{near}'? Known are " if near else "known are "
    if len(names) <= _MOST_NAMED:
        return InputError(f"unknown {kind} '{given}': {hint}{', '.join(names)}")
    close = get_close_matches(given, names, _CLOSE, cutoff=0.4)
    some = [*filter(None, [near]), *(name for name in close if name != near)][:_CLOSE]
    lists = f"locosweep {_LISTS[kind]} lists all {len(names)}" if kind in _LISTS else ""
    if near:
        others = f" ({', '.join(some[1:])})" if some[1:] else ""
        said = f"did you mean '{near}'{others}? {lists}"
    elif some:
        said = f"the nearest are {', '.join(some)}; {lists}"
    else:
        said = f"known are, of {len(names)}, {', '.join(names[:_CLOSE])}; {lists}"
    return InputError(f"unknown {kind} '{given}': {said}".rstrip(" ;"))


class Status(IntEnum):
    """Reason for which a point has no value; 0 is ok, and only then the value is a number."""

    OK = 0
    SLIDES_BACK = 1
    SLIDES_DOWN = 2
    NOTHING_ANCHORED = 3
    NO_ROOM_AHEAD = 4
    ANCHORS_TOO_WEAK = 5
    DRIVE_TOO_WEAK = 6
    NO_OPTIMUM = 7
    UNBOUNDED = 8
    SET_VALUED = 9
    NONE_FEASIBLE = 10
    CANNOT_BRAKE = 11
    EMPTY_RANGE = 12
    NOT_FINITE = 13
    NOT_REACHED = 14
    UNRESOLVED = 15
    DIVERGED = 16
    TOO_MANY_SEGMENTS = 17
    NO_PHASE_TIME = 18
    TOO_MANY_STEPS = 19
    MIXED_JOINTS = 20
    NO_CLOSED_FORM = 21
    ENERGY_OPEN = 22
    SUPPLY_TOO_WEAK = 23
    ELASTIC_JOINTS_ONLY = 24

    @property
    def sentence(self) -> str:
        """One sentence for people."""
        return _sentences()[int(self)]


@cache
def _sentences() -> dict[int, str]:
    return {code: sentence for code, _, sentence in _core.statuses()}
