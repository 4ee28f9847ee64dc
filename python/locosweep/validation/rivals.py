"""Candidate laws of every cause as copies of another cause."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import TYPE_CHECKING

from locosweep.diagnosis.effects.catalogue import parameters_at
from locosweep.diagnosis.effects.formula import numbers
from locosweep.simulation.replay import effect, effects

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from locosweep import _core
    from locosweep.validation.experiment import Effect
    from locosweep.validation.laws import Scale


@dataclass(frozen=True)
class Rival:
    """A direction in which a rival can go: its effect at a signed strength."""

    cause: str
    form: str
    group: str
    """Rivals of one group are fitted together."""
    at: Callable[[float], dict[str, float]]
    one_sided: bool
    refined: float | None = None
    """The number that is looked at between its values, too: the length of a ripple."""

    def effect(self, s: float) -> Effect:
        """Return what the reality takes."""
        return self.cause, self.form, self.at(s)

    def allows(self, s: float) -> bool:
        """Return whether a strength makes sense: sensors and drives act late, not early."""
        return s >= 0.0 or not self.one_sided


def rivals_of(k: Scale, *, as_force: bool) -> list[Rival]:
    """List laws of all causes over a grid of the numbers beside their strength.

    `as_force`: the nominal model gives its Coulomb level as a force.
    """
    found = []
    for record in effects():
        if not record.drawn or ("body" in record.needs and k.grip <= 0.0):
            continue
        names = [name for name, _ in record.over]
        grids = [numbers(formula, vars(k)).tolist() for _, formula in record.over]
        for values in product(*grids):
            tried = dict(zip(names, values, strict=True))
            found += _spanned(record, k, tried, as_force=as_force)
    return found


def rivals_between(rival: Rival, factor: float, k: Scale) -> list[Rival]:
    """Return the rivals on either side of one, its refined number a factor smaller and larger."""
    record = effect(rival.cause)
    if record.refined is None or rival.refined is None:
        return []
    tried = [{record.refined: rival.refined / factor}, {record.refined: rival.refined * factor}]
    return [r for values in tried for r in _spanned(record, k, values, as_force=False)]


def refined_step(cause: str) -> float:
    """Return the factor between neighbours in the grid of a refined number."""
    record = effect(cause)
    formula = dict(record.over)[str(record.refined)]
    # A factor does not depend on the rig: on one whose sizes are all 1 it is free of rounding.
    first, second = numbers(formula, _Ones())[:2].tolist()
    return float(second / first)


class _Ones(dict[str, float]):
    def __missing__(self, name: str) -> float:
        return 1.0


def _spanned(
    record: _core.Effect, k: Scale, tried: Mapping[str, float], *, as_force: bool
) -> list[Rival]:
    """Return the rivals of one group."""
    other = "mu_coulomb" if as_force else "coulomb_force"
    own = [fit for fit in record.fits if fit.only_with != other]
    # The reality has a form of its own for a level that is given as a force.
    form = "force" if any(fit.only_with == "coulomb_force" for fit in own) else "law"
    formulas = {fit.name: fit.rival for fit in own}
    group = " ".join([record.name, *(f"{value:.9g}" for value in tried.values())])
    names = [name for name, _ in record.spanned]
    grids = [numbers(formula, vars(k)).tolist() for _, formula in record.spanned]

    def at(s: float, given: Mapping[str, float]) -> dict[str, float]:
        return parameters_at(formulas, vars(k), {**given, "s": s})

    return [
        Rival(
            record.name,
            form,
            group,
            partial(at, given={**tried, **dict(zip(names, values, strict=True))}),
            record.one_sided,
            tried.get(record.refined) if record.refined else None,
        )
        for values in product(*grids)
    ]
