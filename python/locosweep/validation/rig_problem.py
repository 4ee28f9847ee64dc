"""Logs of a rig as a diagnosis sees them: whole free runs, or windows, and errors on them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.noise import Noise
from locosweep.diagnosis.effects.catalogue import candidates
from locosweep.diagnosis.estimate.equation_error import equation_error
from locosweep.diagnosis.estimate.initial_state import initial_states
from locosweep.diagnosis.estimate.least_squares import Nuisances, point_of
from locosweep.diagnosis.estimate.problem import LOST, Problem
from locosweep.diagnosis.estimate.shooting import WindowProblem, cut, knows_start
from locosweep.diagnosis.estimate.window_plan import (
    WindowPlan,
    decimated,
    plan_of,
    problem_of,
    scale_in_windows,
)
from locosweep.diagnosis.estimate.windows import LEAD
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.search import Search
from locosweep.simulation.replay import effect_values

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.effects.scale import Scale
    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Point
    from locosweep.validation.planting import Rig

    Floats = NDArray[np.float64]


_EXACT = (0.0, 0.0, 0.0, 0.0)
"""A calibrated model is uncertain in nothing."""


@dataclass(frozen=True, eq=False)
class Seen:
    """A log and a model as fits see them."""

    rig: Rig
    problem: Problem
    """Whole runs, or windows of them; none is kept from fits."""
    nuisances: Nuisances
    scale: Scale
    plan: WindowPlan | None

    @cached_property
    def plain_errors(self) -> dict[str, float]:
        """Root mean square of measured less replayed values of the model, by channel."""
        return rms_of(self.problem, [self.problem.plain()])[0]


def see(rig: Rig, like: Seen | None = None) -> Seen:
    """Take a log as fits of `diagnose` would: some windows where it cuts runs, else whole runs.

    Which windows fits take depends on the drive. So that errors on logs of one rig compare, the
    windows are those of another log `like` it, or runs begin in the states in which its runs do.
    """
    whole = _whole(rig)
    if like is not None:
        if like.plan is not None and isinstance(like.problem, WindowProblem):
            return _see_windows(rig, _same_windows(rig, like.problem, like.plan), like.plan)
        whole = replace(whole, initial=like.problem.starts)
        return Seen(rig, whole, like.nuisances, rig.scale, None)
    plan = plan_of(whole)
    if plan is None:
        return _see_runs(rig, whole)
    return _see_windows(rig, problem_of(whole, plan)[0], plan)


def _same_windows(rig: Rig, like: WindowProblem, plan: WindowPlan) -> WindowProblem:
    """Cut a log at the times at which another one of the same runs is cut."""
    runs, first = [], []
    for run, known in zip(rig.runs, like.records, strict=True):
        step = float(np.median(np.diff(run.t)))
        dense = round(float(np.median(np.diff(known.t))) / step)
        runs.append(decimated(run, dense * step))
        # A log may begin before the other one, by whole samples or not.
        first.append(int(np.searchsorted(runs[-1].t, known.t[0] - 0.5 * dense * step)))
    spans, leads = [], [2] * len(runs)
    for window in like.windows:
        r = window.record
        a, b = (first[r] + i for i in window.span)
        if b <= runs[r].t.size and knows_start(runs[r], a, LEAD * plan.seconds):
            spans.append((r, a, b))
            leads[r] = window.counted[0]
    windows = cut(runs, spans, leads, plan.noise, LEAD * plan.seconds)
    return WindowProblem(rig.robot, windows, 1, known=plan.noise, records=tuple(runs))


def _whole(rig: Rig) -> Problem:
    return Problem(rig.robot, rig.runs, 1, speed_scale=rig.scale.speed)


def _see_windows(rig: Rig, windows: WindowProblem, plan: WindowPlan) -> Seen:
    scale = scale_in_windows(rig.scale, rig.robot, windows)
    every = replace(windows, held=())
    return Seen(rig, every, Nuisances((), _EXACT, scale.speed), scale, plan)


def _see_runs(rig: Rig, whole: Problem) -> Seen:
    offsets = tuple(enumerate(whole.priors["x"].tolist())) if whole.position_matters else ()
    nuisances = Nuisances((), _EXACT, rig.scale.speed, offsets)
    whole = replace(whole, initial=initial_states(whole, nuisances))
    nuisances = replace(nuisances, moving=whole.starts.moving)
    return Seen(rig, whole, nuisances, rig.scale, None)


def rms_of(problem: Problem, points: Sequence[Point]) -> list[dict[str, float]]:
    """Return root mean squares of measured less replayed values, by channel, of each model."""
    every = range(len(problem.runs))
    if isinstance(problem, WindowProblem):
        errors = problem.errors(points, every)
    else:
        read = problem.replay(points)
        errors = {c: problem.measured[c] - read[c] for c in problem.channels}
    return [
        {c: float(np.sqrt(np.nanmean(np.minimum(np.abs(e[i]), LOST) ** 2)))
         for c, e in errors.items()}
        for i in range(len(points))
    ]  # fmt: skip


def weighed(seen: Seen, errors: Mapping[str, float]) -> Seen:
    """Return a log whose channels count in units of these errors, in place of sensors' noise."""
    noise = {c: Noise(e, e, 0.0, stated=True) for c, e in errors.items() if e > 0.0}
    return replace(seen, problem=replace(seen.problem, known=noise))


def refits(seen: Seen) -> dict[str, Fit]:
    """Refit each effect alone, from several starts; the model itself has the empty name."""
    names, _ = candidates(seen.rig.robot, {c for run in seen.rig.runs for c in run.channels})
    along = equation_error(_whole(seen.rig))
    search = Search(seen.problem, seen.nuisances, seen.scale, tuple(names), along=along)
    return {"".join(names): fit for names, fit in singles(search).fits.items()}


def errors_of(seen: Seen, fits: Mapping[str, Fit]) -> dict[str, dict[str, float]]:
    """Return the errors of fits by their names, by channel."""
    points = [point_of(seen.problem, fit) for fit in fits.values()]
    return dict(zip(fits, rms_of(seen.problem, points), strict=True))


def with_effect(problem: Problem, name: str, values: Mapping[str, float]) -> Point:
    """Return the model of a problem with one effect."""
    return replace(problem.plain(), names=(name,), values=effect_values({name: dict(values)}))


def replayed(seen: Seen, name: str, values: Mapping[str, float]) -> Seen:
    """Return a log whose readings are those of its model with an effect, without noise."""
    problem = seen.problem
    read = problem.replay([with_effect(problem, name, values)])
    edges = problem.starts_at[1:-1]
    parts = {c: np.split(read[c][0], edges) for c in problem.channels}
    runs = [
        replace(run, channels={c: parts[c][i] for c in problem.channels if c in run.channels})
        for i, run in enumerate(problem.runs)
    ]
    if isinstance(problem, WindowProblem):
        return replace(seen, problem=replace(problem, runs=runs))
    # Equation errors of whole runs are those of the replayed motion, too.
    rig = replace(seen.rig, runs=tuple(runs))
    return replace(seen, rig=rig, problem=replace(problem, runs=runs, initial=problem.starts))
