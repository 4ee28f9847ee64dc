"""Effects planted into the log of a measured rig, whose nominal model then lacks just them.

A case is made from runs of a rig and a model that was calibrated on it: a new log and a new
nominal model, such that the new model with the effect, on the new log, is the calibrated model
on the old one. What the calibrated model leaves stays in the readings, as it was measured.

Each effect has its ways, tried in turn:

- *a nominal value* that the effect is an error of is moved the other way: exact.
- *the drive column* is what goes through the inverse of the effect. Exact for gain and dead zone,
  and for a limit where the drive stood at its limit; up to the sampling for sag (its mean over a
  sample counts), delay (whole samples are exact, between them impulses are kept; a run that begins
  in motion has a first stretch of another drive) and lag (its force runs through the means of
  neighbouring samples).
- *a friction law* is what the rig has in addition: the force that it adds along the measured
  motion is added to the drive (`validation.extra_friction`). Up to sampling and smoothing of the
  motion.
- *the readings* of x are what a wrong sensor would have shown: exact for scale and drift, up to
  the interpolation between samples for delay. The column v is another sensor and stays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.noise import noise_of
from locosweep.diagnosis.data.regimes import measured_motion
from locosweep.diagnosis.effects.scale import scale_of
from locosweep.files.robot import Robot
from locosweep.simulation.replay import effect, nominal_of, sensor_of
from locosweep.validation.extra_friction import LAWS, drives_with, rests_at_first

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.regimes import MeasuredMotion
    from locosweep.diagnosis.effects.scale import Scale
    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]
    Values = dict[str, float]

_FEWEST_ROWS = 20
"""Rows that a run has to keep, as the file format asks for them."""
_PLATEAU = 0.02
"""Share of the rows that have to stand at the largest force for it to be a limit."""
_AT_LIMIT = 1e-6
"""Relative distance from the largest force up to which a row stands at it: files are rounded."""
_LEAST_LIMIT = 0.1
"""Largest force over the largest command, at least."""


class NotPlantable(Exception):
    """An effect, or so much of it, has no way into this log; the text says why."""


@dataclass(frozen=True, eq=False)
class Rig:
    """Measured runs and the model that was calibrated on them."""

    robot: Robot
    runs: tuple[Run, ...]

    @cached_property
    def nominal(self) -> Values:
        """Numbers of the model."""
        return nominal_of(self.robot)

    @cached_property
    def scale(self) -> Scale:
        """Sizes of the rig."""
        return scale_of(self.robot, self.runs)

    @cached_property
    def motions(self) -> tuple[MeasuredMotion, ...]:
        """Smoothed motion of each run."""
        noise = noise_of("x", self.runs, sensor_of(self.robot))
        return tuple(measured_motion(run, noise) for run in self.runs)


def plant(rig: Rig, name: str, values: Values, way: int = 0) -> Rig:
    """Return the rig with a log, and a nominal model, that lack an effect of these parameters.

    Parameters
    ----------
    rig : Rig
        Measured runs and their calibrated model.
    name : str
        An effect of `WAYS`.
    values : dict of str to float
        Its parameters, SI.
    way : int
        Which of its ways.

    Raises
    ------
    NotPlantable
        The log or the model does not allow it, or not so much of it.
    """
    if name not in WAYS:
        raise NotPlantable(IMPOSSIBLE[name])
    planted = WAYS[name][way](rig, values)
    limit, gain = planted.nominal["limit"], planted.nominal["gain"]
    for run in planted.runs:
        if not np.isfinite(run.drive).all():
            raise NotPlantable("the drive column would not be finite")
        if np.isfinite(limit) and gain * np.abs(run.drive).max() > 1.0001 * limit:
            raise NotPlantable("the drive column would go beyond the limit of the nominal file")
    return planted


def true_values(rig: Rig, name: str, values: Values) -> Values:
    """Return the parameters that a planted effect has: those that were asked for.

    A limit alone is where the drive stood, whatever was asked for.
    """
    return {"F_max": _standing(rig)[0]} if name == "drive_saturation" else values


def _moved(rig: Rig, name: str, value: float, least: float = 0.0) -> Rig:
    """Return a rig whose model has another value, above `least` or at it."""
    if value < least or not np.isfinite(value):
        raise NotPlantable(f"the nominal model has too little {name} to be taken away")
    if name in ("coulomb_force", "gravity_torque"):
        table = "surface" if name == "coulomb_force" else "bench"
        other = {**rig.robot.other, f"{table}.{name}": value}
        return Rig(replace(rig.robot, other=other), rig.runs)
    parameters = {**rig.robot.parameters, name: value}
    return Rig(replace(rig.robot, parameters=parameters), rig.runs)


def _less_viscous(rig: Rig, values: Values) -> Rig:
    (coefficient,) = values.values()
    return _moved(rig, "viscous", rig.nominal["viscous"] - coefficient)


def _less_coulomb(rig: Rig, values: Values) -> Rig:
    (change,) = values.values()
    name = "coulomb_force" if "coulomb_force" in rig.nominal else "mu_coulomb"
    return _moved(rig, name, rig.nominal[name] - change)


def _less_mass(rig: Rig, values: Values) -> Rig:
    mass = rig.nominal["mass"]
    left = mass - values["dm"]
    moved = _moved(rig, "mass", left, 1e-3 * mass)
    if "gravity_torque" in rig.nominal:
        return _moved(moved, "gravity_torque", rig.nominal["gravity_torque"] * left / mass, -np.inf)
    if "coulomb_force" in rig.nominal:
        # On a linear bench a payload presses the head onto the ground.
        return _moved(moved, "coulomb_force", rig.nominal["coulomb_force"] * left / mass)
    return moved


def _other_slope(rig: Rig, values: Values) -> Rig:
    change = values["d_alpha_deg"]
    moved = _moved(rig, "slope_deg", rig.nominal["slope_deg"] - change, -90.0)
    runs = tuple(
        run if run.slope_deg is None else replace(run, slope_deg=run.slope_deg - change)
        for run in rig.runs
    )
    return replace(moved, runs=runs)


def _driven(rig: Rig, drives: Sequence[Floats]) -> Rig:
    """Return a rig with other drive columns."""
    runs = [replace(run, drive=drive) for run, drive in zip(rig.runs, drives, strict=True)]
    return replace(rig, runs=tuple(runs))


def _other_gain(rig: Rig, values: Values) -> Rig:
    share = 1.0 + values["e"]
    if share <= 0.0:
        raise NotPlantable("a drive that gives nothing has no inverse")
    return _driven(rig, [run.drive / share for run in rig.runs])


def _before_deadzone(rig: Rig, values: Values) -> Rig:
    width = values["d"] / rig.nominal["gain"]
    return _driven(rig, [run.drive + width * np.sign(run.drive) for run in rig.runs])


def _before_sag(rig: Rig, values: Values) -> Rig:
    drives = []
    for run in rig.runs:
        t = run.since_start
        ends = np.append(t[1:], t[-1] + np.median(np.diff(t)))
        late = values["T"]
        # The mean of e^(-t/T) over what a sample holds.
        left = late * (np.exp(-t / late) - np.exp(-ends / late)) / (ends - t)
        share = 1.0 - values["a"] * (1.0 - left)
        if share.min() < 0.02:
            raise NotPlantable("a supply that is all but gone has no inverse")
        drives.append(run.drive / share)
    return _driven(rig, drives)


def _before_delay(rig: Rig, values: Values) -> Rig:
    """Log the drive so much earlier; the rows whose later drive is not known are cut.

    A head that rests under the first drive also gets rows before the first reading, as what was
    driven then acts after it.
    """
    late = values["T"]
    runs = []
    for run, motion in zip(rig.runs, rig.motions, strict=True):
        since = run.since_start
        step = float(np.median(np.diff(since)))
        early: Floats = np.zeros(0)
        if rests_at_first(run, motion, rig.nominal):
            early = np.arange(-np.ceil(late / step), 0.0) * step
        count = int(np.searchsorted(since, since[-1] - late, side="right"))
        if late < 0.0 or count < max(_FEWEST_ROWS, 0.5 * since.size):
            raise NotPlantable("the delay would cut more than half of a run")
        t = np.concatenate([early, since[:count]])
        starts = t + late
        ends = np.append(starts[1:], starts[-1] + step)
        drive = (_impulse(run, ends) - _impulse(run, starts)) / (ends - starts)
        channels = {
            c: np.concatenate([np.full(early.size, np.nan), y[:count]])
            for c, y in run.channels.items()
        }
        runs.append(replace(run, t=run.t[0] + t, drive=drive, channels=channels))
    return replace(rig, runs=tuple(runs))


def _impulse(run: Run, t: Floats) -> Floats:
    """Integral of a run's drive from its first sample on; beyond its ends it is held."""
    since = run.since_start
    given = np.append(0.0, np.cumsum(run.drive[:-1] * np.diff(since)))
    before = np.minimum(t, 0.0) * run.drive[0]
    after = np.maximum(t - since[-1], 0.0) * run.drive[-1]
    total: Floats = before + np.interp(t, since, given) + after
    return total


