"""The effects of the registry on a rig: those that have a meaning, starts, ranges, magnitudes.

Everything that is particular to an effect stands in its row of the core's registry
(`rust/core/physics/effects/rows.rs`); nothing here knows one by name.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.effects.formula import number, numbers
from locosweep.simulation.replay import effect, effects, nominal_of

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping

    from numpy.typing import NDArray

    from locosweep._core import Effect, EffectFit
    from locosweep.diagnosis.effects.scale import Scale
    from locosweep.files.robot import Robot

    Floats = NDArray[np.float64]
    Values = dict[str, float]

VARIABLES = {record.name: record.variable for record in effects() if record.variable}
"""The variable that an effect acts through, where another law of it is possible."""
FURTHER = {record.name: record.further for record in effects() if record.further}
"""A second variable of an effect, which no other one acts through."""

_WHY = {
    "body": "a bench has no anchored body",
    "rear_sensor": "the body's motion is not measured (x_rear)",
    "slope": "a rotary bench has no slope",
}
"""Why an effect has no meaning where a rig lacks what it needs."""


def own_variables(names: Iterable[str]) -> list[str]:
    """Return the variables that other laws of some effects would follow."""
    found = [of[name] for name in names for of in (VARIABLES, FURTHER) if name in of]
    return list(dict.fromkeys(found))


@dataclass(frozen=True)
class Free:
    """A free parameter: how it is stepped and where it may go."""

    effect: str
    name: str
    unit: str
    log: bool
    size: float
    """A large change, in the parameter's unit (of its logarithm if `log`)."""
    low: float
    high: float
    off: float
    """Value without the effect; NaN where none does it."""


def lacking(needs: Mapping[str, bool]) -> dict[str, str]:
    """Return the effects that have no meaning where a rig lacks what they need, and why.

    `needs` says whether the rig has an anchored body (`body`), a sensor of its position
    (`rear_sensor`) and ground that can slope (`slope`); a rig has what it does not name.
    """
    out: dict[str, str] = {}
    for need, why in _WHY.items():
        if not needs.get(need, True):
            for record in effects():
                if need in record.needs:
                    out.setdefault(record.name, why)
    return out


def candidates(robot: Robot, channels: Collection[str]) -> tuple[list[str], dict[str, str]]:
    """List the effects that have a meaning on a rig, and why the others have none."""
    nominal = nominal_of(robot)
    out = lacking({
        "body": robot.other.get("bench.kind") is None and nominal["segments"] > 1.0,
        "rear_sensor": "x_rear" in channels,
        "slope": "gravity_torque" not in nominal,
    })  # fmt: skip
    return [record.name for record in effects() if record.name not in out], out


def goes_with(name: str, others: Collection[str]) -> bool:
    """Return whether a model may have an effect beside others: none of them stands in its place."""
    return name not in others and not any(other in others for other in effect(name).excludes)


def _used(record: Effect, *, has_force_level: bool) -> list[EffectFit]:
    """Return how fits treat the parameters that go with the rig's form of Coulomb level."""
    other = "mu_coulomb" if has_force_level else "coulomb_force"
    return [fit for fit in record.fits if fit.only_with != other]


def parameters_of(name: str, scale: Scale, beside: Collection[str] = ()) -> list[Free]:
    """Return the free parameters of an effect with others beside it, on a rig of this scale."""
    record = effect(name)
    units = {p.name: p.unit for p in record.parameters}
    if any(effect(other).lowers_level for other in beside):
        scale = replace(scale, least_level=0.0)
    # Drives and sensors act late. One that is early tells of a clock that is off, which no other
    # one makes up for.
    early = [one for one in {name, *beside} if _may_be_early(one, scale)]
    late = name in early and len(early) > 1
    found = []
    for fit in _used(record, has_force_level=scale.has_force_level):
        off = scale.level if fit.beside_level else np.nan if fit.off is None else fit.off
        size = number(fit.unit, vars(scale))
        low, high = _range(fit, scale)
        low = max(low, 0.0) if late else low
        found.append(Free(name, fit.name, units[fit.name], fit.log, size, low, high, off))
    return found


def _may_be_early(name: str, scale: Scale) -> bool:
    """Return whether an effect that acts late, as drives and sensors do, may be fitted as early."""
    record = effect(name)
    return record.one_sided and any(_range(fit, scale)[0] < 0.0 for fit in record.fits)


def _range(fit: EffectFit, scale: Scale) -> tuple[float, float]:
    low, high = fit.windows if scale.replayed < scale.duration else fit.range
    return number(low, vars(scale)), number(high, vars(scale))


