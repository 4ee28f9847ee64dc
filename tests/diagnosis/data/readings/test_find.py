"""All faults of readings at once: named with run, column and time, and masked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep.diagnosis.data.readings.find import check_readings
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import nominal_of, replay_runs

ROBOT = Robot({"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0, "viscous": 0.05})
SENSOR = {"position_noise": 2e-5}
T = np.linspace(0.0, 2.5, 301)


def clean() -> list[Run]:
    runs = []
    for k in range(3):
        drive = (1.0 + 0.12 * k) * np.sin(2.0 * np.pi * (0.7 + 0.3 * k) * (T - 0.1))
        runs.append(Run(str(k), T, np.where(T < 0.1, 0.0, drive), {"x": np.zeros(T.size)}))
    x = replay_runs(ROBOT, runs)["x"].to_numpy().reshape(3, -1)
    x = x + np.random.default_rng(1).normal(0.0, 2e-5, x.shape)
    return [replace(r, channels={"x": own}) for r, own in zip(runs, x, strict=True)]


RUNS = clean()


def changed(at: slice | list[int], new: object, run: int = 1) -> list[Run]:
    x = RUNS[run].channels["x"].copy()
    x[at] = new(x[at]) if callable(new) else new
    runs = list(RUNS)
    runs[run] = replace(runs[run], channels={"x": x})
    return runs


def found(runs: list[Run]) -> tuple[list[tuple[str, str, float, float, int]], list[int]]:
    checked = check_readings(runs, nominal_of(ROBOT), SENSOR)
    rows = [(f.run, f.kind, f.t0, f.t1, f.samples) for f in checked.findings]
    assert all(f.masked and f.column == "x" for f in checked.findings)
    masked = np.concatenate([~np.isfinite(run.channels["x"]) for run in checked.runs])
    return rows, np.flatnonzero(masked).tolist()


def test_clean_runs_stay_as_they_are() -> None:
    checked = check_readings(RUNS, nominal_of(ROBOT), SENSOR)
    assert checked.findings == ()
    assert all(a is b for a, b in zip(checked.runs, RUNS, strict=True))


def test_a_spike() -> None:
    assert found(changed([150], lambda x: x + 0.01)) == ([("1", "spike", T[150], T[150], 1)], [451])


def test_dropouts_to_zero() -> None:
    rows, masked = found(changed([60, 100, 101, 150, 240], 0.0))
    assert {row[:2] for row in rows} == {("1", "dropout")}
    assert masked == [301 + i for i in (60, 100, 101, 150, 240)]
    assert sum(row[4] for row in rows) == 5


def test_readings_that_are_held() -> None:
    x = RUNS[1].channels["x"]
    bad = [60, 115, 230]
    rows, masked = found(changed(bad, x[[i - 1 for i in bad]]))
    assert [row[1] for row in rows] == ["dropout"] * 3
    assert masked == [301 + i for i in bad]


def test_a_frozen_stretch() -> None:
    x = RUNS[2].channels["x"]
    rows, masked = found(changed(slice(100, 140), x[99], run=2))
    assert rows == [("2", "frozen", T[100], T[139], 40)]
    assert masked == list(range(702, 742))


@pytest.mark.parametrize(("at", "kept"), [(80, slice(80, 301)), (220, slice(0, 220))])
def test_a_slip_leaves_the_longer_part(at: int, kept: slice) -> None:
    rows, masked = found(changed(slice(at, None), lambda x: x + 0.02))
    ((run, kind, t0, t1, samples),) = rows
    assert (run, kind, t0, t1) == ("1", "slip", T[at - 1], T[at])
    left = set(range(301)) - set(range(301)[kept])
    assert masked == [301 + i for i in sorted(left)]
    assert samples == len(left)


def test_other_columns_keep_their_readings() -> None:
    runs = [replace(run, channels={**run.channels, "force": run.drive}) for run in RUNS]
    x = runs[0].channels["x"].copy()
    x[33] += 0.05
    runs[0] = replace(runs[0], channels={**runs[0].channels, "x": x})
    checked = check_readings(runs, nominal_of(ROBOT), SENSOR)
    assert np.isfinite(checked.runs[0].channels["force"]).all()
    assert len(checked.findings) == 1


def test_what_is_missing_is_no_finding() -> None:
    rows, masked = found(changed([3, 77, 78, 200], np.nan))
    assert rows == []
    assert masked == [301 + i for i in (3, 77, 78, 200)]


def test_a_column_without_readings_is_left_alone() -> None:
    rows, _ = found(changed(slice(None), np.nan))
    assert rows == []
