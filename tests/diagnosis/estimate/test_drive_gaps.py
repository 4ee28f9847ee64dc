"""Shifts by gaps in the drive: residuals of the true model are noise, those of others stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep.diagnosis.data.missing_rows import with_missing_rows
from locosweep.diagnosis.estimate.drive_gaps import gap_shifts
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.estimate.validation import validation_residuals
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs

NOISE = 1e-5
ROBOT = Robot(
    {"mass": 0.2, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {"sensor.position_noise": NOISE, "sensor.velocity_noise": 1e-3, "sensor.force_noise": 1e-3},
)
RATE = 200.0


def measured(share: float, effects: dict[str, dict[str, float]] | None = None) -> list[Run]:
    """Three runs of a drive that switches, of which a share of the rows was left out."""
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 4.0, 1.0 / RATE)
    runs = []
    for k in range(3):
        wave = np.sin(2.0 * np.pi * (0.9 + 0.3 * k) * t + k)
        drive = np.where(wave > 0.0, 1.1, -1.0)
        drive[:6] = 0.0
        runs.append(Run(str(k), t, drive, {"x": np.zeros(t.size)}))
    frame = replay_runs(replace(ROBOT, effects=effects or {}), runs)
    found = []
    for k, run in enumerate(runs):
        own = frame.filter(frame["run"] == str(k))
        kept = (rng.random(t.size) >= share) | (t == 0.0)
        # Every second switch falls into a gap.
        edges = np.flatnonzero(np.diff(run.drive)) + 1
        kept[edges[1::2]] = share == 0.0
        x, v, force = (own[c].to_numpy() for c in ("x", "v", "force"))
        channels = {
            "x": x + rng.normal(0.0, NOISE, t.size),
            "v": v + rng.normal(0.0, 1e-3, t.size),
            "force": force + rng.normal(0.0, 1e-3, t.size),
        }
        part = {c: y[kept] for c, y in channels.items()}
        found.append(with_missing_rows(Run(str(k), t[kept], run.drive[kept], part))[0])
    return found


def problem(runs: list[Run], **more: object) -> Problem:
    return Problem(ROBOT, runs, 1, **more)  # type: ignore[arg-type]


def size(problem: Problem) -> float:
    """Mean square of the residuals of the nominal model, in noise."""
    e = problem.residuals([problem.plain()])[0]
    return float(e @ e) / problem.degrees()


def test_without_gaps_there_are_no_shifts() -> None:
    whole = problem(measured(0.0))
    assert whole.gap_shifts.kinds == []
    assert size(whole) == pytest.approx(1.0, abs=0.1)


def test_residuals_of_the_true_model_are_noise_whatever_happened_in_the_gaps() -> None:
    runs = measured(0.03)
    unknown = problem(runs)
    assert size(unknown) == pytest.approx(1.0, abs=0.12)
    taken_as_known = problem([replace(run, drive_deviation=None) for run in runs])
    assert size(taken_as_known) > 100.0


def test_a_gap_of_another_cause_stays() -> None:
    runs = measured(0.03, {"coulomb_error": {"d_mu": 0.03}})
    assert size(problem(runs)) > 20.0


def test_shifts_are_as_many_as_the_core_takes_at_most() -> None:
    shifts = problem(measured(0.1)).gap_shifts
    assert 1 <= len(shifts.kinds) <= 15
    few = gap_shifts(problem(measured(0.1)), problem(measured(0.1)).weights, 2)
    assert len(few.kinds) == 2
    # What two leave out is noise of the samples behind the gaps.
    assert few.variance["x"].max() > shifts.variance["x"].max()


def test_readings_of_the_force_forget_a_gap_slowly() -> None:
    one = problem(measured(0.03))
    run = one.runs[0]
    assert run.drive_deviation is not None
    gap = int(np.flatnonzero(run.drive_deviation)[-1])
    variance = one.gap_shifts.variance["force"][: run.t.size]
    assert variance[gap + 1] > variance[gap + 4] > variance[gap + 8] > 0.0
    assert variance[gap - 1] < 1e-6 * variance[gap + 1]


def test_the_rest_of_a_single_run_is_freed_of_its_own_gaps() -> None:
    (run, *_) = measured(0.03)
    sizes = []
    for one in (run, replace(run, drive_deviation=None)):
        single = problem([one], train_fraction=0.6)
        rest = validation_residuals(single, [single.plain()])[0]
        counted = sum(int(((w > 0.0) & ~single.seen).sum()) for w in single.weights.values())
        sizes.append(float(rest @ rest) / counted)
    # Impulses of thousands of deviations of x bend one another's responses, which is left.
    assert sizes[0] < 1.5
    assert sizes[1] > 100.0
