"""Motions that small forces change, and what these change of residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from locosweep import _core

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]


class Slides(NamedTuple):
    """A motion at its samples, of runs one after another; small forces act where it slides."""

    v: Floats
    step: Floats
    """Seconds to the next sample."""
    last: NDArray[np.bool_]
    """True at the last sample of a run."""
    mass: float
    damping: float
    """Viscous coefficient, N s/m."""
    keeps: Floats
    """Share of a change of speed that is left at the next sample, 1 but where the head turns."""
    stiffness: Floats
    """With which gravity pulls a pendulum back, N m/rad; 0 of others."""

    @classmethod
    def of_run(cls, t: Floats, v: Floats, mass: float, damping: float) -> Slides:
        """Return one run of a head that no gravity pulls back, and that turns in no time."""
        plain = np.ones(t.size), np.zeros(t.size)
        return cls(v, np.diff(t, append=t[-1:]), np.arange(t.size) == t.size - 1,
                   mass, damping, *plain)  # fmt: skip

    def response(self, forces: Floats) -> tuple[Floats, Floats]:
        """Return first-order changes of position and speed under small forces, a row a force."""
        found: tuple[Floats, Floats] = _core.linear_response(np.ascontiguousarray(forces), self)
        return found


def corrections(
    problem: Problem, terms: Sequence[Floats], motion: Slides | None, to: Floats
) -> None:
    """Write what terms change of whitened residuals into the front of the rows of `to`.

    They are forces along a motion of the fitted runs or, without one, errors of the position that
    is read; a row each, in tables one after another.
    """
    problem.misfit.corrections(list(terms), motion, problem.fitted, problem.threads, to)


def corrected(problem: Problem) -> list[slice]:
    """Return where residuals of the fitted runs change under corrections: x, v, and shifts."""
    samples, runs = problem.samples_of(problem.fitted), len(problem.fitted)
    places = [problem.channels.index(c) for c in ("x", "v") if c in problem.channels]
    shifts = (len(problem.start_shifts) + len(problem.rest)) * runs
    behind = len(problem.channels) * samples
    found = [slice(i * samples, (i + 1) * samples) for i in places]
    return [*found, slice(behind, behind + shifts)]
