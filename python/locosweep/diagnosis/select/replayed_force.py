"""A force by place as it acts where the head really is: replayed beside the drive.

First order along the motion of a model is not all of a large gap: the model passes places where
the head never was, or misses those where it was.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.estimate.least_squares import evaluate, point_of
from locosweep.diagnosis.select.force_law import force_law
from locosweep.diagnosis.select.whiteness import noise_level

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem
    from locosweep.diagnosis.select.force_law import ForceLaw

    Floats = NDArray[np.float64]

_ROUNDS = 12
"""Replays of a force by place, at most, and times that its law is found again: 44 disturbances of
`locosweep blind-check --only outside` with seeds 11112 and 12121 took five replays or fewer."""
_OF_THE_DRIVE = ("force", "power")
"""Channels that the drive makes, wherever the head is."""
_SHORTEST = 1.0 / 16.0
"""Part of a change of the law below which it is not tried. Not derived."""
_WORTH = 0.1
"""Share of chi2 beyond noise that a law has to take to be better than the last one. Not derived."""


def acts(problem: Problem, fit: Fit, variable: str) -> bool:
    """Return whether a force of a variable can be replayed beside the drive of a model.

    Effects would change what is added to the drive, and a gain of 0 lets nothing through.
    """
    return variable == "terrain" and not fit.model.names and problem.nominal["gain"] != 0.0


def settled(law: ForceLaw, problem: Problem, fit: Fit) -> ForceLaw:
    """Return the law of a force by place under which replays of the fitted runs leave least.

    Gauss-Newton steps: the law is found again beside replays under it, while they leave less.
    """
    # A force beside the drive is not in the channels that the drive alone makes.
    runs = [
        replace(run, channels={c: run.channels[c] for c in run.channels if c not in _OF_THE_DRIVE})
        for run in problem.runs
    ]
    problem = replace(problem, runs=runs, known=problem.noise)
    best, now, left = None, problem, _left(problem, fit)
    for _ in range(_ROUNDS):
        new = law if best is None else force_law(now, fit, law.variable, best)
        step = None if new is None else _step(problem, fit, best, new, left)
        if step is None:
            break
        best, now = step
        left = _left(now, fit)
    if best is None or best is law:
        return law
    # Its interval and its formula are those beside replays under it.
    return force_law(now, fit, law.variable, best) or best


def _step(
    problem: Problem, fit: Fit, last: ForceLaw | None, new: ForceLaw, before: float
) -> tuple[ForceLaw, Problem] | None:
    """Return a law on the way from the last one, or from none, that leaves less than `before`.

    With the problem under it; None where even a short way does not.
    """
    part = 1.0
    while part >= _SHORTEST:
        law = new if part == 1.0 else _between(last, new, part)
        under = under_force(law, problem, fit)
        if under is not None and _left(under, fit) < (1.0 - _WORTH) * before:
            return law, under
        part *= 0.5
    return None


def with_share(law: ForceLaw, problem: Problem, fit: Fit) -> ForceLaw:
    """Return a force by place with the share of the error on unseen runs that it takes away.

    Unknown where no run was kept from the fit, where the force cannot be replayed, and where the
    replays diverge or do not settle.
    """
    if not (problem.held and acts(problem, fit, law.variable)):
        return law
    now = under_force(law, problem, fit)
    if now is None:
        return law
    point, kept = point_of(problem, fit), list(problem.held)
    before, after = (one.position_errors([point], kept)[0] for one in (problem, now))
    seen = np.isfinite(before) & np.isfinite(after)
    squares = [float(e[seen] @ e[seen]) for e in (before, after)]
    if squares[0] == 0.0:
        return law
    return replace(law, share=1.0 - float(np.sqrt(squares[1] / squares[0])))


def under_force(law: ForceLaw, problem: Problem, fit: Fit) -> Problem | None:
    """Return the problem with a force by place beside its drives, where heads are then.

    It is replayed until that stays; None where it does not.
    """
    gain, limit = problem.nominal["gain"], problem.nominal["limit"]
    point, every = point_of(problem, fit), range(len(problem.runs))
    robot = problem.robot
    free = replace(robot, parameters={**robot.parameters, "drive_limit": np.inf})
    x = problem.replay([point], every)["x"][0]
    for _ in range(_ROUNDS):
        if not np.isfinite(x).all():
            return None
        force = np.split(np.interp(x, law.at, law.size), problem.starts_at[1:-1])
        drives = [
            (np.clip(gain * run.drive, -limit, limit) + own) / gain
            for run, own in zip(problem.runs, force, strict=True)
        ]
        now = replace(problem, robot=free, known=problem.noise).driven_by(drives)
        last, x = x, now.replay([point], every)["x"][0]
        if np.abs(x - last).max() < problem.noise["x"].sd:
            return now
    return None


def _between(one: ForceLaw | None, other: ForceLaw, part: float) -> ForceLaw:
    """Return the law a part of the way from one, or from none, to another."""
    size = part * other.size
    if one is not None:
        size = size + (1.0 - part) * np.interp(other.at, one.at, one.size)
    return replace(other, size=size)


def _left(problem: Problem, fit: Fit) -> float:
    """Return what a model leaves of the fitted runs, in chi2 beyond noise."""
    (fit,) = evaluate(problem, [fit.unfitted()])
    return max(fit.chi2 - noise_level(problem, fit.residual) * problem.degrees(), 0.0)
