"""Errors on runs that a model has seen, and on those that it has not."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis_search import search_of
from diagnosis_small import NOISE, driven, measured
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.thresholds import UNSEEN_BLOCKS
from locosweep.diagnosis.select.unseen_errors import seen_error, unseen_squares

DRAG = {"viscous_friction": {"c": 0.15}}


def fitted(runs, *names):
    """A search over runs, and its fits: of the nominal model, and of single effects in order."""
    search = search_of(runs, *names)
    known = singles(search).fits
    return search, [search.none, *(known[frozenset([name])] for name in names)]


def test_the_cause_leaves_noise_of_what_it_has_seen() -> None:
    search, fits = fitted(measured(DRAG, driven(5)), "viscous_friction", "sensor_drift")
    none, cause, other = seen_error(search.problem, fits)
    assert cause == pytest.approx(NOISE, rel=0.2)
    assert cause < other < none


def test_each_run_is_predicted_from_the_others() -> None:
    """A cause that all runs share predicts each; a gap in one run alone is not predicted."""
    shared = measured(DRAG, driven(5))
    runs = driven(5)
    lone = [*measured({}, runs[:4]), *measured(DRAG, runs[4:])]
    shares = []
    for records in (shared, lone):
        search, fits = fitted(records, "viscous_friction")
        squares, _ = unseen_squares(search, search.problem, fits)
        assert squares.shape[0] == len(fits)
        assert squares.shape[1] >= UNSEEN_BLOCKS
        before, after = np.sqrt(squares.mean(axis=1))
        shares.append(after / before)
    assert shares[0] < 0.05
    assert shares[1] > 0.8


def test_what_lies_far_behind_is_not_tried_on_other_runs() -> None:
    """Its errors are those on the runs that it has seen."""
    search, (none, cause, other) = fitted(
        measured(DRAG, driven(5)), "viscous_friction", "sensor_drift"
    )
    squares, _ = unseen_squares(search, search.problem, [none, cause, other])
    (seen,) = seen_error(search.problem, [other])
    assert np.sqrt(squares[2].mean()) == pytest.approx(seen, rel=1e-2)


def test_blocks_without_readings_leave_the_others_to_their_runs() -> None:
    runs = measured(DRAG, driven(4))
    runs[1].channels["x"][90:] = np.nan
    search, fits = fitted(runs, "viscous_friction")
    squares, of_run = unseen_squares(search, search.problem, fits)
    assert squares.shape[1] == of_run.size
    assert of_run.tolist() == [0, 0, 1, 2, 2, 3, 3]


def test_of_one_run_the_last_part_judges() -> None:
    search, fits = fitted(measured(DRAG, driven(1)), "viscous_friction")
    squares, _ = unseen_squares(search, search.problem, fits)
    before, after = squares.mean(axis=1)
    assert after < 0.1 * before
