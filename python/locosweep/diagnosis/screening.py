"""The screen: which effects could explain a gap, by equation error alone, before any replay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl

from locosweep import _core
from locosweep.diagnosis.data.checks import check_runs, usable
from locosweep.diagnosis.data.inputs import nominal_model, read_runs
from locosweep.diagnosis.effects.catalogue import candidates
from locosweep.diagnosis.effects.scale import scale_of
from locosweep.diagnosis.estimate.equation_error import equation_error
from locosweep.diagnosis.estimate.equation_fits import refined
from locosweep.diagnosis.estimate.least_squares import Model, Nuisances, start_fits
from locosweep.diagnosis.estimate.nominal import spread_of
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.select.effort import LEAST_ERROR
from locosweep.diagnosis.select.screen import pairs_along, seen_along
from locosweep.diagnosis.select.search import Search
from locosweep.engine import whole
from locosweep.errors import InputError, SolveError
from locosweep.files.csv_form import CsvForm
from locosweep.linear_algebra import on_one_thread

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping, Sequence

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.files.robot import Robot

_VALUE = pl.Struct(
    {"effect": pl.String(), "name": pl.String(), "value": pl.Float64(), "unit": pl.String()}
)
_COLUMNS: dict[str, pl.DataType] = {
    "effects": pl.List(pl.String()),
    "mean_square": pl.Float64(),
    "share": pl.Float64(),
    "parameters": pl.List(_VALUE),
}


@dataclass(frozen=True)
class Screen:
    """What the equation error of some runs says of each effect, and of the best pairs.

    Attributes
    ----------
    mean_square : float
        Mean square of the nominal model's equation error, in that of noise: 1 is noise.
    slides, runs, of_runs : int
        Slides in one direction, the runs that have some, and all runs.
    table : polars.DataFrame
        Single effects, then pairs, best first: effects, mean_square (what is left with them),
        share (of the nominal model's mean square that they take away) and parameters.
    unseen : tuple of str
        Effects that the equation error does not see.
    warnings : tuple of str
        Notices about the runs.
    """

    mean_square: float
    slides: int
    runs: int
    of_runs: int
    table: pl.DataFrame
    unseen: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def ranks(self) -> bool:
        """True if the equation error is so large that its order of effects means something."""
        return self.mean_square > LEAST_ERROR


@on_one_thread
def screen(
    runs: Any,
    nominal: str | os.PathLike[str] | Robot,
    *,
    pairs: int = 5,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    threads: int | None = None,
) -> Screen:
    """Say which effects could explain a gap: a fit of each to the equation error.

    This is no verdict: a name takes replays, which also see what acts at rest (`diagnose`).

    Parameters
    ----------
    runs, nominal, columns, units, separator, decimal, threads
        As in `diagnose`. All runs are used.
    pairs : int
        Pairs of effects that are listed, at most.

    Returns
    -------
    Screen

    Raises
    ------
    InputError, DataFileError
        What was wrong with an argument or a file, in one line.
    SolveError
        No run has a slide that is long enough.

    Examples
    --------
    >>> import numpy as np
    >>> import locosweep as ls
    >>> from locosweep.diagnosis import screen
    >>> robot = ls.Robot({"mass": 0.2, "mu_coulomb": 0.3, "gravity": 9.81})
    >>> t = np.linspace(0.0, 1.0, 201)
    >>> x = 0.5 * (1.5 - 0.25 * 9.81) * t**2 + 1.2 * t
    >>> x += np.random.default_rng(0).normal(0.0, 1e-5, t.size)
    >>> runs = {"t": t, "drive": np.full(t.size, 0.3), "x": x}
    >>> found = screen(runs, robot)
    >>> ["coulomb_error"] in found.table["effects"].to_list()[:8]
    True
    """
    if isinstance(pairs, bool) or not isinstance(pairs, int | np.integer) or pairs < 0:
        raise InputError(f"pairs is {pairs!r}: allowed is a whole number from 0 upward")
    robot = nominal_model(nominal)
    records, notices, _ = read_runs(
        runs, columns or {}, units or {}, robot, CsvForm(separator, decimal)
    )
    chosen, missing = usable(records)
    scale = scale_of(robot, chosen)
    workers = _core.threads_to_use(whole("threads", threads))
    problem = Problem(robot, chosen, workers, speed_scale=scale.speed)
    along = equation_error(problem)
    if along is None:
        raise SolveError(
            "no run slides long enough in one direction for an equation error: only replays "
            "can say more (locosweep diagnose)"
        )
    names, _ = candidates(robot, {c for run in chosen for c in run.channels})
    nuisances = Nuisances((), spread_of(robot), scale.speed)
    search = Search(problem, nuisances, scale, tuple(names), along=along)
    (none,) = refined(along, start_fits(nuisances, Model((), ()), np.zeros((1, 0))))
    seen = seen_along(search, none, names)
    singles = sorted((fits[0] for fits in seen.values()), key=lambda fit: fit.chi2)
    found = [*singles, *(pairs_along(search, int(pairs), none) if pairs else ())]
    return Screen(
        none.chi2 / along.degrees,
        slides=sum(map(len, along.slides)),
        runs=sum(map(bool, along.slides)),
        of_runs=len(chosen),
        table=_table(found, none, along.degrees),
        unseen=tuple(name for name in names if name not in seen),
        warnings=(*notices, *missing, *check_runs(chosen, robot)),
    )


def _table(fits: Sequence[Fit], none: Fit, degrees: int) -> pl.DataFrame:
    rows = [
        {
            "effects": list(fit.model.names),
            "mean_square": fit.chi2 / degrees,
            # A fit that ends above its own beginning explains nothing.
            "share": max(1.0 - fit.chi2 / none.chi2, 0.0) if none.chi2 > 0.0 else 0.0,
            "parameters": [
                {"effect": f.effect, "name": f.name, "value": float(value), "unit": f.unit}
                for f, value in zip(fit.model.free, fit.parameters, strict=True)
            ],
        }
        for fit in fits
    ]
    return pl.DataFrame(rows, schema=_COLUMNS)
