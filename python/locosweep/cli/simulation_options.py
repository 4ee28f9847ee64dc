"""Options of the commands that simulate: --law, --drive, --method, --drive-file, --gait."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click

from locosweep import registry
from locosweep.cli.options import DRIVE, FILE, LAW, METHOD
from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from pathlib import Path

    from locosweep.specs.simulation import Simulation

_Command = TypeVar("_Command", bound="Callable[..., Any]")
_LAW, _DRIVE, _TABLE = "coulomb_viscous", "constant", "table"

drive_file_option = click.option(
    "--drive-file", type=FILE, metavar="FILE.csv",
    help="Samples for --drive table: columns t [s] and drive [N]; each holds until the next; "
    "gain is the force per unit of drive.",
)  # fmt: skip


def simulation_options(*, gait: bool = False) -> Callable[[_Command], _Command]:
    """Add ``--law``, ``--drive``, ``--method`` and ``--drive-file``, and perhaps ``--gait``.

    The command gets what they say as one argument, ``simulation``.
    """
    options = [
        click.option("--law", type=LAW, metavar="NAME",
                     help=f"Friction law of what is simulated; default {_LAW}."),
        click.option("--drive", type=DRIVE, metavar="NAME",
                     help=f"Drive of what is simulated; default {_DRIVE}."),
        click.option("--method", type=METHOD, metavar="NAME",
                     help="Method of simulation; default the best for law and drive."),
        drive_file_option,
    ]  # fmt: skip
    if gait:
        text = "Gait of whole robots (gait_advance and others); default single."
        options.append(click.option("--gait", metavar="NAME", help=text))

    def add(command: _Command) -> _Command:
        @functools.wraps(command)
        def with_simulation(
            *arguments: Any,
            law: str | None,
            drive: str | None,
            method: str | None,
            drive_file: Path | None,
            gait: str | None = None,
            **others: Any,
        ) -> Any:
            simulation = chosen(law, drive, method, drive_file, gait)
            return command(*arguments, simulation=simulation, **others)

        for option in reversed(options):
            with_simulation = option(with_simulation)
        return cast("_Command", with_simulation)

    return add


def chosen(
    law: str | None,
    drive: str | None,
    method: str | None,
    drive_file: Path | None,
    gait: str | None = None,
) -> Simulation:
    """Return what the options say; a drive file alone means the drive ``table``."""
    from locosweep.specs.simulation import Simulation, read_drive

    if drive_file is None:
        if drive == _TABLE:
            raise InputError("--drive table needs --drive-file FILE.csv with columns t and drive")
        return Simulation(law, drive, method, gait=gait)
    if drive not in (None, _TABLE):
        raise InputError(f"--drive-file is given beside --drive {drive}: allowed is --drive table")
    # Refused now, before anything is computed or written.
    read_drive(drive_file)
    return Simulation(law, _TABLE, method, drive_file.as_posix(), gait)


def refuse_beside(form: str, given: Mapping[str, object], simulation: Simulation) -> None:
    """Refuse options that another form of the command does not take."""
    named = {"--" + name.replace("_", "-"): True for name in simulation.given}
    for name, value in (named | dict(given)).items():
        if value:
            raise InputError(f"{name} is given beside {form}: allowed is one of them")


def refuse_idle(names: Iterable[str], quantities: Iterable[str], simulation: Simulation) -> None:
    """Refuse axes that nothing depends on: every curve or column would be the same."""
    records = [registry.quantity(name) for name in quantities]
    if not all(record.simulated for record in records):
        return
    law, drive = simulation.law or _LAW, simulation.drive or _DRIVE
    used = {p.name for record in records for p in record.parameters}
    used |= {p.name for p in registry.law(law).parameters}
    used |= {p.name for p in registry.drive(drive).parameters}
    for name in names:
        if name not in used:
            raise InputError(
                f"{name} has several values, but law {law} with drive {drive} does not depend on "
                f"it{_hint(name)}"
            )


def _hint(name: str) -> str:
    """Say who does use a parameter."""
    owners = [
        f"{kind} {record.name}"
        for kind, records in (("law", registry.laws()), ("drive", registry.drives()))
        for record in records
        if name in {p.name for p in record.parameters}
    ]
    if not owners:
        return ""
    return f": those that do are {', '.join(owners)}"
