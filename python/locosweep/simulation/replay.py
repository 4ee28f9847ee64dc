"""Replays of measured drives through a nominal or an augmented model."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core
from locosweep.engine import whole
from locosweep.errors import InputError
from locosweep.files.channels import REPLAYED
from locosweep.files.robot import is_rotary
from locosweep.progress import progress_of
from locosweep.registry import unknown

if TYPE_CHECKING:
    from collections.abc import Sequence

    import polars as pl

    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run
    from locosweep.progress import Progress


@cache
def _effects() -> dict[str, _core.Effect]:
    return {record.name: record for record in _core.effects()}


def effects() -> list[_core.Effect]:
    """List the effects that a nominal model of a measured run may lack.

    Returns
    -------
    list of Effect
        Records with ``name``, ``site`` (friction, drive, body, environment or
        sensor), ``formula`` (TeX), ``meaning`` and ``parameters``.

    Examples
    --------
    >>> import locosweep as ls
    >>> [e.name for e in ls.effects() if e.site == "sensor"]
    ['sensor_scale', 'sensor_drift', 'sensor_delay']
    """
    return list(_effects().values())


def effect(name: str) -> _core.Effect:
    """Return one effect by name; InputError with the nearest name if unknown."""
    try:
        return _effects()[name]
    except KeyError:
        raise unknown("effect", name, _effects()) from None


def nominal_of(robot: Robot) -> dict[str, float]:
    """Return the numbers of a robot file that a replay takes; InputError if one is missing."""
    other = robot.other
    values = {p.name: p.default for p in _core.parameters() if p.default is not None}
    values.update(robot.parameters)
    force = other.get("surface.coulomb_force")
    nominal: dict[str, float] = {
        "segments": values.get("segments", 1.0),
        "limit": values["drive_limit"],
    }
    for name in ("mass", "gravity", "viscous", "slope_deg", "gain"):
        nominal[name] = values[name]
    if force is not None:
        nominal["coulomb_force"] = float(force)
    elif "mu_coulomb" in values:
        nominal["mu_coulomb"] = values["mu_coulomb"]
    else:
        raise InputError("the model has no mu_coulomb and no coulomb_force in [surface]")
    if is_rotary(robot):
        nominal["gravity_torque"] = float(other.get("bench.gravity_torque", 0.0))
    return nominal


def motor_of(robot: Robot) -> tuple[float, float] | None:
    """Return winding resistance and force constant that a file gives in [motor].

    None where it does not: values that nobody stated predict no electric power.
    """
    given = robot.parameters
    if "winding_resistance" not in given or "force_constant" not in given:
        return None
    return float(given["winding_resistance"]), float(given["force_constant"])


def sensor_of(robot: Robot) -> dict[str, float]:
    """Return noise and steps of the sensors that a file gives in [sensor], by key."""
    given = {k.removeprefix("sensor."): v for k, v in robot.other.items() if "sensor." in k}
    return {key: float(value) for key, value in given.items()}


def effect_values(chosen: dict[str, dict[str, float]]) -> np.ndarray:
    """Return the parameters of all effects, in the registry's order, as one row."""
    row = np.zeros(_core.effect_parameter_count())
    for name, parameters in chosen.items():
        record = effect(name)
        known = [parameter.name for parameter in record.parameters]
        for given in parameters:
            if given not in known:
                raise unknown(f"parameter of {name}", given, known)
        for i, own in enumerate(known):
            row[record.first + i] = parameters.get(own, 0.0)
    return row


def _directions(chosen: dict[str, dict[str, float]]) -> dict[str, int]:
    """Return the number of everything that derivatives of a model may be taken by."""
    found = {}
    for name in chosen:
        record = effect(name)
        for i, parameter in enumerate(record.parameters):
            found[f"{name}.{parameter.name}"] = record.first + i
    for i, name in enumerate(_core.sensitivity_directions(), _core.effect_parameter_count()):
        found[name] = i
    return found


