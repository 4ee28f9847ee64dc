"""Searches over a few effects on runs of a few hundred samples, for unit tests of one module."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from diagnosis_small import ROBOT, measured, problem
from locosweep.diagnosis.effects.scale import scale_of
from locosweep.diagnosis.estimate.equation_error import equation_error
from locosweep.diagnosis.estimate.least_squares import (
    Fit,
    Nuisances,
    chi2_of,
    fit_all,
    start_fits,
)
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.select.search import Search
from locosweep.files.runs import runs_from_frame

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import polars as pl

    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run


def search_of(runs: Sequence[Run], *names: str, held: tuple[int, ...] = ()) -> Search:
    """Return a search among `names` with nothing but them to fit."""
    scale = scale_of(ROBOT, list(runs))
    own = problem(runs, held=held, speed_scale=scale.speed)
    along = equation_error(own)
    return Search(own, Nuisances(speed=scale.speed), scale, names, along=along)


def search_for(effects: dict[str, dict[str, float]], *names: str) -> Search:
    """Return a search on runs of a reality with `effects`."""
    return search_of(measured(effects), *names)


def fit_of(search: Search, *names: str, values: Sequence[float] | None = None) -> Fit:
    """Return a set of effects, fitted from some values, 0 without them."""
    model = search.model(names)
    row = np.zeros((1, len(model.free))) if values is None else np.array([values])
    (fit,) = fit_all(search.problem, start_fits(search.nuisances, model, row), steps=20)
    return fit


def ranked(found: Mapping[frozenset[str], Fit]) -> list[Fit]:
    """Return fits, best first."""
    return sorted(found.values(), key=chi2_of)


def fits_of(
    robot: Robot, frame: pl.DataFrame, *names: str, held: tuple[int, ...] = ()
) -> tuple[Search, list[Fit]]:
    """Return a search on measured runs, and fits of single effects in the order of their names."""
    records = runs_from_frame(frame)
    scale = scale_of(robot, records)
    problem = Problem(robot, records, 1, held=held, speed_scale=scale.speed)
    nuisances = Nuisances((), (0.0, 0.0, 0.0, 0.0), scale.speed)
    search = Search(problem, nuisances, scale, names)
    starts = []
    for name in names:
        model = search.model((name,))
        starts += start_fits(nuisances, model, np.zeros((1, len(model.free))))
    return search, fit_all(problem, starts, steps=20)
