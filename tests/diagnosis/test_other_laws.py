"""Verdicts on causes by another law than their formula, from end to end."""

from __future__ import annotations

import pytest

from locosweep.diagnosis import diagnose
from locosweep.diagnosis.select import verdict
from test_diagnosis import ROBOT, drives, measured, tethered

pytestmark = pytest.mark.whole


@pytest.mark.slow
def test_an_effect_that_only_bends_another_ones_law_is_not_named() -> None:
    lag = {"drive_lag": {"T": 0.03}, "drive_delay": {"T": 5e-5}}
    found = diagnose(measured(lag, drives()), ROBOT)
    assert found.effects == ["drive_lag"], found
    assert found.law_mismatch
    # As large as the lag itself it is a cause of its own.
    both = {"drive_lag": {"T": 0.03}, "drive_delay": {"T": 0.03}}
    assert len(diagnose(measured(both, drives()), ROBOT).effects) == 2


@pytest.mark.slow
def test_nothing_is_named_where_one_force_along_the_way_would_do() -> None:
    # A stiffer line is no other law of friction either: what it leaves is told instead.
    found = diagnose(tethered(drives(both=False, samples=150), 0.08, slack=0.2), ROBOT)
    assert found.status == "unexplained", found
    assert found.report["verdict"]["unlisted"]["variable"] == "place"
    assert "force by place, both ways alike" in found.summary


def test_what_only_the_run_that_was_kept_shows_is_found() -> None:
    # The stronger of two runs, which is kept, just reaches the limit; no start of a fit lies there.
    frame = measured({"drive_saturation": {"F_max": 1.118}}, drives(count=2))
    found = diagnose(frame, ROBOT)
    assert found.effects == ["drive_saturation"], found
    assert found.gap["held_out"] == []
    assert any("show a gap that the others do not" in warning for warning in found.warnings)


def test_a_verdict_that_stands_for_all_runs_keeps_its_unseen_figures(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    frame = measured({"viscous_friction": {"c": 0.03}}, drives())
    before = diagnose(frame, ROBOT)
    monkeypatch.setattr(verdict, "misses", lambda *_: True)
    found = diagnose(frame, ROBOT)
    assert found.effects == before.effects == ["viscous_friction"]
    assert found.gap == before.gap
    assert found.gap["shrink"] is not None
    assert any("the same if all runs are fitted" in warning for warning in found.warnings)
    assert not any("the same if all runs are fitted" in warning for warning in before.warnings)
