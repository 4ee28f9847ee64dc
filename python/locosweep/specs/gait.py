"""Gait files: one robot, its ground and its gait as TOML, read back to the same bits."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from locosweep.errors import InputError
from locosweep.files import toml
from locosweep.registry import unknown
from locosweep.simulation.gait import GaitRun, gait_parameters, gaits, run_gait
from locosweep.specs.spec_file import SpecFile

if TYPE_CHECKING:
    from locosweep._core import CancelToken, GaitParameter

_FORMAT = "locosweep.gait/1"


@dataclass(frozen=True)
class GaitSpec(SpecFile):
    """One robot and its gait. `to_toml` and `from_toml` keep it exactly.

    Attributes
    ----------
    schedule : str
        Name from ``locosweep.gaits()``.
    values : dict of str to float or tuple of float
        Parameters by name, in the units of ``locosweep.parameters()``; a tuple has
        a value for each segment or joint, from the head backward. What is not given
        takes the robot file's value, then the default.
    robot : str, optional
        Robot file; a relative path counts from `folder`.
    folder : Path
        The current folder, or that of the gait file.

    Raises
    ------
    InputError
        Unknown names, or values out of range.

    Notes
    -----
    The file has ``format = "locosweep.gait/1"`` and these tables, those of a robot
    file and a few keys more. Values in the gait file go before those of the robot
    file that it names. An array has a value for each segment (from ``[robot]`` and
    ``[surface]``) or each joint (stroke, ``[drive]`` and ``[joint]``).

    - ``[gait]``: schedule (needed), robot (a robot file), stroke (m), moving, cycles, dwell (s),
      wall_release, break_away, impact, time_step (s)
    - ``[robot]``: segments, mass (kg), gravity (m/s^2), segment_pitch (m)
    - ``[surface]``: mu_static, mu_coulomb, viscous (N s/m), slope_deg, skin_ratio,
      wall_force (N), corner_deg, coulomb_term, stribeck_term, stribeck_speed (m/s),
      stribeck_exponent, buildup (N/m), buildup_root (N/m^0.5), snowplough (N s^2/m^2)
    - ``[drive]``: limit (N), speed_limit (m/s)
    - ``[joint]``: stiffness (N/m), damping (N s/m)
    - ``[motor]``: supply_voltage (V), resistance (ohm), force_constant (N/A)

    Examples
    --------
    >>> from locosweep import GaitSpec
    >>> spec = GaitSpec("block", {"segments": 4.0, "moving": 2.0, "mass": (0.3, 0.2, 0.2, 0.3),
    ...                           "mu_static": 0.5, "mu_coulomb": 0.1, "drive_limit": 2.0,
    ...                           "break_away": 0.0, "impact": 0.0})
    >>> GaitSpec.from_toml(spec.to_toml()) == spec
    True
    >>> round(spec.run().results["advance"], 4)
    0.02
    """

    _kind = "gait file"

    schedule: str
    values: dict[str, float | tuple[float, ...]] = field(default_factory=dict)
    robot: str | None = None
    folder: Path = field(default=Path(), compare=False)

    def __post_init__(self) -> None:
        _check_schedule(self.schedule)
        for name, value in self.values.items():
            if name not in gait_parameters():
                raise unknown("parameter of a gait", name, gait_parameters())
            _check(gait_parameters()[name], value)

    def run(
        self,
        *,
        samples: int = 601,
        every: float | None = None,
        memory_limit: int | None = None,
        token: CancelToken | None = None,
    ) -> GaitRun:
        """Simulate it; arguments and errors as in ``locosweep.run_gait``."""
        from locosweep.files.robot import load_robot

        robot = None if self.robot is None else load_robot(self.folder / self.robot)
        return run_gait(
            self.schedule,
            robot=robot,
            samples=samples,
            every=every,
            memory_limit=memory_limit,
            token=token,
            **self.values,
        )

    def to_toml(self) -> str:
        """Return the text of a gait file."""
        document: dict[str, Any] = {"format": _FORMAT}
        document["gait"] = {"schedule": self.schedule, "robot": self.robot or None}
        for name, record in gait_parameters().items():
            document.setdefault(record.table, {})[record.key] = self.values.get(name)
        return toml.write(document)

    @classmethod
    def _of(cls, document: dict[str, Any], folder: Path) -> Self:
        return cls(*_read(document), folder)

    def _moved(self, folder: Path) -> Self:
        return replace(self, robot=toml.moved(self.robot, self.folder, folder), folder=folder)


_WORDS = ("schedule", "robot")
"""Keys of [gait] that are no parameters."""


def _check_schedule(name: str) -> None:
    names = [gait.name for gait in gaits()]
    if name not in names:
        raise unknown("gait", name, names)


def _check(record: GaitParameter, value: float | tuple[float, ...]) -> None:
    """Refuse values that this parameter cannot have, one by one."""
    several = isinstance(value, tuple)
    if several and record.part == "run":
        raise InputError(f"{record.parameter.name} is an array: allowed is one number")
    for one in value if isinstance(value, tuple) else (value,):
        record.parameter.check(one)


def _read(
    document: dict[str, Any],
) -> tuple[str, dict[str, float | tuple[float, ...]], str | None]:
    """Return schedule, values and robot file."""
    tables = list(dict.fromkeys(["gait", *(r.table for r in gait_parameters().values())]))
    toml.check_keys("key or table", document, ["format", *tables])
    toml.check_format(document, _FORMAT)
    values: dict[str, float | tuple[float, ...]] = {}
    words: dict[str, str] = {}
    for table in tables:
        content = toml.table(document, table)
        known = {r.key: r for r in gait_parameters().values() if r.table == table}
        extra = _WORDS if table == "gait" else ()
        toml.check_keys(f"key in [{table}]", content, [*extra, *known])
        for key, value in content.items():
            where = f"[{table}] {key}"
            if key in extra:
                words[key] = toml.word(where, value)
            else:
                values[known[key].parameter.name] = _value(where, known[key], value)
    if "schedule" not in words:
        allowed = ", ".join(gait.name for gait in gaits())
        raise InputError(f"[gait] schedule is missing: allowed is {allowed}")
    try:
        _check_schedule(words["schedule"])
    except InputError as error:
        raise InputError(f"[gait] schedule: {error}") from None
    for name, record in gait_parameters().items():
        if record.parameter.default is None and name not in values and "robot" not in words:
            allowed = record.parameter.allowed
            raise InputError(f"[{record.table}] {record.key} is missing: allowed is {allowed}")
    _lengths(values)
    return words["schedule"], values, words.get("robot")


def _lengths(values: dict[str, float | tuple[float, ...]]) -> None:
    count = values.get("segments")
    if not isinstance(count, float):
        return
    for name, value in values.items():
        record = gait_parameters()[name]
        needed = int(count) - (record.part == "joint")
        if isinstance(value, tuple) and len(value) != needed:
            raise InputError(
                f"[{record.table}] {record.key} has {len(value)} values: allowed is one, "
                f"or {needed}, one for each {record.part}"
            )


def _value(where: str, record: GaitParameter, value: object) -> float | tuple[float, ...]:
    """Read a number, or an array where each part may have its own."""
    if isinstance(value, list):
        if record.part == "run":
            raise InputError(f"{where} is an array: allowed is {record.parameter.allowed}")
        several = enumerate(value)
        return tuple(toml.value_of(f"{where}[{i}]", record.parameter, one) for i, one in several)
    return toml.value_of(where, record.parameter, value)