def starts_of(name: str, scale: Scale) -> Floats:
    """Return the start values of an effect's parameters, a row a start."""
    record = effect(name)
    used = _used(record, has_force_level=scale.has_force_level)
    grids = []
    for fit in used:
        values = numbers(fit.starts, vars(scale))
        grids.append(np.unique(values if fit.log else values * number(fit.unit, vars(scale))))
    rows = np.array(list(product(*grids)))
    columns: dict[str, Any] = {fit.name: rows[:, i] for i, fit in enumerate(used)}
    for i, fit in enumerate(used):
        if fit.composed:
            rows[:, i] = numbers(fit.composed, {**vars(scale), **columns, "value": rows[:, i]})
    if record.keep:
        rows = rows[numbers(record.keep, {**vars(scale), **columns})]
    lows, highs = zip(*(_range(fit, scale) for fit in used), strict=True)
    return np.unique(np.clip(rows, lows, highs), axis=0)


class _Given(dict[str, Any]):
    """Numbers by name, where a parameter that another one follows from is worked out."""

    def __init__(self, formulas: Mapping[str, str], *known: Mapping[str, Any]) -> None:
        super().__init__()
        for part in known:
            self.update(part)
        self.formulas = formulas

    def __missing__(self, name: str) -> float:
        return number(self.formulas[name], self)


def parameters_at(
    formulas: Mapping[str, str], sizes: Mapping[str, Any], given: Mapping[str, float]
) -> Values:
    """Return the parameters of an effect that formulas give, in their order.

    Formulas know the `sizes` of the rig, the `given` numbers, which count where both have a
    name, and the other parameters.
    """
    known = _Given(formulas, sizes, given)
    return {name: number(formula, known) for name, formula in formulas.items()}


@dataclass(frozen=True)
class Shape:
    """A further parameter of a family: where fits begin, and its bounds.

    With `log` the fit steps its logarithm; `step` is that of a finite difference.
    """

    name: str
    starts: tuple[float, ...]
    low: float
    high: float
    log: bool = True
    step: float = 0.02

    def coordinate(self, value: float) -> float:
        """Return what the fit steps."""
        return float(np.log(value)) if self.log else value

    def value(self, coordinate: float) -> float:
        """Return the parameter, within its bounds."""
        if not self.log:
            return float(np.clip(coordinate, self.low, self.high))
        return float(np.exp(np.clip(coordinate, np.log(self.low), np.log(self.high))))


@dataclass(frozen=True)
class Family:
    """One effect: parameters from a signed magnitude and shapes.

    A magnitude of 0 is the nominal model, one about 1 as large as the rig allows.
    `low` is 0 where the effect has one sign only; below `least` an integrator
    resolves no more than the nominal model.
    """

    name: str
    make: Callable[[float, Mapping[str, float]], Values]
    low: float
    high: float
    shapes: tuple[Shape, ...] = ()
    least: float = 1e-9

    @property
    def signs(self) -> tuple[float, ...]:
        """Signs that the magnitude may have."""
        return (1.0, -1.0) if self.low < 0.0 else (1.0,)

    def starts(self) -> list[tuple[float, ...]]:
        """Return every combination of the shapes' first values."""
        return list(product(*(shape.starts for shape in self.shapes)))

    def parameters(self, theta: Floats) -> Values:
        """Return the effect's parameters at the coordinates of a fit, magnitude first."""
        shapes = {s.name: s.value(c) for s, c in zip(self.shapes, theta[1:], strict=True)}
        return self.make(float(np.clip(theta[0], self.low, self.high)), shapes)


def _family(record: Effect, scale: Scale) -> Family:
    sizes = vars(scale)
    formulas = {fit.name: fit.at for fit in _used(record, has_force_level=scale.has_force_level)}
    shapes = tuple(
        Shape(s.name, tuple(numbers(s.starts, sizes).tolist()), number(s.range[0], sizes),
              number(s.range[1], sizes), s.log, s.step)
        for s in record.shapes
    )  # fmt: skip

    def make(u: float, shapes: Mapping[str, float]) -> Values:
        return parameters_at(formulas, sizes, {**shapes, "u": u})

    low, high = (number(end, sizes) for end in record.magnitude)
    return Family(record.name, make, low, high, shapes, record.least)


def families(scale: Scale) -> dict[str, Family]:
    """Return the families of all effects, by name, at a rig's sizes."""
    return {record.name: _family(record, scale) for record in effects()}