def replay_runs(
    robot: Robot,
    runs: Sequence[Run],
    *,
    channels: Sequence[str] = REPLAYED,
    sensitivities: Sequence[str] = (),
    threads: int | None = None,
    progress: bool | Progress | None = None,
) -> pl.DataFrame:
    """Replay runs through a model: what its sensors would read, without noise.

    Parameters
    ----------
    robot : Robot
        The model (`load_robot`), with its effects if it has any.
    runs : sequence of Run
        Drives and where the head starts (`locosweep.files.runs.load_runs`).
    channels : sequence of str, optional
        What is returned of x, v, x_rear and force; fewer take less memory and time.
    sensitivities : sequence of str, optional
        What derivatives are taken by: parameters of the model's effects, such as
        ``drive_lag.T``; ``mass_share``, ``coulomb_share`` and ``gain_share``, factors
        on the nominal values; ``clock_offset`` [s], by which the drive comes late; and
        ``x_start`` [m] and ``v_start`` [m/s].
    threads : int, optional
        As in `sweep`.
    progress : bool or callable, optional
        As in `sweep`.

    Returns
    -------
    polars.DataFrame
        Columns run, t and the channels, one row a sample; for every sensitivity
        ``x_by_NAME``, ``v_by_NAME``, ``x_rear_by_NAME`` and ``force_by_NAME``, the
        derivatives of these channels. NaN from where a run has left all bounds or cannot
        be resolved.

    Raises
    ------
    InputError
        If there are no runs, a channel or sensitivity is unknown, or an effect leaves the head
        no mass.

    Notes
    -----
    Derivatives are exact through stops, break-aways and edges of the drive (forward
    mode, with the jumps that an event's own time makes). Where a parameter moves an edge
    of the drive that falls on a sample, the derivative is that of one side.

    Examples
    --------
    >>> import locosweep as ls, numpy as np
    >>> from locosweep.files.robot import Robot
    >>> from locosweep.files.runs import Run
    >>> from locosweep.replay import replay_runs
    >>> t = np.linspace(0, 1, 101)
    >>> run = Run("a", t, np.zeros(101), {"x": np.zeros(101), "v": np.full(101, 0.5)})
    >>> robot = Robot({"mass": 1.0, "mu_coulomb": 0.1})
    >>> read = replay_runs(robot, [run], sensitivities=["coulomb_share"])
    >>> [round(read[name][-1], 6) for name in ("x", "x_by_coulomb_share")]
    [0.127421, -0.127421]
    """
    import polars as pl

    if not runs:
        raise InputError("runs is empty: allowed is at least one run")
    nominal = nominal_of(robot)
    data = [
        (
            run.since_start,
            run.drive,
            nominal["slope_deg"] if run.slope_deg is None else run.slope_deg,
        )
        for run in runs
    ]
    for name, given in robot.effects.items():
        for parameter in effect(name).parameters:
            added = given.get(parameter.name, 0.0) if parameter.unit == "kg" else 0.0
            if nominal["mass"] + added <= 0.0:
                raise InputError(
                    f"{name}.{parameter.name} is {added} kg: allowed is more than "
                    f"{-nominal['mass']} kg, as the head must have a mass"
                )
    asked = list(dict.fromkeys(channels))
    for name in asked:
        if name not in REPLAYED:
            raise unknown("channel", name, REPLAYED)
    if not asked:
        raise InputError(f"channels is empty: allowed are one or more of {', '.join(REPLAYED)}")
    rows = [REPLAYED.index(name) for name in asked]
    names = list(robot.effects)
    columns = [(i, 0, run.t.size, names) for i, run in enumerate(runs)]
    count = len(runs)
    values = np.tile(effect_values(robot.effects), (count, 1))
    shares = np.tile([1.0, 1.0, 1.0, 0.0], (count, 1))
    starts = np.array([run.start for run in runs])
    workers = _core.threads_to_use(whole("threads", threads))
    job = _core.Replay({**nominal}, data)
    meter = progress_of(progress, "replay")
    found: dict[str, np.ndarray]
    if sensitivities:
        known = _directions(robot.effects)
        for name in sensitivities:
            if name not in known:
                raise unknown("sensitivity", name, known)
        by = [[known[name] for name in sensitivities]] * count
        read, slopes = job.run_with_sensitivities(
            columns, values, shares, starts, by, workers, meter, channels=rows
        )
        found = dict(zip(asked, read, strict=True)) | _by_name(slopes, asked, sensitivities, runs)
    else:
        read = job.run(columns, values, shares, starts, workers, meter, channels=rows)
        found = dict(zip(asked, read, strict=True))
    return pl.DataFrame(
        {
            "run": np.repeat([run.label for run in runs], [run.t.size for run in runs]),
            "t": np.concatenate([run.t for run in runs]),
            **found,
        }
    )


def _by_name(
    slopes: np.ndarray, channels: Sequence[str], names: Sequence[str], runs: Sequence[Run]
) -> dict[str, np.ndarray]:
    """Return columns of derivatives from rows in which those of a run follow each other."""
    parts = np.split(slopes, len(names) * np.cumsum([run.t.size for run in runs])[:-1], axis=1)
    shaped = [part.reshape(len(channels), len(names), -1) for part in parts]
    whole = np.concatenate(shaped, axis=2)
    return {
        f"{channel}_by_{name}": whole[c, d]
        for d, name in enumerate(names)
        for c, channel in enumerate(channels)
    }
