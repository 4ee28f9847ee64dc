"""Free runs from measured states: noise under the truth, the closed solution under a push."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis_small import NOISE, ROBOT, measured, problem
from locosweep.diagnosis.estimate.free_run import free_errors
from locosweep.files.runs import Run


def test_under_the_truth_errors_are_small() -> None:
    own = problem(measured({}))
    cuts = [(0, 0, 60), (1, 100, 160), (2, 140, 200)]
    found = free_errors(own, own.plain(), cuts)
    assert [e.size for e in found] == [60, 60, 60]
    travel = float(np.ptp(own.measured["x"]))
    assert max(np.abs(e).max() for e in found) < 0.02 * travel


def test_an_unknown_push_grows_with_the_square_of_time() -> None:
    """A head that slides faster and faster than its model: the error is a t^2 / 2."""
    t = np.arange(0.0, 1.0, 0.005)
    mass, level = ROBOT.parameters["mass"], 0.3 * 0.25 * 9.81
    extra = 0.4
    x = 0.5 * ((1.0 - level) / mass + extra) * t**2
    x += NOISE * np.random.default_rng(1).standard_normal(t.size)
    own = problem([Run("0", t, np.full(t.size, 1.0), {"x": x})])
    (e,) = free_errors(own, own.plain(), [(0, 100, 180)])
    since = t[100:180] - t[100]
    slope = np.polyfit(since, e, 2)[0]
    assert slope == pytest.approx(0.5 * extra, rel=0.05)
