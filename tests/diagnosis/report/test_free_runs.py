"""Error of free runs by their length."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_small import driven, measured, problem
from locosweep.diagnosis.report.comparison import compare_whole_runs
from locosweep.diagnosis.report.free_runs import _up_to, errors_by_length


def test_samples_count_up_to_each_length() -> None:
    times = [np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0])]
    squares = [np.array([0.0, 4.0, 9.0]), np.array([np.nan, 16.0])]
    found = _up_to([-1.0, 0.5, 1.0, 3.0], times, squares)
    assert np.isnan(found[0])
    assert found[1:] == pytest.approx([0.0, np.sqrt(20 / 3), np.sqrt(29 / 4)])


def test_a_gap_grows_and_falls_to_the_noise_with_its_cause() -> None:
    own = problem(measured({"payload_mass": {"dm": 0.02}}, driven(3)))
    true = replace(own.plain(), names=("payload_mass",), values=own.plain().values.copy())
    true.values[own.parameter_index("payload_mass", "dm")] = 0.02
    both = compare_whole_runs(own, own.plain(), true)
    last = compare_whole_runs(own, true, true)
    found = errors_by_length(both, {"payload_mass": last}, "x")
    assert not found["restarted"]
    before, after = found["errors"].values()
    assert list(found["errors"]) == ["nominal model", "payload_mass"]
    assert found["seconds"][-1] == max(run.since_start[-1] for run in own.runs)
    assert before[-1] > 3.0 * before[3]
    assert after[-1] == pytest.approx(own.noise["x"].sd, rel=0.2)
    both_ends = errors_by_length(both, {}, "force")
    assert both_ends["errors"] == {"nominal model": []}
