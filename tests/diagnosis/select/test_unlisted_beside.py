"""Forces that no effect stands for, against causes of small and of large errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from diagnosis_rest import NAMES, rig
from diagnosis_search import search_of
from diagnosis_small import driven, tethered
from locosweep.diagnosis.estimate.rest import RestForce
from locosweep.diagnosis.select.beside_rest import Candidate, compare_beside_rest
from locosweep.diagnosis.select.extension import singles
from locosweep.diagnosis.select.next_cause import Cause, is_far, motion_size
from locosweep.diagnosis.select.unlisted_beside import unlisted_beside


def against(runs, name: str, size: float) -> str:
    """What stands against an effect that leaves a quarter of an error of some size."""
    search = search_of(runs, *NAMES, "position_dependent_friction")
    fit = singles(search).single(name)
    now = compare_beside_rest(search, RestForce(search.problem), search.none, [fit])
    error = size * motion_size(now.problem) * np.ones(8)
    base = Candidate(search.none, 5000.0, error**2)
    cause = Cause((name,), Candidate(fit, 0.0, (0.25 * error) ** 2), base, agrees=True, weight=1.0)
    return unlisted_beside(replace(now, base=base), cause)


@pytest.mark.parametrize("size", [0.05, 0.5])
def test_a_spring_is_no_friction(size: float) -> None:
    assert against(tethered(4, 0.3, 40), "viscous_friction", size) == "terrain"


@pytest.mark.parametrize("size", [0.05, 0.5])
def test_drag_stays_drag(size: float) -> None:
    runs = rig({"viscous_friction": {"c": 0.15}}, hidden=0.003)
    assert against(runs, "viscous_friction", size) == ""


@pytest.mark.parametrize(("way", "found"), [(np.abs, "terrain"), (np.array, "")])
def test_friction_along_a_way_that_is_driven_once_is_no_more_than_a_force_by_place(
    way: Callable[[np.ndarray], np.ndarray], found: str
) -> None:
    runs = [replace(run, drive=way(run.drive)) for run in driven(5)]
    bumpy = {"position_dependent_friction": {"a": 0.03, "L": 0.4, "p": 1.0}}
    runs = rig(bumpy, hidden=0.003, runs=runs)
    assert against(runs, "position_dependent_friction", 0.05) == found


def test_a_force_of_every_runs_own_does_not_do_better_by_place() -> None:
    # Of three runs a law by place bends to the forces of all; none of them comes again in another.
    told = [replace(run, drive=np.abs(run.drive)) for run in driven(3)]
    runs = rig({"coulomb_error": {"d_mu": 0.03}}, hidden=0.03, runs=told, knots=20)
    search = search_of(runs, *NAMES)
    fit = singles(search).single("coulomb_error")
    now = compare_beside_rest(search, RestForce(search.problem), search.none, [fit])
    assert is_far(now, now.base)
    cause = Cause(("coulomb_error",), now.others[0], now.base, agrees=True, weight=1.0)
    assert cause.chosen.error < 0.2 * now.base.error
    assert unlisted_beside(now, cause) == ""
