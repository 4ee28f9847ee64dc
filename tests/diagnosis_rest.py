"""Rigs with a force that no effect stands for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis_small import driven, measured

NAMES = ("viscous_friction", "drive_gain_error", "drive_lag", "sensor_scale", "coulomb_error")


def rig(effects, *, hidden: float, count: int = 5, runs=None, knots: int = 8):
    """Runs with an effect and with a force of their own, another one in each run."""
    runs = driven(count) if runs is None else runs
    random = np.random.default_rng(11)
    at = np.linspace(0.0, 2.0, knots)
    real = [
        replace(run, drive=run.drive + np.interp(run.t, at, hidden * random.standard_normal(knots)))
        for run in runs
    ]
    return [
        replace(run, drive=told.drive)
        for run, told in zip(measured(effects, real), runs, strict=True)
    ]
