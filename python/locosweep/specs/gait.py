"""Gait files: one robot, its ground and its gait as TOML, read back to the same bits."""

from __future__ import annotations

import json
import os
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from locosweep.errors import DataFileError, InputError
from locosweep.registry import unknown
from locosweep.simulation.gait import GaitRun, gait_parameters, gaits, run_gait

if TYPE_CHECKING:
    from locosweep._core import CancelToken, GaitParameter

__all__ = ["GaitSpec"]

_FORMAT = "locosweep.gait/1"


@dataclass(frozen=True)
class GaitSpec:
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
    - ``[robot]``: segments, mass (kg), gravity (m/s^2)
    - ``[surface]``: mu_static, mu_coulomb, viscous (N s/m), slope_deg, skin_ratio,
      wall_force (N), corner_deg, coulomb_term
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
        lines = [f"format = {_text(_FORMAT)}"]
        for table in _tables():
            rows = [
                f"{record.key} = {_written(self.values[name])}"
                for name, record in gait_parameters().items()
                if record.table == table and name in self.values
            ]
            if table == "gait":
                words = {"schedule": self.schedule, "robot": self.robot}
                rows = [f"{k} = {_text(word)}" for k, word in words.items() if word] + rows
            if rows:
                lines += ["", f"[{table}]", *rows]
        return "\n".join(lines) + "\n"

    @classmethod
    def from_toml(cls, text: str, *, source: str = "gait file") -> GaitSpec:
        """Read the text of a gait file.

        Parameters
        ----------
        text : str
            TOML.
        source : str
            What to call it in messages.

        Raises
        ------
        DataFileError
            Not TOML, an unknown table or key (with the nearest known one), a value
            of the wrong kind, number or range; names source, table and key.
        """
        try:
            document = tomllib.loads(text)
        except (tomllib.TOMLDecodeError, RecursionError) as error:
            raise DataFileError(f"{source}: not TOML: {error}") from None
        try:
            return _read(document)
        except InputError as error:
            raise DataFileError(f"{source}: {error}") from None

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> GaitSpec:
        """Read a gait file; its robot file counts from its folder."""
        path = Path(path)
        try:
            text = path.read_bytes().decode("utf-8-sig")
        except OSError as error:
            raise DataFileError(f"{path}: {error.strerror or error}") from None
        except UnicodeDecodeError as error:
            raise DataFileError(f"{path}: not TOML: {error}") from None
        return replace(cls.from_toml(text, source=str(path)), folder=path.parent)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a gait file, in one step; its robot file is told from there."""
        from locosweep.files.atomic import replacing

        robot, folder = self.robot, Path(path).parent
        if robot is not None and folder.resolve() != self.folder.resolve():
            place = (self.folder / robot).resolve()
            robot = Path(os.path.relpath(place, folder.resolve())).as_posix()
        with replacing(path) as temporary:
            moved = replace(self, robot=robot)
            temporary.write_text(moved.to_toml(), encoding="utf-8", newline="\n")


_WORDS = ("schedule", "robot")
"""Keys of [gait] that are no parameters."""


def _tables() -> list[str]:
    return [
        "gait",
        *dict.fromkeys(r.table for r in gait_parameters().values() if r.table != "gait"),
    ]


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


def _text(word: str) -> str:
    # The escapes of JSON are those of TOML, apart from DEL, which JSON leaves bare.
    return json.dumps(word, ensure_ascii=True).replace("\x7f", "\\u007f")


def _written(value: float | tuple[float, ...]) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_written, value))}]"
    return repr(int(value)) if isinstance(value, int) else repr(float(value))


def _read(document: dict[str, Any]) -> GaitSpec:
    tables = _tables()
    for key in document:
        if key not in ("format", *tables):
            raise unknown("key or table", key, ["format", *tables])
    form = document.get("format", _FORMAT)
    if form != _FORMAT:
        raise InputError(f"format is {form!r}: this version reads {_FORMAT!r}")
    values: dict[str, float | tuple[float, ...]] = {}
    words: dict[str, str] = {}
    for table in tables:
        content = document.get(table, {})
        if not isinstance(content, dict):
            raise InputError(f"{table} is not a table: write [{table}]")
        known = {r.key: r for r in gait_parameters().values() if r.table == table}
        extra = _WORDS if table == "gait" else ()
        for key, value in content.items():
            if key in extra:
                words[key] = _word(f"[{table}] {key}", value)
            elif key in known:
                values[known[key].parameter.name] = _value(f"[{table}] {key}", known[key], value)
            else:
                raise unknown(f"key in [{table}]", key, [*extra, *known])
    if "schedule" not in words:
        allowed = ", ".join(gait.name for gait in gaits())
        raise InputError(f"[gait] schedule is missing: allowed is {allowed}")
    try:
        _check_schedule(words["schedule"])
    except InputError as error:
        raise InputError(f"[gait] schedule: {error}") from None
    if "robot" not in words:
        _complete(values)
    _lengths(values)
    return GaitSpec(words["schedule"], values, words.get("robot"))


def _complete(values: dict[str, float | tuple[float, ...]]) -> None:
    for name, record in gait_parameters().items():
        if record.parameter.default is None and name not in values:
            allowed = record.parameter.allowed
            raise InputError(f"[{record.table}] {record.key} is missing: allowed is {allowed}")


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


def _word(where: str, value: object) -> str:
    if not isinstance(value, str) or not value:
        raise InputError(f"{where} is {value!r}: allowed is a word in quotes")
    return value


def _value(where: str, record: GaitParameter, value: object) -> float | tuple[float, ...]:
    """Read a number, or an array where each part may have its own."""
    if isinstance(value, list):
        if record.part == "run":
            raise InputError(f"{where} is an array: allowed is {record.parameter.allowed}")
        return tuple(_number(f"{where}[{i}]", record, one) for i, one in enumerate(value))
    return _number(where, record, value)


def _number(where: str, record: GaitParameter, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{where} is {value!r}: allowed is {record.parameter.allowed}")
    try:
        number = float(value)
    except OverflowError:
        # Whole numbers of TOML have no limit.
        raise InputError(f"{where} is too large: allowed is {record.parameter.allowed}") from None
    try:
        return record.parameter.check(number)
    except InputError as error:
        # The table and key say more than the parameter's name.
        text = str(error)
        name = record.parameter.name
        raise InputError(where + text[len(name) :] if text.startswith(name) else text) from None
