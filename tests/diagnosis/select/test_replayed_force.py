"""A force by place, replayed: its law where gaps are large, and its share on unseen runs."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis_search import search_of
from diagnosis_small import tethered
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.select import replayed_force
from locosweep.diagnosis.select.force_law import force_law
from locosweep.diagnosis.select.replayed_force import acts, settled, with_share
from locosweep.files.robot import Robot

STRONG = 0.2
"""Stiffness that takes a fifth of the way, N/m: far from what is first order."""


def with_gain(robot: Robot, gain: float) -> Robot:
    """A robot whose drive has another gain."""
    return replace(robot, parameters={**robot.parameters, "gain": gain})


def test_a_strong_tether_is_seen_where_the_head_was() -> None:
    search = search_of(tethered(stiffness=STRONG, rounds=40), "viscous_friction", held=(3,))
    first = force_law(search.problem, search.none, "terrain")
    assert first is not None
    law = settled(first, search.problem, search.none)
    most = STRONG * float(np.abs(law.at).max())
    errors = [float(np.abs(one.size + STRONG * one.at).max()) / most for one in (first, law)]
    assert errors[0] > 0.2
    assert errors[1] < 0.03
    assert np.all(np.abs(law.size + STRONG * law.at) < 4.0 * law.deviation)
    assert law.found is not None
    assert np.allclose(law.found.at(law.at), -STRONG * law.at, atol=0.02 * most)
    shares = [with_share(one, search.problem, search.none).share for one in (first, law)]
    assert shares[0] is not None
    assert shares[1] is not None
    assert shares[1] > 0.98 > shares[0]


def test_a_force_beside_the_drive_is_not_looked_for_in_a_measured_drive_force() -> None:
    runs = tethered(stiffness=STRONG, rounds=40)
    told = [replace(run, channels={**run.channels, "force": run.drive}) for run in runs]
    laws = []
    for given in (runs, told):
        search = search_of(given, "viscous_friction")
        law = force_law(search.problem, search.none, "terrain")
        assert law is not None
        laws.append(settled(law, search.problem, search.none))
    assert np.allclose(laws[0].size, laws[1].size, atol=0.02 * float(np.abs(laws[0].size).max()))


def test_a_law_that_replays_refute_is_left_as_it_was() -> None:
    search = search_of(tethered(), "viscous_friction")
    law = force_law(search.problem, search.none, "terrain")
    assert law is not None
    wrong = replace(law, size=-law.size)
    assert settled(wrong, search.problem, search.none) is wrong


def test_only_a_force_by_place_beside_no_effect_is_replayed() -> None:
    search = search_of(tethered(), "viscous_friction")
    assert acts(search.problem, search.none, "terrain")
    assert not acts(search.problem, search.none, "speed")
    still = replace(search.problem, robot=with_gain(search.problem.robot, 0.0))
    assert not acts(still, search.none, "terrain")


def test_a_part_of_a_step_is_tried_where_the_whole_goes_too_far() -> None:
    search = search_of(tethered(), "viscous_friction")
    law = force_law(search.problem, search.none, "terrain")
    assert law is not None
    far = replace(law, size=3.0 * law.size)
    step = replayed_force._step(search.problem, search.none, None, far, np.inf)
    assert step is not None
    assert step[0] is far
    whole = replayed_force._left(search.problem, search.none)
    part = replayed_force._step(search.problem, search.none, None, far, whole)
    assert part is not None
    assert np.allclose(part[0].size, 0.5 * far.size)


def test_a_share_says_what_is_left_of_unseen_runs() -> None:
    search = search_of(tethered(), "viscous_friction", held=(3,))
    law = force_law(search.problem, search.none, "terrain")
    assert law is not None
    share = with_share(law, search.problem, search.none).share
    assert share is not None
    # Three deviations of the noise are left of five.
    assert share > 0.6


def test_a_share_needs_a_run_that_was_kept() -> None:
    search = search_of(tethered(), "viscous_friction")
    law = force_law(search.problem, search.none, "terrain")
    assert law is not None
    assert with_share(law, search.problem, search.none).share is None


def test_no_share_where_the_drive_acts_on_nothing_or_replays_diverge(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search = search_of(tethered(), "viscous_friction", held=(3,))
    law = force_law(search.problem, search.none, "terrain")
    assert law is not None
    still = replace(search.problem, robot=with_gain(search.problem.robot, 0.0))
    assert with_share(law, still, search.none).share is None
    replay = Problem.replay

    def diverging(own: Problem, *given: Any) -> dict[str, Any]:
        read = replay(own, *given)
        return read if own is search.problem else {c: np.nan * row for c, row in read.items()}

    monkeypatch.setattr(Problem, "replay", diverging)
    assert with_share(law, search.problem, search.none).share is None
