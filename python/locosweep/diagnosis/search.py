"""The search for the effects that a gap needs: singles, pairs, triples."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.fit import Fit, Model, Nuisances, evaluate, fit_all, start_fits
from locosweep.diagnosis.starts import parameters_of, starts_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.problem import Problem
    from locosweep.diagnosis.starts import Scale

__all__ = ["Search"]

_STARTS = 3
"""Starts of a model that are followed."""
_PARTNERS = 8
"""Further effects that are fitted beside those found, after the scan of all."""
_BEAM = 4
_NOMINAL = 9
"""Starts of the nominal model that are followed."""
_CLOSE = 8
"""Fits that are followed to their end whatever the best one reaches."""
PENALTY = 8.0
"""What a free parameter has to gain in chi2 before it counts."""


@dataclass
class Search:
    """Fits of sets of effects to one problem; remembers what it has fitted."""

    problem: Problem
    nuisances: Nuisances
    scale: Scale
    names: tuple[str, ...]
    report: Callable[[str], None]
    judges: bool = True
    """Whether the runs that fits do not see take part in the choice."""

    def __post_init__(self) -> None:
        self.unseen: dict[int, tuple[Fit, float]] = {}
        self.fits: dict[frozenset[str], Fit] = {}
        self.none = _nominal(self.problem, self.nuisances)
        self.fits[frozenset()] = self.none

    def model(self, names: Iterable[str]) -> Model:
        names = tuple(names)
        free = tuple(f for name in names for f in parameters_of(name, self.scale))
        return Model(names, free)

    def score(self, fit: Fit) -> float:
        """Chi2 with a price on every parameter that the data can see."""
        return fit.chi2 + PENALTY * self.seen(fit)

    def seen(self, fit: Fit) -> int:
        """Parameters that a large change would show."""
        return len(fit.model.free)

    def singles(self) -> list[Fit]:
        """Fit every effect alone, from several starts; best first."""
        return self.extend(None, self.names, keep=len(self.names))

    def extend(self, base: Fit | None, partners: Sequence[str], keep: int = _PARTNERS) -> list[Fit]:
        """Fit `base` with each of `partners` beside it; only the `keep` best after a scan."""
        held = base.model.names if base else ()
        partners = [p for p in partners if p not in held]
        fits: list[Fit] = []
        for name in partners:
            rows = starts_of(name, self.scale)
            if base is not None:
                rows = np.hstack([np.tile(base.parameters, (len(rows), 1)), rows])
            fits.extend(start_fits(self.problem, self.nuisances, self.model((*held, name)), rows))
            known = base or self.none
            nuisance = known.theta[len(known.model.free) :]
            if base is None and self.nuisances.shares:
                # The nominal model's shares may be bent to hide the gap.
                fits.extend(start_fits(self.problem, self.nuisances, fits[-1].model, rows))
            for fit in fits[-len(rows) :]:
                fit.theta[fit.theta.size - nuisance.size :] = nuisance
        self._scan(fits)
        groups = [sorted([f for f in fits if f.model.names[-1] == n], key=_chi2) for n in partners]
        groups = sorted((g for g in groups if g), key=lambda g: g[0].chi2)[:keep]
        starts = [fit for group in groups for fit in _apart(group, _STARTS if base is None else 2)]
        evaluate(self.problem, starts)
        fit_all(self.problem, starts, steps=3)
        best = []
        for group in groups:
            mine = sorted([f for f in starts if f.model is group[0].model], key=_chi2)
            best.extend(f for f in mine if f.chi2 < 1.3 * mine[0].chi2 + 20.0)
        least = min((f.chi2 for f in best), default=np.inf)
        order = sorted(best, key=_chi2)
        # Those that are far behind stay as they are.
        close = [f for i, f in enumerate(order) if i < _CLOSE or f.chi2 < 10.0 * least]
        for fit in close:
            fit.done = False
        fit_all(self.problem, close, steps=30 if self.nuisances.shares else 15)
        found = {}
        for fit in best:
            key = frozenset(fit.model.names)
            if key not in found or fit.chi2 < found[key].chi2:
                found[key] = fit
            if key not in self.fits or fit.chi2 < self.fits[key].chi2:
                self.fits[key] = fit
        return sorted((self.fits[key] for key in found), key=_chi2)

    def _scan(self, fits: list[Fit]) -> None:
        """Chi2 of many starts, without keeping their residuals."""
        for i in range(0, len(fits), 200):
            evaluate(self.problem, fits[i : i + 200])
            for fit in fits[i : i + 200]:
                fit.residual = np.zeros(0)

    def deepen(self, fits: Sequence[Fit], beam: int = _BEAM) -> list[Fit]:
        """Add one effect to each of the best fits."""
        found: dict[frozenset[str], Fit] = {}
        for base in list(fits)[:beam]:
            for fit in self.extend(base, self.names):
                found[frozenset(fit.model.names)] = fit
        return sorted(found.values(), key=_chi2)


def _nominal(problem: Problem, nuisances: Nuisances) -> Fit:
    """Fit the nominal model: its uncertain values from several starts."""
    shares = nuisances.shares
    spread = np.array([nuisances.spread[i] for i in shares])
    corners = np.array(list(product((0.0, -1.2, 1.2), repeat=len(shares))))
    fits = start_fits(problem, nuisances, Model((), ()), np.zeros((len(corners), 0)))
    for fit, corner in zip(fits, corners, strict=True):
        fit.theta[: len(shares)] = corner * spread
    evaluate(problem, fits)
    fits = sorted(fits, key=_chi2)[:_NOMINAL]
    fit_all(problem, fits, steps=8)
    fits = sorted(fits, key=_chi2)[:2]
    for fit in fits:
        fit.done = False
    fit_all(problem, fits, steps=40)
    return min(fits, key=_chi2)


def _chi2(fit: Fit) -> float:
    return fit.chi2


def _apart(fits: Sequence[Fit], count: int) -> list[Fit]:
    """The best fits whose parameters differ from each other's."""
    chosen: list[Fit] = []
    for fit in fits:
        sizes = np.array([0.3 if f.log else 0.003 * f.size for f in fit.model.free])
        k = sizes.size
        if all(np.any(np.abs(fit.theta[:k] - c.theta[:k]) > sizes) for c in chosen):
            chosen.append(fit)
        if len(chosen) == count:
            break
    return chosen
