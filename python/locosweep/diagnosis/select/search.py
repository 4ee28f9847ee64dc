"""Searches for the effects that a gap needs: what a search knows, and what it has come to."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import parameters_of
from locosweep.diagnosis.estimate.least_squares import FINE, Fit, Model, Nuisances, point_of
from locosweep.diagnosis.estimate.nominal import fit_nominal
from locosweep.diagnosis.estimate.validation import validation_residuals
from locosweep.diagnosis.select.thresholds import PENALTY
from locosweep.diagnosis.select.whiteness import whiteness_test

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from numpy.typing import NDArray

    from locosweep.diagnosis.effects.scale import Scale
    from locosweep.diagnosis.estimate.equation_error import EquationError
    from locosweep.diagnosis.estimate.problem import Problem

Found = dict[frozenset[str], Fit]
"""The best fit of each set of effects, in the order in which they were found."""


@dataclass(frozen=True, eq=False)
class Search:
    """Data and settings of a search for effects; its steps return the fits that they add."""

    problem: Problem
    nuisances: Nuisances
    scale: Scale
    names: tuple[str, ...]
    """Candidate effects."""
    progress: Callable[[str], None] = lambda _: None
    """Called with the step that begins."""
    judges: bool = True
    """True if validation data take part in the choice."""
    along: EquationError | None = None
    """Equation error of the runs, where the measured motion has slides."""
    hints: Mapping[frozenset[str], Fit] = field(default_factory=dict)
    """Fits of the same sets to other runs: further starts."""
    tolerance: float = FINE
    """Fall of chi2 by a step that ends a fit."""
    _unseen: dict[Fit, float] = field(default_factory=dict, init=False, repr=False)
    """Memo of `unseen_chi2`: a fit does not change, and its replay is not free."""

    @cached_property
    def none(self) -> Fit:
        """The nominal model, its uncertain values fitted."""
        return fit_nominal(self.problem, self.nuisances, self.hints.get(frozenset()))

    @property
    def steps(self) -> int:
        """Steps of a fit, at most."""
        return 20 if self.nuisances.uncertain else 15

    def model(self, names: Iterable[str]) -> Model:
        """Return a set of effects with its free parameters."""
        names = tuple(names)
        free = tuple(f for name in names for f in parameters_of(name, self.scale, names))
        return Model(names, free)

    def score(self, fit: Fit) -> float:
        """Chi2 with a price on every free parameter."""
        return fit.chi2 + PENALTY * len(fit.model.free)

    def unseen_chi2(self, fit: Fit) -> float:
        """Chi2 of what fits have not seen; 0 where that does not judge."""
        if not self.judges:
            return 0.0
        if fit not in self._unseen:
            e = validation_residuals(self.problem, [point_of(self.problem, fit)])[0]
            self._unseen[fit] = float(e @ e)
        return self._unseen[fit]

    def is_noise(self, fit: Fit) -> bool:
        """Return whether a fit leaves nothing that noise would not."""
        return not whiteness_test(self.problem, fit.residual).rejected

    def hinted(self, model: Model) -> list[NDArray[np.float64]]:
        """Return the parameters of a set as other runs have them, if any."""
        hint = self.hints.get(frozenset(model.names))
        if hint is None:
            return []
        values = hint.named()
        return [np.array([values[f.effect][f.name] for f in model.free])]


@dataclass(frozen=True, eq=False)
class Collection:
    """The best fit of each set of effects that a search has come to."""

    fits: Mapping[frozenset[str], Fit]
    extended: frozenset[frozenset[str]] = frozenset()
    """Sets that every effect was tried beside."""
    law: float = np.inf
    """Score of another law of one effect that leaves but noise: what several effects compete with.
    Infinite where there is none."""

    def having_extended(self, names: frozenset[str]) -> Collection:
        """Return a collection that knows of a set what does best beside it."""
        return replace(self, extended=self.extended | {names})

    def of_size(self, count: int) -> list[Fit]:
        """Return the fits of all sets of so many effects."""
        return [fit for names, fit in self.fits.items() if len(names) == count]

    def adding(self, found: Mapping[frozenset[str], Fit]) -> Collection:
        """Return a collection in which the fits of a step replace those known before."""
        return replace(self, fits={**self.fits, **found})

    def single(self, name: str) -> Fit | None:
        """Return the fit of one effect alone, if there is one."""
        return self.fits.get(frozenset({name}))
