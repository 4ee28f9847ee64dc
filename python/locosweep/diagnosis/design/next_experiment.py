"""The next experiment: the further run that would tell apart the explanations that are left.

Each explanation is taken for the truth in turn: the runs so far and the new one are simulated
with it, and every other one is refitted to them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.special import ndtr

from locosweep.diagnosis.data.noise import Noise
from locosweep.diagnosis.design.menu import AGAIN, BACK, FORCE_NOISE, MENU
from locosweep.diagnosis.effects.catalogue import starts_of
from locosweep.diagnosis.estimate.least_squares import (
    Fit,
    evaluate,
    fit_all,
    jacobian_of,
    point_of,
    start_fits,
)
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.files.runs import Run

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.design.menu import Change
    from locosweep.diagnosis.select.search import Search

    Floats = NDArray[np.float64]

RESOLVED = 3.0
"""Distance, in deviations, from which two explanations are told apart."""
_SHOWN = 4
"""Runs of the menu that are shown: those that promise most, by derivatives. Their distances are
found by refits, up to the first that tells nearly always."""
_NEAREST = 2
"""Other explanations that are refitted to one that is taken for the truth."""
_FITTED = 1.0
"""Distance below which refits, which mostly make it less, are spared."""
_EQUAL = 0.5
"""Share of the weights that all explanations share: they tie."""
_REPEATS = 4
"""Most repeats of a run that are proposed: the squares of what they tell add up."""
_HOPE = 0.05
"""Chance of an answer that so many repeats have to add, or another run of the menu may."""
_FAR = 10.0
"""Distance beyond which farther is no better: so far apart, explanations are taken for each other
in one of 3e5 runs. A refit ends early that cannot come nearer."""
_LOST = 1e50
"""Chi2 of a model that cannot be replayed to the end."""


@dataclass
class _Planned:
    """Runs so far and one of the menu, before anything is measured in it."""

    problem: Problem
    """With blank readings, NaN where a run so far has none."""
    new_run: int
    """Index of the new run; the number of runs where there is none."""

    def seen_by(self, truth: Fit) -> Problem:
        """Return the problem whose readings are those of a model, without noise."""
        blank = self.problem
        read = blank.replay([point_of(blank, truth)])
        edges = blank.starts_at
        made = []
        for r, run in enumerate(blank.runs):
            own = slice(edges[r], edges[r + 1])
            channels = {
                c: np.where(np.isnan(values), np.nan, read[c][0, own])
                for c, values in run.channels.items()
            }
            made.append(replace(run, channels=channels))
        # A head that moves before the drive changes has readings that begin elsewhere.
        return replace(blank, runs=made, initial=blank.starts)


def next_experiment(
    search: Search, fits: Sequence[Fit], weights: Sequence[float]
) -> dict[str, Any]:
    """Simulate a menu of runs and say which one tells `fits` apart, the chosen one first.

    The distance of a run is the root of the least sum of squares, in deviations of the
    noise, that the nearest other explanation leaves of what one predicts for all runs so
    far and the new one together: its mean over what may be true. Its chance is the
    probability that the true one is told from all others; `weights` say how likely each is.
    """
    chosen, *rivals = fits
    separates = [sorted(set(chosen.model.names) ^ set(rival.model.names)) for rival in rivals]
    likely = np.array(weights) / max(sum(weights), 1e-300)
    likely = _EQUAL / len(fits) + (1.0 - _EQUAL) * likely
    likely = likely / likely.sum()
    so_far = _linearised(_planned(search), fits).min(axis=1)
    # The verdict says that they tie. Where another law replaces formulas, these may lie far apart.
    known = np.maximum(so_far**2 - RESOLVED**2, 0.0)
    plans = []
    for change in MENU:
        if _has_meaning(search.problem, change):
            planned = _planned(search, change)
            table = _linearised(planned, fits)
            told = _beyond(table.min(axis=1), known)
            plans.append((*_promise(told, likely), change, planned, table))
    plans.sort(key=lambda plan: plan[:2], reverse=True)
    rows: list[dict[str, Any]] = []
    found: dict[str, Floats] = {}
    most = -np.inf
    for _, _, change, planned, table in plans[:_SHOWN]:
        name, told = change.name, _beyond(table.min(axis=1), known)
        # Beside one that tells nearly always, no other is worth the time.
        refitted = most < 1.0 - _HOPE
        if refitted:
            distances = [
                _refitted(search, planned, fits, i, row, float(known[i]))
                for i, row in enumerate(table)
            ]
            told = found[name] = _beyond(np.array(distances), known)
        chance, distance = _promise(told, likely)
        most = max(most, chance) if refitted else most
        rows.append(
            {
                "run": name,
                "distance": distance,
                "chance": chance,
                "what": change.what,
                "refitted": refitted,
            }
        )
    rows.sort(key=lambda row: (row["refitted"], row["chance"], row["distance"]), reverse=True)
    best = rows[0]
    alone = _beyond(so_far, known)
    each = np.maximum(found[best["run"]] ** 2 - alone**2, 0.0)
    chances = [_promise(np.sqrt(alone**2 + n * each), likely)[0] for n in range(_REPEATS + 1)]
    if chances[-1] - chances[0] < _HOPE:
        missing = "no motion of this rig in the menu can separate these"
        return {"separates": separates, "suggestion": missing, "possible": False, "menu": rows}
    repeats = next(n for n, chance in enumerate(chances) if n and chance >= 0.8 * chances[-1])
    again = f", {repeats} times" if repeats > 1 else ""
    said = (
        f"{best['what']}{again} (tells them {RESOLVED:.0f} deviations apart with probability "
        f"{chances[repeats]:.2f}; expected distance with one run {best['distance']:.1f})"
    )
    return {"separates": separates, "suggestion": said, "possible": True, "menu": rows}


def back_again() -> dict[str, Any]:
    """Propose to go back the same way.

    Where it was passed in one direction, friction along it does as well as a force that depends on
    position: only friction reverses with the motion.
    """
    said = (
        f"{BACK.what}: friction reverses with the motion, a force that depends on position does not"
    )
    return {"separates": [], "suggestion": said, "possible": True, "menu": []}


def once_more(problem: Problem) -> dict[str, Any]:
    """Propose an exact repeat of a run, if no run so far has the drive and slope of another one.

    What belongs to the rig comes again then, a push from outside does not.
    """
    made = [(run.drive.tobytes(), run.slope_deg) for run in problem.runs]
    if len(set(made)) < len(made):
        return {"separates": [], "suggestion": None}
    said = f"{AGAIN.what}: what belongs to the rig comes again, a push from outside does not"
    return {"separates": [], "suggestion": said, "possible": True, "menu": []}


def _beyond(distances: Floats, known: Floats) -> Floats:
    """Return the distances that are left once squares that are known already are taken off."""
    left: Floats = np.sqrt(np.maximum(distances**2 - known, 0.0))
    return left


def _promise(distances: Floats, weights: Floats) -> tuple[float, float]:
    """Return the probability that the truth is told from all others, and the mean distance."""
    least = np.clip(distances, 1e-9, _FAR)
    chance = weights @ ndtr((least**2 - RESOLVED**2) / (2.0 * least))
    return float(chance), float(weights @ np.minimum(distances, _FAR))


def _has_meaning(problem: Problem, change: Change) -> bool:
    """Return whether a run of the menu is another one on this rig."""
    measured = change.added in problem.channels
    return not measured and not (change.on_slope and problem.position_matters)


def _planned(search: Search, change: Change | None = None) -> _Planned:
    """Return the runs so far and, with a change, one of the menu."""
    problem = search.problem
    noise = dict(problem.noise)
    channels = list(problem.channels)
    if change is not None and change.added:
        deviation = FORCE_NOISE * search.scale.force
        noise[change.added] = Noise(deviation, deviation, 0.0, stated=False)
        channels.append(change.added)
    runs = [_blank(run, problem.channels) for run in problem.runs]
    new_run = len(runs)
    if change is None:
        return _Planned(Problem(problem.robot, runs, problem.threads, known=noise), new_run)
    spans = [float(np.nanmax(r.channels["x"]) - np.nanmin(r.channels["x"])) for r in problem.runs]
    pattern = problem.runs[int(np.argmax(spans))]
    run = change.of(pattern, problem.nominal["slope_deg"])
    # It starts at the position of its pattern.
    made = {c: np.full(run.t.size, pattern.start[0] if c == "x" else 0.0) for c in channels}
    runs.append(Run("next", run.t, run.drive, made, run.slope_deg))
    blank = Problem(
        problem.robot,
        runs,
        problem.threads,
        known=noise,
        payload_factors={new_run: change.mass} if change.mass != 1.0 else {},
        reversed_runs=frozenset({new_run}) if change.turned else frozenset(),
    )
    return _Planned(blank, new_run)


def _bare(fit: Fit) -> Fit:
    """Return a fit whose runs all start at rest, where they start."""
    nuisances = replace(fit.nuisances, moving=(), start_offsets=())
    own = len(fit.model.free) + len(nuisances.uncertain)
    return Fit(fit.model, nuisances, fit.theta[:own].copy())


def _linearised(planned: _Planned, fits: Sequence[Fit]) -> Floats:
    """Return pairwise model-discrimination (T-optimality) distances, linearised.

    Row: the explanation taken for the truth; column: the one that is refitted, to first
    order in its parameters; infinite on the diagonal.
    """
    bare = [_bare(fit) for fit in fits]
    problem = planned.seen_by(bare[0])
    others = evaluate(problem, bare)
    count = len(fits)
    table = np.full((count, count), np.inf)
    for j, other in enumerate(others):
        rows = np.nan_to_num(jacobian_of(problem, other))
        _, sizes, basis = np.linalg.svd(rows, full_matrices=False)
        basis = basis[sizes > 1e-9 * sizes.max(initial=0.0)]
        for i, truth in enumerate(others):
            if i == j or other.chi2 + truth.chi2 > _LOST:
                continue
            left = other.residual - truth.residual
            table[i, j] = float(np.linalg.norm(left - basis.T @ (basis @ left)))
    # An explanation that cannot be compared with any other promises nothing.
    table[~np.isfinite(table).any(axis=1)] = 0.0
    return table


def _refitted(
    search: Search,
    planned: _Planned,
    fits: Sequence[Fit],
    truth: int,
    linear: Floats,
    known: float = 0.0,
) -> float:
    """Return the distance of the nearest other explanation, refitted.

    It may be too large beyond `_FAR`, once the square `known` is taken off.
    """
    least = float(linear.min())
    if least < _FITTED:
        return least
    problem = planned.seen_by(_bare(fits[truth]))
    trials = []
    for i in np.argsort(linear, kind="stable")[:_NEAREST]:
        if not np.isfinite(linear[i]):
            continue
        rival = fits[i]
        start = _bare(rival)
        trials.append(start)
        new = [n for n in rival.model.names if n not in fits[truth].model.names]
        if len(rival.model.names) == 1 and new:
            more = start_fits(start.nuisances, rival.model, starts_of(new[0], search.scale))
            # The rival's own start has what the runs so far say.
            more = evaluate(problem, more, [planned.new_run])
            trials += [f.without_residual() for f in sorted(more, key=lambda f: f.chi2)[:2]]
    trials = fit_all(problem, [replace(t, limit=known + _FAR**2) for t in trials], steps=8)
    return float(np.sqrt(max(min(trial.chi2 for trial in trials), 0.0)))


def _blank(run: Run, channels: Sequence[str]) -> Run:
    """Return a run whose readings are still to be made up, where it has any."""
    made = {
        c: np.where(np.isfinite(values), run.start[0] if c == "x" else 0.0, np.nan)
        for c, values in run.channels.items()
        if c in channels
    }
    return Run(run.label, run.t, run.drive, made, run.slope_deg)
