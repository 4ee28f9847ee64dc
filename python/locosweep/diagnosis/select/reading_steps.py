"""Slips that only a replay shows: the error of the nominal model jumps from level to level.

No force moves a head from one reading to the next, so jumps between levels of pure noise are a
fault of the readings. Single jumps may be about the noise of a reading, as many readings tell a
level.

Two kinds of forces also make errors that levels come close to. Smooth ones are followed better by
a line with a bend for every level. One that acts at a few places, such as a magnet, never makes a
jump while the head rests. Where a model rests only just, the real head may move: so one jump has to
happen while drive and weight together are far from moving it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.readings.bounds import friction_level, pull_back
from locosweep.diagnosis.data.readings.finding import Finding
from locosweep.diagnosis.effects.catalogue import own_variables
from locosweep.diagnosis.estimate.least_squares import evaluate
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.thresholds import LEAST_GAIN, PENALTY
from locosweep.diagnosis.select.whiteness import whiteness_test

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]

_PRICE = 2.0 * PENALTY
"""Of a jump in chi2: its time and its size."""
_FEW = 4
"""Readings before a jump and behind it, at least, in which the nominal head must rest. Not
derived."""
_PLACE = 11.0
"""The same readings, times the square of the jump in deviations: a jump in noise is found within so
many readings of where it is, 95 times in 100 (Yao 1987). `pytest
tests/diagnosis/select/test_reading_steps.py -k place` draws such jumps."""
_STILL = 0.25
"""Way of the nominal head in these, over the jump, up to which it rests: what moves by so little
does not make the jump."""
_RESTING, _FEWEST = 0.25, 2
"""Share and number of jumps that happen at rest, at least. Three encoders that slip by the clock
have 6 of 13, 9 of 15 and 6 of 10, a magnet's stairs none of 22
(`locosweep blind-check --only outside --cases 210 --seed 8101`, cases 83, 100, 204 and 6)."""
_HELD = 0.5
"""Share of the nominal friction up to which drive and weight do not move a head at rest, whatever
the model lacks. Of such slips these three encoders have 4, 5 and 1; friction that drifts (`--cases
150 --seed 26262`, case 92) moves the head under 1.02 of the nominal friction."""


@dataclass(frozen=True, eq=False)
class _Levels:
    """Levels of one run's errors of x."""

    at: NDArray[np.intp]
    """Samples that have a reading."""
    cuts: list[int]
    """First reading of each level, and one behind the last."""
    means: list[float]

    @property
    def jumps(self) -> int:
        return len(self.means) - 1


def stepped_readings(
    problem: Problem, none: Fit, best: Fit, *, other_law: bool = False
) -> tuple[list[Flags], list[Finding]]:
    """Return which positions of each run lie beyond a slip, and the findings.

    There are some only if jumps explain the errors of the nominal model `none` in all runs down
    to noise, and better than the `best` model by as much as an effect has to: than other laws of
    its effects with `other_law`.
    """
    flags = [np.zeros(run.t.size, dtype=bool) for run in problem.runs]
    problem, every = replace(problem.of_all_samples(), held=()), list(range(len(problem.runs)))
    before, after = evaluate(problem, [none.unfitted(), best.unfitted()], every)
    left = before.residual.copy()
    first = problem.channels.index("x") * problem.count
    found: list[_Levels] = []
    resting, held = 0, False
    for r in every:
        a, b = int(problem.starts_at[r]), int(problem.starts_at[r + 1])
        at = np.flatnonzero(problem.weights["x"][a:b] > 0.0)
        errors, weights = left[first + a + at], problem.weights["x"][a:b][at]
        own = _levels(at, errors)
        nominal = problem.measured["x"][a:b][at] - errors / weights
        run = problem.runs[r]
        drive = problem.nominal["gain"] * run.drive[at]
        push = np.abs(drive - pull_back(run, problem.nominal, nominal))
        rests = _at_rest(own, nominal, weights, push)
        resting += len(rests)
        held |= min(rests, default=np.inf) < _HELD * friction_level(run, problem.nominal)
        for low, high, mean in zip(own.cuts, own.cuts[1:], own.means, strict=False):
            left[first + a + at[low:high]] -= mean
        found.append(own)
    jumps = sum(own.jumps for own in found)
    price = _PRICE * jumps - PENALTY * len(best.model.free)
    if other_law:
        variables = own_variables(best.model.names)
        price += NonparametricCorrection(problem, after).log_bayes_factor(variables, 1.0)
    better = float(after.residual @ after.residual) - float(left @ left) - price
    if not held or resting < max(_RESTING * jumps, _FEWEST) or better < LEAST_GAIN:
        return flags, []
    if whiteness_test(problem, left, every).rejected:
        return flags, []
    bent = 0.0
    for r, own in zip(every, found, strict=True):
        at = first + int(problem.starts_at[r]) + own.at
        bent += _bent_line(before.residual[at], own.cuts) - float(np.sum(left[at] ** 2))
    # The place of a jump is free, which the bends are not.
    if bent < PENALTY * jumps:
        return flags, []
    findings: list[Finding] = []
    for r, own in enumerate(found):
        if own.jumps:
            findings += _findings(problem, r, own, flags[r])
    return flags, findings