def _before_lag(rig: Rig, values: Values) -> Rig:
    """Log the command whose lagging force meets the means of neighbouring samples."""
    drives = []
    for run in rig.runs:
        force = np.append(run.drive[0], 0.5 * (run.drive[:-1] + run.drive[1:]))
        force[:2] = run.drive[0]
        kept = np.exp(-np.diff(run.t) / values["T"])
        command = (force[1:] - kept * force[:-1]) / (1.0 - kept)
        drives.append(np.append(command, run.drive[-1]))
    return _driven(rig, drives)


def _standing(rig: Rig) -> tuple[float, list[NDArray[np.bool_]]]:
    """Return the largest force of the drive, and where each run stands at it."""
    gain = rig.nominal["gain"]
    largest = gain * max(float(np.abs(run.drive).max()) for run in rig.runs)
    at = [gain * np.abs(run.drive) >= (1.0 - _AT_LIMIT) * largest for run in rig.runs]
    return largest, at


def _beyond_limit(rig: Rig, values: Values) -> Rig:
    """Log more than the drive gave where it stood at its largest force: an arch on each stretch.

    The limit is where the drive stood, so the strength lies in the log: its largest force is
    to that where it stood as the rig's large force is to `F_max`.
    """
    _, standing = _standing(rig)
    if sum(map(np.sum, standing)) < _PLATEAU * sum(run.t.size for run in rig.runs):
        raise NotPlantable("the drive never stands at its largest force, where a limit may be")
    if values["F_max"] < _LEAST_LIMIT * rig.scale.force:
        raise NotPlantable("the command would be out of all proportion to its limit")
    height = rig.scale.force / values["F_max"] - 1.0
    drives = []
    for run, at in zip(rig.runs, standing, strict=True):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]])))
        arch = np.ones(run.t.size)
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            share = (np.arange(last - first) + 0.5) / (last - first)
            arch[first:last] += height * np.sin(np.pi * share)
        drives.append(run.drive * arch)
    return _driven(rig, drives)


