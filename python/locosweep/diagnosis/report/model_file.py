"""The augmented model as a file: the nominal file with the effects that were found."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from typing import TYPE_CHECKING

from locosweep import _core
from locosweep.diagnosis.effects.scale import level_of
from locosweep.files.robot import Robot, load_robot
from locosweep.simulation.replay import effect, nominal_of

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.diagnosis.estimate.problem import Point

__all__ = ["calibrated", "write_augmented"]


def calibrated(robot: Robot, point: Point, effects: dict[str, dict[str, float]]) -> Robot:
    """Return the model that a fit describes, its uncertain nominal values as fitted.

    Parameters
    ----------
    robot : Robot
        The nominal model.
    point : Point
        The fit: factors on mass, Coulomb level and gain, and the clock offset.
    effects : dict of str to dict of str to float
        Parameters of its effects, beside the nominal Coulomb level.
    """
    mass, level, gain, clock = (float(share) for share in point.shares)
    if (mass, level, gain, clock) == (1.0, 1.0, 1.0, 0.0):
        return replace(robot, effects=effects)
    before = nominal_of(robot)
    parameters, other = dict(robot.parameters), dict(robot.other)
    parameters["mass"] = mass * before["mass"]
    parameters["gain"] = gain * before["gain"]
    if "coulomb_force" in before:
        other["surface.coulomb_force"] = level * before["coulomb_force"]
    else:
        parameters["mu_coulomb"] = level * before["mu_coulomb"]
    found = Robot(parameters, other)
    shift = level_of(nominal_of(found)) - level_of(before)
    moved = {
        name: {k: v + shift if k in effect(name).levels else v for k, v in values.items()}
        for name, values in effects.items()
    }
    if clock != 0.0:
        # A clock that is off delays the drive.
        known = moved.get("drive_delay", {"T": 0.0})
        moved["drive_delay"] = {"T": known["T"] + clock}
    return replace(found, effects=moved)


def write_augmented(augmented: Robot, path: Path, nominal_text: str | None = None) -> None:
    """Write a model that `load_robot` reads back as `augmented`, value for value.

    Parameters
    ----------
    augmented : Robot
        The nominal model with its effects.
    path : Path
        The file.
    nominal_text : str, optional
        Text of the nominal file: kept as it is, comments and all, the effects
        added at its end, wherever that says what `augmented` holds.
    """
    if nominal_text is not None:
        kept = nominal_text.removeprefix("\ufeff")
        try:
            known = tomllib.loads(kept).get("effects", {})
            text = _with_effects(kept, {n: v for n, v in augmented.effects.items()
                                        if n not in known})  # fmt: skip
            tomllib.loads(text)
        except tomllib.TOMLDecodeError:
            # Effects in another spelling of TOML, which no table can follow.
            text = ""
        if text:
            _write(path, text)
            if load_robot(path) == augmented:
                return
    _write(path, _with_effects(_tables(augmented), augmented.effects))


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _with_effects(text: str, effects: dict[str, dict[str, float]]) -> str:
    parts = [text if not text or text.endswith("\n") else text + "\n"]
    for name, values in effects.items():
        units = {p.name: p.unit for record in _core.effects() if record.name == name
                 for p in record.parameters}  # fmt: skip
        lines = [f"[effects.{name}]"]
        for key, value in values.items():
            unit = units.get(key, "1")
            remark = "" if unit == "1" else f"  # {unit}"
            lines.append(f"{key} = {_number(value)}{remark}")
        parts.append("\n".join(lines) + "\n")
    return "\n".join(parts)


def _tables(robot: Robot) -> str:
    """Write everything but the effects, in the registry's order."""
    records = [(p, robot.parameters.get(p.name)) for p in _core.parameters() if p.file_key]
    keyed = [(p.file_key, value) for p, value in records if p.file_key and value is not None]
    found: dict[str, list[str]] = {}
    for (table, key), value in keyed:
        found.setdefault(table, []).append(f"{key} = {_number(value)}")
    for place, word in robot.other.items():
        table, _, key = place.partition(".")
        text = f'"{word}"' if isinstance(word, str) else _number(word)
        found.setdefault(table, []).append(f"{key} = {text}")
    return "\n".join(f"[{table}]\n" + "\n".join(lines) + "\n" for table, lines in found.items())


def _number(value: float) -> str:
    if math.isinf(value):
        return "inf" if value > 0 else "-inf"
    return repr(float(value))