def _levels(at: NDArray[np.intp], errors: Floats) -> _Levels:
    """Cut errors, in deviations, at the jumps that gain more than an effect has to."""
    sums = np.concatenate([[0.0], np.cumsum(errors)])
    open_, cuts = [(0, errors.size)], [0, errors.size]
    while open_:
        low, high = open_.pop()
        if high - low < 2:
            continue
        middle = np.arange(low + 1, high)
        left, right = middle - low, high - middle
        apart = (sums[middle] - sums[low]) / left - (sums[high] - sums[middle]) / right
        gains = apart**2 * left * right / (high - low)
        best = int(np.argmax(gains))
        if gains[best] > LEAST_GAIN:
            cut = int(middle[best])
            cuts.append(cut)
            open_ += [(low, cut), (cut, high)]
    cuts.sort()
    means = [
        float((sums[high] - sums[low]) / (high - low)) if high > low else 0.0
        for low, high in pairwise(cuts)
    ]
    return _Levels(at, cuts, means)


def _at_rest(own: _Levels, nominal: Floats, weights: Floats, push: Floats) -> list[float]:
    """Return the largest `push` beside each jump beside which the nominal head does not move.

    In metres: readings of a coarse encoder differ in how much they count, and a position times
    their weights would move where the head rests.
    """
    pushes = []
    for cut, (before, after) in zip(own.cuts[1:-1], pairwise(own.means), strict=True):
        jump = abs(after - before)
        near = int(np.clip(_PLACE / max(jump**2, 1e-300), _FEW, nominal.size))
        beside = slice(max(cut - near, 0), cut + near)
        if np.ptp(nominal[beside]) < _STILL * jump / weights[cut]:
            pushes.append(float(push[beside].max()))
    return pushes


def _bent_line(errors: Floats, cuts: list[int]) -> float:
    """Return the squares that a line leaves which bends in the middle of every level."""
    if len(cuts) == 2:
        return float(np.sum((errors - errors.mean()) ** 2)) if errors.size else 0.0
    middle = [0.5 * (low + high - 1) for low, high in pairwise(cuts)]
    knots = np.unique([0.0, *middle, errors.size - 1.0])
    index = np.arange(errors.size)
    hats = np.array([np.interp(index, knots, one) for one in np.eye(knots.size)])
    along = hats @ errors
    best = np.linalg.lstsq(hats @ hats.T, along, rcond=None)[0]
    return float(errors @ errors - along @ best)


def _findings(problem: Problem, r: int, own: _Levels, flags: Flags) -> list[Finding]:
    """Mask all but the longest level of a run, and return a finding for each jump."""
    run, cuts = problem.runs[r], own.cuts
    lengths = np.diff(cuts)
    kept = int(np.argmax(lengths))
    said = []
    for k in range(own.jumps):
        # Each jump spoils the level on its far side, as seen from the one that is kept.
        spoilt = k if k < kept else k + 1
        flags[own.at[cuts[spoilt] : cuts[spoilt + 1]]] = True
        last, next_ = (int(own.at[cuts[k + 1] + i]) for i in (-1, 0))
        weight = float(problem.weights["x"][int(problem.starts_at[r]) + next_])
        jump = (own.means[k + 1] - own.means[k]) / weight
        where = "before" if k < kept else "behind"
        count = int(lengths[spoilt])
        note = (
            f"x jumps by about {jump:.2g} at {run.t[next_]:.4g} s, which the motion does not: "
            f"slipped? {count} readings {where} the jump are left out"
        )
        times = (float(run.t[last]), float(run.t[next_]))
        said.append(Finding(run.label, *times, "x", "slip", count, masked=True, note=note))
    return said
