"""What each cause takes away of the gap on unseen data, and what is left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.estimate.least_squares import evaluate, fit_all, point_of
from locosweep.diagnosis.report.improvement import (
    interval_of_difference,
    reduction,
    share_interval,
)
from locosweep.diagnosis.report.localization import rms

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Point, Problem
    from locosweep.diagnosis.report.comparison import Comparison
    from locosweep.diagnosis.select.graded import Graded
    from locosweep.diagnosis.select.search import Collection, Search

    Floats = NDArray[np.float64]

_STEPS = 8
"""Steps of a fit of fewer causes, which begins at the values of all."""


@dataclass(frozen=True)
class Chain:
    """Models with one cause more each, and each cause alone."""

    classes: Sequence[Sequence[str]]
    """Effects that the runs cannot tell from one another, cause by cause; the named one first."""
    fits: Sequence[Fit]
    """Models with the first cause, with the first two, and so on."""
    alone: Sequence[Fit]


def chain_of(
    search: Search,
    known: Collection,
    whole: Fit,
    classes: Sequence[Sequence[str]],
    *,
    alone: bool = True,
) -> Chain:
    """Return the models of growing sets of causes; those that no step has fitted are fitted here.

    `whole` has all causes, in whatever order. Each cause by itself comes with `alone`.
    """
    names = [alike[0] for alike in classes]
    sets = [names[: i + 1] for i in range(len(names))]
    grown = [_model(search, known, whole, one) for one in sets]
    single = [_model(search, known, whole, [name]) for name in names] if alone else []
    return Chain(classes, grown, single)


def _model(search: Search, known: Collection, whole: Fit, names: Sequence[str]) -> Fit:
    if frozenset(names) == frozenset(whole.model.names):
        return whole
    found = known.fits.get(frozenset(names))
    if found is not None:
        return found
    model = search.model([name for name in whole.model.names if name in names])
    keep = [i for i, free in enumerate(whole.model.free) if free.effect in names]
    keep += range(len(whole.model.free), whole.theta.size)
    start = type(whole)(model, whole.nuisances, whole.theta[keep])
    (fit,) = fit_all(search.problem, evaluate(search.problem, [start]), steps=_STEPS)
    return fit


def contributions(
    problem: Problem,
    nominal: Point,
    chain: Chain,
    compare: Callable[[Point, Point], Comparison],
    channel: str,
    *,
    seed: int,
) -> list[dict[str, Any]]:
    """Return the report's list: what each cause takes away when it is added to those before it.

    A share is that of the nominal model's error on validation data; of the fitted data, without
    an interval, where the validation data show no gap.
    """
    grown = [compare(nominal, point_of(problem, fit)) for fit in chain.fits]
    alone = [compare(nominal, point_of(problem, fit)) for fit in chain.alone]
    rows: list[dict[str, Any]] = []
    before = None
    for i, alike in enumerate(chain.classes):
        share = _shrink(grown[i], channel, seed)
        known = share is not None
        if share is None:
            share = _shrink_of_all(grown[i], channel)
        last = 0.0 if before is None else _shrink(before, channel, seed)
        if before is not None and (last is None or not known):
            last = _shrink_of_all(before, channel)
        interval = interval_of_difference(before, grown[i], channel, seed) if known else None
        rows.append(
            {
                "effects": list(alike),
                "share": share - (last or 0.0),
                "share_ci": interval,
                "alone": _shrink(alone[i], channel, seed),
                "agrees_between_runs": None,
            }
        )
        before = grown[i]
    return rows


def graded_contributions(found: Graded, seed: int) -> list[dict[str, Any]]:
    """Return the same list for causes beside what nobody explains.

    Errors are those of runs that each model was not fitted to, every run left out in turn;
    intervals are those of as many runs like them, None of fewer than three.
    """
    none = found.none
    alone = {one.fit.model.names: one for one in found.ranked}
    runs = np.unique(found.of_run)
    rows = []
    for cause in found.causes:
        single = alone.get((cause.names[0],))
        before = [] if cause.before is none else [cause.before]
        models = [none, *before, cause.chosen]
        table = np.array([
            [one.squares[found.of_run == run].mean() for one in models] for run in runs
        ])  # fmt: skip
        share = (cause.before.error - cause.chosen.error) / max(none.error, 1e-300)
        rows.append(
            {
                "effects": list(cause.names),
                "share": share,
                "share_ci": share_interval(table, share, np.random.default_rng(seed)),
                "alone": None if single is None else 1.0 - single.error / none.error,
                "agrees_between_runs": cause.agrees,
            }
        )
    return rows


def _shrink(comparison: Comparison, channel: str, seed: int) -> float | None:
    found = reduction(comparison, channel, seed)["shrink"]
    return None if found is None else float(found)


def _shrink_of_all(comparison: Comparison, channel: str) -> float:
    """Return the fall of the error over all data, fitted or not; 0 where nothing was measured."""
    before, after = (rms(squares[channel]) for squares in comparison.squares)
    if not before or after is None:
        return 0.0
    return float(1.0 - after / before)


def graded_remaining(
    found: Graded, floor: float, shape: Sequence[dict[str, Any]]
) -> dict[str, Any]:
    """Return the report's entry about what is left beside causes, on runs left out in turn."""
    last, none = found.last.error, found.none.error
    return {
        "share": last / none if none > 0.0 else None,
        "rmse": last,
        "noise_floors": last / floor if floor else None,
        "shape": list(shape),
    }


def remaining(gap: dict[str, Any], shape: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the report's entry about what is left, from that about the gap."""
    before, after, floor = gap["before"], gap["after"], gap["noise_floor"]
    share = after / before if before and after is not None else None
    floors = after / floor if after is not None and floor else None
    return {
        "share": None if share is None else float(np.clip(share, 0.0, None)),
        "rmse": after,
        "noise_floors": floors,
        "shape": list(shape),
    }
