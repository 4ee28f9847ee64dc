"""Rigs with a force that no effect stands for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis_small import driven, measured

NAMES = ("viscous_friction", "drive_gain_error", "drive_lag", "sensor_scale", "coulomb_error")


def rig(effects, *, hidden: float, count: int = 5, runs=None):
    """Runs with an effect and with a force of their own, another one in each run."""
    runs = driven(count) if runs is None else runs
    random = np.random.default_rng(11)
    knots = np.linspace(0.0, 2.0, 8)
    real = [
        replace(run, drive=run.drive + np.interp(run.t, knots, hidden * random.standard_normal(8)))
        for run in runs
    ]
    return [
        replace(run, drive=told.drive)
        for run, told in zip(measured(effects, real), runs, strict=True)
    ]
