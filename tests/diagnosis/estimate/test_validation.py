"""Residuals of what fits do not see."""

from __future__ import annotations

import numpy as np

from diagnosis_small import NOISE, ROBOT, driven, measured, problem
from locosweep.diagnosis.estimate.validation import validation_residuals
from locosweep.simulation.replay import replay_runs


def test_what_fits_do_not_see_are_the_other_samples() -> None:
    one = problem(measured({}, driven(1)), train_fraction=0.7)
    seen, unseen = one.residuals([one.plain()])[0], validation_residuals(one, [one.plain()])[0]
    count = one.count
    assert not seen[:count][~one.seen].any()
    assert not unseen[:count][one.seen].any()
    assert one.degrees() == 140
    assert problem(measured({}, driven(3)), held=(1,)).degrees([0, 1]) == 400
    # The offset is that of the samples that fits see.
    x = one.measured["x"] - replay_runs(ROBOT, one.runs)["x"].to_numpy()
    offset = np.diff((x / NOISE - unseen[:count])[~one.seen])
    np.testing.assert_allclose(offset, 0.0, atol=1e-6)


def test_runs_that_are_kept_from_fits() -> None:
    own = problem(measured({}), held=(1,))
    np.testing.assert_array_equal(
        validation_residuals(own, [own.plain()]), own.residuals([own.plain()], [1])
    )
    every = problem(own.runs)
    assert validation_residuals(every, [every.plain(), every.plain()]).shape == (2, 0)
