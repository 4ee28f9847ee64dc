"""The augmented model as a file: the nominal file with the effects that were found."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import tomlkit
from tomlkit.exceptions import TOMLKitError

from locosweep import _core
from locosweep.diagnosis.effects.scale import level_of
from locosweep.errors import DataFileError
from locosweep.files.robot import Robot, load_robot
from locosweep.simulation.replay import effect, nominal_of

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.diagnosis.estimate.problem import Point


def calibrated(robot: Robot, point: Point, effects: dict[str, dict[str, float]]) -> Robot:
    """Return the model of a fit with its effects, given beside the nominal Coulomb level."""
    mass, level, gain, clock = (float(share) for share in point.factors)
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

    The text of the nominal file is kept, comments and all, but for values that differ in
    `augmented`; the effects are added at its end.
    """
    # Effects in another spelling of TOML cannot be added to: then the text is written anew.
    for start in ((nominal_text or "").removeprefix("\ufeff"), ""):
        try:
            path.write_text(_filled(start, augmented), encoding="utf-8", newline="\n")
            if load_robot(path) == augmented:
                return
        except (TOMLKitError, DataFileError):
            continue


def _filled(text: str, robot: Robot) -> str:
    """Return a TOML text with the values of a robot set in it."""
    document = tomlkit.parse(text)
    given: list[tuple[str, str, float | str]] = [
        (*p.file_key, robot.parameters[p.name])
        for p in _core.parameters()
        if p.file_key and p.name in robot.parameters
    ]
    for dotted, word in robot.other.items():
        table, _, key = dotted.partition(".")
        given.append((table, key, word))
    for table, key, value in given:
        content = document.setdefault(table, {})
        if content.get(key) != value:
            content[key] = value
    effects = document.setdefault("effects", tomlkit.table(is_super_table=True))
    for name, values in robot.effects.items():
        content = effects.setdefault(name, {})
        units = {p.name: p.unit for p in effect(name).parameters}
        for key, value in values.items():
            if content.get(key) != value:
                item = tomlkit.item(float(value))
                content[key] = item if units[key] == "1" else item.comment(units[key])
    return tomlkit.dumps(document)
