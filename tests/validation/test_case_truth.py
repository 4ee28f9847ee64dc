"""What is true of a drawn case."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from locosweep.validation import case_truth
from locosweep.validation.cases import Case
from locosweep.validation.experiment import World

PUSH = ("coloured_push", "outside", {"A": 0.1, "T": 0.2})
LAG = ("drive_lag", "law", {"T": 0.05})


@dataclass
class Sizes:
    """Sizes of effects as they are told."""

    found: float
    asked: list[Any] = field(default_factory=list)

    def size(self, effects: Any) -> float:
        self.asked.append(effects)
        return self.found


def case(*effects: Any) -> Case:
    return Case("", None, None, World({}, effects), {"effects": []})  # type: ignore[arg-type]


def distances(monkeypatch: pytest.MonkeyPatch, **left: float) -> None:
    monkeypatch.setattr(case_truth, "rival_distances", lambda *_, **__: dict(left))


@pytest.mark.parametrize(("background", "alike"), [(10.0, False), (200.0, True)])
def test_over_a_background_a_rival_may_leave_what_adds_a_tenth(
    monkeypatch: pytest.MonkeyPatch, background: float, alike: bool
) -> None:
    # In squares beside 200, 60 adds 4 %; beside 10 it is six times as large.
    distances(monkeypatch, drive_lag=0.0, drive_delay=60.0, viscous_friction=900.0)
    gap = np.array([600.0, 800.0])
    truth = case_truth.over_background(case(LAG, PUSH), Sizes(0.0), gap, [], background).truth  # type: ignore[arg-type]
    (entry,) = truth["effects"]
    assert entry["d"] == pytest.approx(1000.0)
    assert entry["accepted"] == (["drive_lag", "drive_delay"] if alike else ["drive_lag"])
    assert entry["d_name"] == (900.0 if alike else 60.0)
    assert truth["background"] == {"name": PUSH[0], "parameters": PUSH[2], "d": background}


def test_what_copies_a_disturbance_is_accepted_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    distances(monkeypatch, drive_lag=2.0, viscous_friction=25.0)
    truth = case_truth.outside(case(PUSH), Sizes(0.0), np.ones(2), [], 40.0).truth  # type: ignore[arg-type]
    assert truth["status"] == "unexplained"
    assert truth["accepted"] == [["drive_lag"]]
    assert (truth["d"], truth["d_name"]) == (40.0, 2.0)


def test_a_single_effect_is_as_far_from_others_as_it_is_large(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    distances(monkeypatch, drive_lag=0.0, drive_delay=2.5, viscous_friction=70.0)
    truth = case_truth.single(case(LAG), Sizes(50.0), np.ones(2), []).truth  # type: ignore[arg-type]
    assert truth["accepted"] == [["drive_lag"], ["drive_delay"]]
    assert truth["status"] == "ambiguous"
    assert truth["effects"][0]["d_name"] == 50.0
