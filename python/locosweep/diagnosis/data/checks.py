"""Data checks before a diagnosis: runs without enough readings, and warnings about the others."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.noise import noise_of
from locosweep.errors import DataFileError
from locosweep.simulation.replay import motor_of, nominal_of, sensor_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run

_VALUES, _FEWEST = 20, 8
"""Fewest values of x in the best run, and in every run that takes part."""
_FEW = 4
"""Fewest runs that do not widen the intervals."""


def usable(runs: Sequence[Run]) -> tuple[list[Run], list[str]]:
    """Return the runs whose position was measured, and a warning for each other one."""
    known = [int(np.isfinite(run.channels["x"]).sum()) for run in runs]
    if max(known, default=0) < _VALUES:
        raise DataFileError(f"runs: column x has fewer than {_VALUES} values in every run")
    warnings = [
        f"run {run.label}: x has {count} values, at least {_FEWEST} are needed: it is left out"
        for run, count in zip(runs, known, strict=True)
        if count < _FEWEST
    ]
    return [run for run, count in zip(runs, known, strict=True) if count >= _FEWEST], warnings


def check_runs(runs: Sequence[Run], robot: Robot) -> list[str]:
    """Return warnings about runs and robot that limit what a diagnosis can say."""
    nominal = nominal_of(robot)
    warnings = []
    if len(runs) == 1:
        warnings.append("one run only: no second run confirms the result")
    elif len(runs) < _FEW:
        warnings.append(f"{len(runs)} runs only: intervals are wider than with {_FEW} or more")
    drives = [run.drive for run in runs]
    if all(np.ptp(drive) == 0.0 for drive in drives):
        warnings.append(
            "the drive is constant in every run: effects of the drive are hardly identifiable"
        )
    elif len(runs) > 1 and len({drive.tobytes() for drive in drives}) == 1:
        warnings.append(
            "every run has the same drive: runs with different drives tell more effects apart"
        )
    moved = [float(np.ptp(x[np.isfinite(x)])) for x in (run.channels["x"] for run in runs)]
    span = max(moved)
    sensor = sensor_of(robot)
    noise = max(sensor.get("position_noise", 0.0), sensor.get("position_resolution", 0.0))
    noise = noise or noise_of("x", runs, sensor).sd
    if span <= 8.0 * noise or span == 0.0:
        warnings.append(
            "the head never moves beyond the noise in these runs: few effects are identifiable"
        )
    free = max(_free(run, nominal["gain"]) for run in runs) / nominal["mass"]
    slopes = [nominal["slope_deg"], *(run.slope_deg or 0.0 for run in runs)]
    flat = "gravity_torque" not in nominal and not any(slopes)
    if flat and span > 2.0 * free + 100.0 * noise:
        warnings.append(
            f"x spans {span:.3g} m, the drive without any friction would move the head by at "
            f"most {free:.3g} m: is x in another unit than m (--unit x=mm)?"
        )
    if motor_of(robot) is None and any("power" in run.channels for run in runs):
        warnings.append(
            "power is measured but the nominal file gives no resistance and force_constant "
            "in [motor]: the column is not used"
        )
    for run in runs:
        steps = np.diff(run.t)
        if steps.max() > 10.0 * np.median(steps):
            warnings.append(
                f"run {run.label}: a gap of {steps.max():.3g} s between samples, "
                "the drive is taken as constant over it"
            )
        x = run.channels["x"]
        gone = float((~np.isfinite(x)).mean())
        if gone > 0.2:
            warnings.append(f"run {run.label}: {gone:.0%} of x is missing")
    return warnings


def _free(run: Run, gain: float) -> float:
    """Return the distance over which a run's drive would push 1 kg from rest, in m."""
    steps = np.diff(run.t)
    speed = np.concatenate([[0.0], np.cumsum(np.abs(run.drive[:-1]) * gain * steps)])
    return float(np.sum(speed[:-1] * steps + 0.5 * np.diff(speed) * steps))
