"""Screening of starts: what the equation error promises, and what replays say of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import goes_with, starts_of
from locosweep.diagnosis.estimate.equation_fits import evaluated, refined, uncertainties
from locosweep.diagnosis.estimate.least_squares import Fit, evaluate, jacobian_of, start_fits
from locosweep.diagnosis.select.effort import (
    INFORMATIVE_RUNS,
    PARTNERS,
    STARTS,
    STRONGEST_SCALING,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.equation_error import EquationError
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.search import Search

    Floats = NDArray[np.float64]

_AT_ONCE = 200
"""Starts that are evaluated side by side; their residuals are kept meanwhile."""
_OF_MANY = 4
"""Of so many runs or windows, one is looked at. Two of all windows showed a sensor scale of 0.55 as
-0.3, which a quarter of them do not: case `sensor_scale_30` of `locosweep blind-check --rig
runs.csv --nominal nominal.toml --calibrate --runs 5,6,7 --seed 0` on the pendulum."""
_WEAK = 1.0 / STRONGEST_SCALING
"""Factor on a start below which it is evaluated again as weak as that."""


@dataclass(frozen=True, eq=False)
class Screened:
    """A start, evaluated on some runs; without its residual."""

    fit: Fit
    promised: float
    """Chi2 that it may come to if its change of the residuals is scaled, all else refitted."""
    factor: float = 1.0
    """By how much it would be scaled."""


def rows_beside(search: Search, name: str, beside: Fit) -> list[Fit]:
    """Return all starts of an effect beside the values of a fit."""
    rows = starts_of(name, search.scale)
    rows = np.hstack([np.tile(beside.parameters, (len(rows), 1)), rows])
    model = search.model((*beside.model.names, name))
    return start_fits(search.nuisances, model, rows, beside.nuisance)


def seen_along(search: Search, beside: Fit, partners: Sequence[str]) -> dict[str, list[Fit]]:
    """Return starts of further effects that leave the least equation error, by effect.

    Effects that the equation error does not see are left out.
    """
    along = search.along
    if along is None:
        return {}
    starts = {name: rows_beside(search, name, beside) for name in partners}
    flat = [fit for fits in starts.values() for fit in fits]
    residual, changes = _changes_along(along, beside, flat)
    size, factor, fall = _scalings(changes, residual)
    # What they leave as they stand, less what is left without them.
    left = size - 2.0 * (changes @ residual)
    # What acts at rest changes nothing but roundings.
    least = 1e-12 * max(float(size.max(initial=0.0)), 1.0)
    chosen: list[Fit] = []
    at = 0
    for fits in starts.values():
        own = range(at, at + len(fits))
        at += len(fits)
        seen = [i for i in own if size[i] > least]
        best = sorted(seen, key=lambda i: -fall[i])[:STARTS]
        chosen += [scaled(flat[i], factor[i]) for i in best]
        # And as they stand: not every effect grows in proportion to a parameter.
        chosen += [flat[i] for i in sorted(seen, key=lambda i: left[i])[:STARTS]]
    found: dict[str, list[Fit]] = {}
    for fit in refined(along, chosen):
        found.setdefault(fit.model.names[-1], []).append(fit)
    return {name: sorted(fits, key=lambda fit: fit.chi2) for name, fits in found.items()}


def mean_square(search: Search, beside: Fit) -> float:
    """Return the mean square of the equation error beside a fit, in that of noise.

    However far free runs come apart, it may be little more than noise: it then says little about
    where to start.
    """
    if search.along is None:
        return 0.0
    (fit,) = evaluated(search.along, [beside])
    return fit.chi2 / search.along.measured.size


def pairs_along(search: Search, count: int, beside: Fit | None = None) -> list[Fit]:
    """Return starts of the pairs of effects that leave the least equation error, best first.

    They stand beside a fit of the nominal model, that of the search if none is given.
    """
    along = search.along
    if along is None:
        return []
    none = beside or search.none
    alone = [fit for name in search.names for fit in rows_beside(search, name, none)]
    residual, changes = _changes_along(along, none, alone)
    starts = _starts_of_pairs(search, alone, -residual, changes, none)
    return sorted(refined(along, starts), key=lambda fit: fit.chi2)[:count]


def pairs_beside(search: Search, known: Iterable[Fit], runs: Sequence[int]) -> list[Fit]:
    """Return starts of the pairs of effects whose replayed changes cancel most of the gap.

    Changes of a small gap add up: they tell pairs apart that the equation error, mostly noise
    then, does not. They are those of all starts of each effect, and of the fits `known` of effects
    alone, on some runs. Best first, as replays of these runs say.
    """
    problem, none = search.problem, search.none
    alone = [fit for name in search.names for fit in rows_beside(search, name, none)]
    alone += [fit.unfitted() for fit in known]
    here, free = _free_changes(problem, none, runs)
    changes = _changes(problem, alone, runs, here, free)
    _, factors, _ = _scalings(changes, -here.residual)
    # What is far too strong says little of a weaker one.
    weak = np.flatnonzero(np.abs(factors) < _WEAK)
    for i in weak:
        alone[i] = scaled(alone[i], float(factors[i]))
    changes[weak] = _changes(problem, [alone[i] for i in weak], runs, here, free)
    starts = _starts_of_pairs(search, alone, here.residual, changes, none)
    return sorted(evaluate(problem, starts, runs), key=lambda fit: fit.chi2)


def _starts_of_pairs(
    search: Search, alone: Sequence[Fit], residual: Floats, changes: Floats, beside: Fit
) -> list[Fit]:
    """Return starts of the pairs of effects whose changes cancel most of a residual."""
    starts = []
    for i, j, sizes in cancelling_pairs(alone, changes, residual, 3 * PARTNERS):
        model = search.model((alone[i].model.names[0], alone[j].model.names[0]))
        parts = [scaled(alone[k], by).parameters for k, by in zip((i, j), sizes, strict=True)]
        row = np.concatenate(parts)[None]
        starts += start_fits(search.nuisances, model, row, beside.nuisance)
    return starts


def _changes_along(
    along: EquationError, beside: Fit, starts: Sequence[Fit]
) -> tuple[Floats, Floats]:
    """Return the equation error of a fit, and what starts change of it, a row a start.

    Both are what remains when the fit's own entries are refitted.
    """
    here, *there = along.displacements([beside, *starts])
    basis = np.linalg.qr(along.jacobian(beside).T)[0]
    rows = np.nan_to_num(np.vstack([along.measured - here, np.array(there) - here]))
    rows -= (rows @ basis) @ basis.T
    return rows[0], rows[1:]


def _scalings(changes: Floats, residual: Floats) -> tuple[Floats, Floats, Floats]:
    """Return squares of changes, factors by which they take most of a residual, and its fall."""
    size = np.einsum("ij,ij->i", changes, changes)
    along = changes @ residual
    factor = np.where(size > 0.0, along / np.where(size > 0.0, size, 1.0), 0.0)
    factor = np.clip(factor, -STRONGEST_SCALING, STRONGEST_SCALING)
    return size, factor, factor * (2.0 * along - factor * size)


def informative_runs(problem: Problem, fit: Fit) -> list[int]:
    """Return the fitted runs that hold most of what an evaluated fit leaves, a sample.

    Of many, as where long runs are cut into windows, one in `_OF_MANY`.
    """
    chosen = problem.fitted
    own = [fit.residual[problem.of_run(r, chosen)] for r in chosen]
    left = [float(part @ part) / max(int(np.count_nonzero(part)), 1) for part in own]
    order = np.argsort(-np.array(left), kind="stable")
    count = max(INFORMATIVE_RUNS, len(chosen) // _OF_MANY)
    return sorted(chosen[i] for i in order[:count])


def scan_beside(
    problem: Problem, fits: Sequence[Fit], runs: Sequence[int], beside: Fit
) -> tuple[list[Screened], float]:
    """Evaluate many starts on some runs, and what each promises beside a fit.

    A start extends the model of `beside`: the change that it makes is added to that fit's
    residual. One that is far too strong says little of a weaker one, which is evaluated, too.
    Returns those of `fits` in their order and then the weaker ones, and chi2 of `beside` on these
    runs.
    """
    known, free = _free_changes(problem, beside, runs)

    def screened(fits: Sequence[Fit]) -> Iterator[Screened]:
        for some, changes in _changed(problem, fits, runs, known, free):
            size, factor, fall = _scalings(changes, -known.residual)
            sure = np.isfinite(fall) & (size > 0.0)
            chi2 = np.array([fit.chi2 for fit in some])
            promised = np.where(sure, np.minimum(chi2, known.chi2 - fall), chi2).tolist()
            factors = np.where(sure, factor, 1.0).tolist()
            yield from map(Screened, (fit.without_residual() for fit in some), promised, factors)

    found = list(screened(fits))
    pairs = [(s.fit, scaled(s.fit, s.factor)) for s in found if abs(s.factor) < _WEAK]
    weaker = [now for before, now in pairs if (now.theta != before.theta).any()]
    return [*found, *screened(weaker)], known.chi2


def _free_changes(problem: Problem, beside: Fit, runs: Sequence[int]) -> tuple[Fit, Floats]:
    """Return a fit on some runs, and a basis of the changes that its own entries can make."""
    (known,) = evaluate(problem, [beside.unfitted()], runs)
    return known, np.linalg.qr(np.nan_to_num(jacobian_of(problem, known, runs)).T)[0]


def _changed(
    problem: Problem, fits: Sequence[Fit], runs: Sequence[int], known: Fit, free: Floats
) -> Iterator[tuple[list[Fit], Floats]]:
    """Evaluate starts on some runs, a few at a time, and what they change beyond what is free.

    Changes have a row a start.
    """
    for i in range(0, len(fits), _AT_ONCE):
        some = evaluate(problem, fits[i : i + _AT_ONCE], runs)
        changes = np.array([fit.residual for fit in some])
        changes -= known.residual
        changes -= (changes @ free) @ free.T
        yield some, changes


def _changes(
    problem: Problem, fits: Sequence[Fit], runs: Sequence[int], known: Fit, free: Floats
) -> Floats:
    """Return what starts change on some runs beyond what is free; 0 where that is no number."""
    parts = [changes for _, changes in _changed(problem, fits, runs, known, free)]
    changes = np.vstack(parts or [np.zeros((0, known.residual.size))])
    changes[~np.isfinite(changes).all(axis=1)] = 0.0
    return changes


def scaled(fit: Fit, scale: float) -> Fit:
    """Return a start whose last effect is stronger by a factor, where it has a strength."""
    theta = fit.theta.copy()
    for i, free in enumerate(fit.model.free):
        if free.effect != fit.model.names[-1] or np.isnan(free.off) or scale == 0.0:
            continue
        if not free.log:
            moved = free.off + scale * (theta[i] - free.off)
            theta[i] = np.clip(moved, free.low, free.high)
        elif scale > 0.0:
            theta[i] = np.clip(theta[i] + np.log(scale), np.log(free.low), np.log(free.high))
    return fit.unfitted(theta)


def distinct(starts: Sequence[Screened], count: int) -> list[Screened]:
    """Pick the first starts whose shapes differ, or whose strengths do where there is none."""
    chosen: list[Screened] = []
    for start in starts:
        fit = start.fit
        logs = np.array([f.log for f in fit.model.free], dtype=bool)
        sizes = np.array([0.3 if f.log else 0.003 * f.size for f in fit.model.free])
        k = sizes.size
        if logs.any():
            sizes = np.where(logs, sizes, np.inf)
        if all(np.any(np.abs(fit.theta[:k] - c.fit.theta[:k]) > sizes) for c in chosen):
            chosen.append(start)
        if len(chosen) == count:
            break
    return chosen


def along_valley(along: EquationError, fit: Fit) -> list[Fit]:
    """Return further starts along the direction in which the equation error says least of a fit.

    They lie one and three deviations to either side, where a deviation is no small change.
    """
    direction = uncertainties(along, fit)
    if direction is None:
        return []
    found = []
    for share in (-3.0, -1.0, 1.0, 3.0):
        theta = fit.theta.copy()
        theta[: direction.size] += share * direction
        for i, free in enumerate(fit.model.free):
            low, high = (np.log(v) if free.log else v for v in (free.low, free.high))
            theta[i] = np.clip(theta[i], low, high)
        found.append(fit.unfitted(theta))
    return found


def cancelling_pairs(
    alone: Sequence[Fit], changes: Floats, residual: Floats, count: int
) -> list[tuple[int, int, tuple[float, float]]]:
    """Pick starts of two effects whose changes of a residual, scaled, cancel most of it.

    `changes` has a row for each start `alone`. Returns the indices of the two starts and their
    factors; best first, one for each of at most `count` pairs of effects.
    """
    gram, along = changes @ changes.T, -(changes @ residual)
    own = np.diag(gram)
    seen = own > 1e-12 * max(float(own.max(initial=0.0)), 1e-300)
    safe = np.where(seen, own, 1.0)
    determinant = safe[:, None] * safe - gram**2
    apart_enough = determinant > 1e-4 * safe[:, None] * safe
    first = (along[:, None] * safe - along * gram) / np.where(apart_enough, determinant, 1.0)
    first = np.clip(first, -STRONGEST_SCALING, STRONGEST_SCALING)
    # The second one answers to what the first one is held to.
    second = (along - first * gram) / safe
    second = np.clip(second, -STRONGEST_SCALING, STRONGEST_SCALING)
    left = (
        -2.0 * (first * along[:, None] + second * along)
        + first**2 * safe[:, None]
        + second**2 * safe
        + 2.0 * first * second * gram
    )
    names = [fit.model.names[0] for fit in alone]
    together = {(a, b): goes_with(a, (b,)) for a in set(names) for b in set(names)}
    joined = np.array([[together[a, b] for b in names] for a in names])
    left = np.where(apart_enough & seen[:, None] & seen & joined, left, np.inf)
    found: dict[frozenset[str], tuple[int, int, tuple[float, float]]] = {}
    for flat in np.argsort(left, axis=None, kind="stable"):
        i, j = divmod(int(flat), len(alone))
        if len(found) == count or not np.isfinite(left[i, j]):
            break
        pair = frozenset({names[i], names[j]})
        found.setdefault(pair, (i, j, (float(first[i, j]), float(second[i, j]))))
    return list(found.values())