def _scaled_reading(rig: Rig, values: Values) -> Rig:
    def read(run: Run) -> Floats:
        start = run.start[0]
        return start + (1.0 + values["e"]) * (run.channels["x"] - start)

    return _read(rig, read)


def _drifting_reading(rig: Rig, values: Values) -> Rig:
    return _read(rig, lambda run: run.channels["x"] + values["b"] * run.since_start)


def _late_reading(rig: Rig, values: Values) -> Rig:
    def read(run: Run) -> Floats:
        x = run.channels["x"]
        ok = np.isfinite(x)
        seen = np.interp(run.t - values["T"], run.t[ok], x[ok])
        return np.where(ok, seen, np.nan)

    return _read(rig, read)


def _read(rig: Rig, read: Callable[[Run], Floats]) -> Rig:
    """Return a rig with other readings of x."""
    runs = [replace(run, channels={**run.channels, "x": read(run)}) for run in rig.runs]
    return replace(rig, runs=tuple(runs))


def _less_damping_by_drive(rig: Rig, values: Values) -> Rig:
    """Take back-EMF for what the model has of viscous friction: the motion is the same."""
    if any("force" in run.channels for run in rig.runs):
        raise NotPlantable("the force column would show the drive to give less")
    return _less_viscous(rig, values)


def _added(name: str) -> Callable[[Rig, Values], Rig]:
    """Return the way that adds a friction law's force along the motion to the drive.

    A force sensor reads the drive's force with it, except of a loss within the drive.
    """
    law, within_drive = LAWS[name], effect(name).site == "drive"

    def way(rig: Rig, values: Values) -> Rig:
        if any("power" in run.channels for run in rig.runs):
            raise NotPlantable("the power column does not say what more force would have taken")
        drives = drives_with(law, rig.nominal, rig.runs, rig.motions, values)
        runs = []
        for run, drive in zip(rig.runs, drives, strict=True):
            channels = dict(run.channels)
            if "force" in channels and not within_drive:
                more = rig.nominal["gain"] * (drive - run.drive)
                channels["force"] = channels["force"] + more
            runs.append(replace(run, drive=drive, channels=channels))
        return replace(rig, runs=tuple(runs))

    return way


WAYS: dict[str, tuple[Callable[[Rig, Values], Rig], ...]] = {
    "viscous_friction": (_less_viscous, _added("viscous_friction")),
    "quadratic_drag": (_added("quadratic_drag"),),
    "stribeck_friction": (_added("stribeck_friction"),),
    "direction_dependent_friction": (_added("direction_dependent_friction"),),
    "position_dependent_friction": (_added("position_dependent_friction"),),
    "load_dependent_friction": (_added("load_dependent_friction"),),
    "friction_drift": (_added("friction_drift"),),
    "lubricant_buildup": (_added("lubricant_buildup"),),
    "drive_saturation": (_beyond_limit,),
    "drive_lag": (_before_lag,),
    "drive_delay": (_before_delay,),
    "drive_deadzone": (_before_deadzone,),
    "drive_gain_error": (_other_gain,),
    "back_emf": (_less_damping_by_drive, _added("back_emf")),
    "supply_sag": (_before_sag,),
    "slope_error": (_other_slope,),
    "payload_mass": (_less_mass,),
    "coulomb_error": (_less_coulomb, _added("coulomb_error")),
    "sensor_scale": (_scaled_reading,),
    "sensor_drift": (_drifting_reading,),
    "sensor_delay": (_late_reading,),
}
"""Ways of planting each effect, the exact one first."""

IMPOSSIBLE = {
    "presliding_compliance": "where a contact creeps at rest, below the sensor, is not in the log",
    "transmission_backlash": "the motion of the drive's side is not in the log",
    "transmission_compliance": "the motion of the drive's side is not in the log",
    "anchor_slip": "it changes the body's motion, which no drive column undoes",
}
"""Why the other effects cannot be planted."""
