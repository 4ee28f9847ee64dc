"""Characteristics and behaviour of friction laws, as numbers for pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.errors import InputError
from locosweep.registry import Law, law, laws, parameter
from locosweep.simulation.trajectories import simulate

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]

_SHOWN = {
    "mu_static": 0.45, "mu_coulomb": 0.3, "viscous": 2.0, "stribeck_speed": 0.015,
    "stribeck_exponent": 0.5, "modelica_decay": 50.0, "transition_speed": 0.004, "quadratic": 40.0,
    "power_drag": 15.0, "load_friction": 0.2, "viscous_load": 2.0, "skin_ratio": 1.4,
    "ripple_amplitude": 0.3, "ripple_length": 0.02, "patch_start": 0.02, "patch_length": 0.03,
    "patch_ratio": 1.6, "track_2": 1.2, "track_3": 1.5, "track_4": 1.3, "track_5": 0.7,
    "track_6": 0.8, "buildup": 10.0, "buildup_root": 0.5, "snowplough": 20.0, "mixed_speed": 0.025,
    "dwell_time": 0.2,
}  # fmt: skip
"""Values that make the traits of the laws visible in one frame."""

_TYPICAL = {"N": 0.4, "m": 0.02, "s": 0.2, "1": 0.3}
"""Values by unit, of that frame: half a Coulomb level, a stroke, its time, a coefficient."""

_MICRO, _MILLI = 1e6, 1e3

_FINE = 2e-5
"""Step in s that resolves the steep rise of smooth laws at rest."""


def _example() -> dict[str, float]:
    """Return values for all laws; of what is off by default and not in the table, a typical one."""
    known = {p.name: p for law in laws() for p in law.parameters}
    return _SHOWN | {
        name: _typical(record.unit)
        for name, record in known.items()
        if name not in _SHOWN and not record.default and record.unit != "deg"
    }


def _typical(unit: str) -> float:
    """Return a value in a unit such as "N s^2/m^2"."""
    above, _, below = unit.partition("/")
    value = 1.0
    for sign, factors in ((1.0, above.split()), (-1.0, below.split())):
        for base, _, power in (factor.partition("^") for factor in factors):
            value *= _TYPICAL.get(base, 1.0) ** (sign * float(power or 1))
    return value


EXAMPLE = _example()
"""Values of the parameters of all laws, by name, for pictures."""


@dataclass(frozen=True)
class Characteristic:
    """Friction force of steady sliding over speed.

    Attributes
    ----------
    law, kind : str
        Name and kind (dry, smooth or bristle).
    speed, force : ndarray
        Speed in m/s, rising, without 0, and signed force in N.
    rest : tuple of float, optional
        Lowest and highest friction in N at rest; None for laws that are not dry.
    level : float
        Coulomb level in N, or static level of a law that has no other.
    """

    law: str
    kind: str
    speed: Floats
    force: Floats
    rest: tuple[float, float] | None
    level: float


@dataclass(frozen=True)
class Behaviour:
    """Curves of a property of a law that its characteristic does not show, with their labels.

    Each line has legend (empty: none), abscissae and ordinates; labels include units.
    """

    title: str
    x_label: str
    y_label: str
    lines: tuple[tuple[str, Floats, Floats], ...]


def _own(record: Law, given: Mapping[str, float]) -> dict[str, Any]:
    """Return the values that a law and its normal force depend on."""
    names = {p.name for p in record.parameters}
    names |= {"mass", "gravity", "slope_deg", "corner_deg", "wall_force"}
    return {name: float(value) for name, value in given.items() if name in names}


def characteristic_of(
    name: str, speed: ArrayLike | None = None, **parameters: float
) -> Characteristic:
    """Evaluate the friction characteristic of a law.

    Parameters
    ----------
    name : str
        The law (``locosweep.laws()``), at the start of its track and without a drive.
    speed : array_like, optional
        Speeds in m/s; 0 is left out, there friction is set-valued or nought.
        Default -0.1 to 0.1, denser around rest.
    **parameters
        Values by name; those that the law does not use are left alone.

    Examples
    --------
    >>> from locosweep.simulation.law_data import characteristic_of
    >>> c = characteristic_of("static_coulomb", [-1, 1], mu_static=0.5, mu_coulomb=0.3)
    >>> c.force.round(4), round(c.rest[1], 4)
    (array([-0.7976,  0.7976]), 1.3293)
    """
    record = law(name)
    for key, value in parameters.items():
        parameter(key).check(value)
    given = list(_own(record, parameters).items())
    if speed is None:
        positive = 0.1 * np.linspace(0.0, 1.0, 801)[1:] ** 2
        speeds = np.concatenate([-positive[::-1], positive])
    else:
        speeds = np.unique(np.asarray(speed, np.float64))
        speeds = speeds[speeds != 0]
    if not speeds.size or not np.isfinite(speeds).all():
        raise InputError("speed has no value other than 0, or one that is not finite")
    force = np.asarray(_core.characteristic(name, given, speeds), np.float64)
    rest = None
    if record.kind == "dry":
        tiny = np.array([-1e-300, 0.0, 1e-300])
        back, hold, ahead = np.asarray(_core.characteristic(name, given, tiny)).tolist()
        # Skin turns static friction around in the same ratio as sliding friction.
        rest = (back * (hold / ahead) if ahead else -hold, hold)
    return Characteristic(name, record.kind, speeds, force, rest, level_of(record, parameters))


def level_of(record: Law, parameters: Mapping[str, float]) -> float:
    """Return the Coulomb level in N, or the static level of a law that has no other."""
    used = {p.name for p in record.parameters}
    ratio = parameters["mu_coulomb" if "mu_coulomb" in used else "mu_static"]
    plain = _own(law("coulomb"), parameters) | {"mu_coulomb": ratio}
    return float(_core.characteristic("coulomb", list(plain.items()), np.ones(1))[0])


def behaviour_of(name: str, **parameters: float) -> Behaviour:
    """Simulate what sets a law apart from a plain level over speed.

    That is of bristle laws the presliding loops below break-away, of smooth ones the creep
    under a steady load, of laws of position friction along the track, of `load_friction`
    friction over the drive force, of other dry ones the pull of a spring whose end moves
    slowly. Parameters that the law does not use are left alone.

    Examples
    --------
    >>> from locosweep.simulation.law_data import behaviour_of
    >>> behaviour_of("dahl", mu_coulomb=0.3).title
    'presliding under slow sines below break-away'
    """
    record = law(name)
    given = _own(record, parameters)
    scale = level_of(record, parameters)
    used = {p.name for p in record.parameters}
    if not scale > 0:
        raise InputError("friction coefficients are 0: behaviour is relative to that level")
    if record.kind == "bristle":
        return _presliding(name, given, scale)
    if record.kind == "smooth":
        return _creep(name, given, scale)
    if "load_friction" in used:
        return _load(name, given, scale)
    if "buildup" in used:
        return _heap(name, given, scale)
    if used & {"ripple_length", "patch_length", "track_length"}:
        return _along(name, given, scale)
    return _pulled(name, given, scale)


_FORCE = "friction over Coulomb level"


def _presliding(name: str, given: dict[str, Any], scale: float) -> Behaviour:
    shares = np.array([0.3, 0.6, 0.9])
    hold = float(_core.characteristic(name, list(given.items()), np.zeros(1))[0])
    run = simulate(law=name, drive="sine", drive_amplitude=shares * hold, duration=2.0,
                   samples=1001, **given)  # fmt: skip
    friction = run.force - run.fixed["mass"] * np.gradient(run.v, run.t, axis=-1)
    lines = tuple(
        (f"up to {share:g} of break-away", x * _MICRO, f / scale)
        for share, x, f in zip(shares.tolist(), run.x, friction, strict=True)
    )
    title = "presliding under slow sines below break-away"
    return Behaviour(title, "displacement [µm]", _FORCE, lines)


def _creep(name: str, given: dict[str, Any], scale: float) -> Behaviour:
    shares = np.array([0.25, 0.5, 0.75])
    run = simulate(law=name, drive_force=shares * scale, duration=2.0,
                   time_step=_FINE, **given)  # fmt: skip
    lines = [
        (f"load of {share:g} of the Coulomb level", run.t, x * _MILLI)
        for share, x in zip(shares.tolist(), run.x, strict=True)
    ]
    lines.append(("a dry law holds all three", run.t, np.zeros_like(run.t)))
    return Behaviour("creep below break-away", "time [s]", "displacement [mm]", tuple(lines))


def _load(name: str, given: dict[str, Any], scale: float) -> Behaviour:
    # From rest and so briefly that the viscous part stays nought.
    force = scale * np.linspace(1.0, 5.0, 81)
    run = simulate(law=name, drive_force=force, duration=1e-6, samples=2, **given)
    friction = force - run.fixed["mass"] * run.v[:, -1] / run.t[-1]
    moved = run.v[:, -1] > 0
    lines = (
        ("held at rest", force[~moved] / scale, friction[~moved] / scale),
        ("sliding begins", force[moved] / scale, friction[moved] / scale),
    )
    return Behaviour(
        "friction rises with the force of the drive",
        "drive force over Coulomb level",
        _FORCE,
        lines,
    )


def _steady(run_x: Floats, run_v: Floats, force: Floats, mass: float) -> tuple[Floats, Floats]:
    """Mean friction between samples, from work and kinetic energy: exact at jumps."""
    step = np.diff(run_x)
    work = (force[1:] + force[:-1]) / 2 * step
    # Around a turn the step is too short to divide by.
    far = np.abs(step) > 1e-3 * np.abs(step).max()
    friction = np.full_like(step, np.nan)
    friction[far] = (work - mass * np.diff(run_v**2) / 2)[far] / step[far]
    return (run_x[1:] + run_x[:-1]) / 2, friction


def _along(name: str, given: dict[str, Any], scale: float) -> Behaviour:
    # Seen without the viscous part, whose change with speed would hide the track.
    given = given | {"viscous": 0.0}
    keys = ("ripple_length", "track_length", "patch_start", "patch_length")
    length = {key: given.get(key, parameter(key).default or 0.0) for key in keys}
    span = {"ripple": 2 * length["ripple_length"], "track": 1.5 * length["track_length"]}.get(
        name, length["patch_start"] + 2 * length["patch_length"]
    )
    force = 3.0 * scale
    mass = given.get("mass", parameter("mass").default or 1.0)
    duration = float(np.sqrt(2 * span * mass / (force - scale)))
    run = simulate(law=name, drive_force=force, duration=duration, samples=4001,
                   time_step=duration / 2e4, **given)  # fmt: skip
    x, friction = _steady(run.x, run.v, run.force, run.fixed["mass"])
    lines = (("", x * _MILLI, friction / scale),)
    return Behaviour(
        "friction along the track, viscous part left out", "position [mm]", _FORCE, lines
    )


def _heap(name: str, given: dict[str, Any], scale: float) -> Behaviour:
    run = simulate(law=name, drive="sine", drive_amplitude=2.5 * scale, drive_frequency=2.0,
                   duration=1.2, samples=2401, **given)  # fmt: skip
    x, friction = _steady(run.x, run.v, run.force, run.fixed["mass"])
    lines = (("", x * _MILLI, friction / scale),)
    return Behaviour("forward and back under a sine", "position [mm]", _FORCE, lines)


def _pulled(name: str, given: dict[str, Any], scale: float) -> Behaviour:
    stiffness, speed = 60.0 * scale, 0.02
    run = simulate(law=name, spring_stiffness=stiffness, pull_speed=speed, duration=4.0,
                   samples=2001, **given)  # fmt: skip
    return Behaviour(
        f"pulled by a spring whose end moves at {speed * _MILLI:g} mm/s",
        "time [s]",
        "spring force over Coulomb level",
        (("", run.t, run.force / scale),),
    )
