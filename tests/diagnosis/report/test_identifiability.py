"""Which effects runs cannot identify, and why."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from diagnosis_small import driven, measured, problem
from locosweep.diagnosis.effects.catalogue import Free
from locosweep.diagnosis.estimate.least_squares import Fit, Model, Nuisances
from locosweep.diagnosis.report.identifiability import not_visible
from locosweep.diagnosis.select.search import Collection


def fitted(name: str, *, deviation: float = 0.1, log: bool = False, free: bool = True) -> Fit:
    """A fit of one effect whose strength is known to `deviation`, where 1 is large."""
    one = Free(name, "p", "1", log, 1.0, 1e-3, 10.0, 0.0)
    covariance = np.array([[deviation**2]]) if free else np.zeros((0, 0))
    model = Model((name,), (one,) if free else ())
    return Fit(model, Nuisances(), np.zeros(int(free)), covariance=covariance)


def why(*fits: Fit, way: float | None = None, left_out: dict[str, str] | None = None) -> dict:
    """Reasons by effect where the drive pushes both ways, or with `way` newtons."""
    runs = driven()
    if way is not None:
        runs = [replace(run, drive=np.where(run.t < 0.1, 0.0, way)) for run in runs]
    found = {frozenset(fit.model.names): fit for fit in fits}
    names = [fit.model.names[0] for fit in fits] + ["not_fitted"]
    search = SimpleNamespace(problem=problem(measured({}, runs, noise=0.0)), names=names)
    return {
        row["effect"]: row["why"] for row in not_visible(search, Collection(found), left_out or {})
    }


def test_what_was_left_out_comes_first() -> None:
    assert why(left_out={"anchor_slip": "no x_rear"}) == {"anchor_slip": "no x_rear"}


@pytest.mark.parametrize(("deviation", "open_"), [(0.29, False), (0.31, True)])
def test_a_strength_known_to_a_third_of_a_large_one(deviation: float, open_: bool) -> None:
    assert ("drive_lag" in why(fitted("drive_lag", deviation=deviation))) is open_


def test_strengths_in_logarithms_and_without_a_covariance_are_not_judged() -> None:
    assert why(fitted("drive_lag", deviation=9.0, log=True), fitted("back_emf", free=False)) == {}


@pytest.mark.parametrize(("way", "never"), [(1.0, "backward"), (-1.0, "forward")])
def test_a_head_that_only_moves_one_way(way: float, never: str) -> None:
    fits = [fitted("direction_dependent_friction"), fitted("lubricant_buildup")]
    reason = f"the head never moves {never} in these runs"
    assert why(*fits) == {}
    expected = {"direction_dependent_friction": reason}
    if never == "forward":
        expected["lubricant_buildup"] = reason
    assert why(*fits, way=way) == expected


def test_a_head_at_rest_shows_nothing_but_its_anchors() -> None:
    fits = [fitted("drive_lag"), fitted("anchor_slip")]
    assert why(*fits, way=0.0) == {"drive_lag": "the head does not move in these runs"}
