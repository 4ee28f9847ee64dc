"""Robots and test benches, their sensors, and what is known of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from locosweep.files.channels import CHANNELS

if TYPE_CHECKING:
    from numpy.random import Generator


def log_uniform(rng: Generator, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def rounded(value: float, digits: int = 3) -> float:
    """Round to significant digits, as numbers stand in a file."""
    return float(f"{value:.{digits}g}")


@dataclass(frozen=True)
class Sensors:
    """Noise and steps of the sensors, SI; `position_*` are those of x and x_rear.

    `channels` are measured beside x; the nominal file gives the numbers named in `stated`.
    """

    position_noise: float
    position_resolution: float
    force_noise: float = 0.0
    velocity_noise: float = 0.0
    power_noise: float = 0.0
    channels: tuple[str, ...] = ()
    stated: tuple[str, ...] = ()

    def deviation(self, channel: str) -> float:
        """Return the standard deviation of a channel, rounding included."""
        step = self.position_resolution if CHANNELS[channel].sensor == "position" else 0.0
        return float(np.hypot(self.noise(channel), step / np.sqrt(12.0)))

    def noise(self, channel: str) -> float:
        """Return the standard deviation of a channel before it is rounded."""
        return float(getattr(self, f"{CHANNELS[channel].sensor}_noise"))


@dataclass(frozen=True)
class Rig:
    """A rig as its nominal file describes it.

    Attributes
    ----------
    nominal : dict of str to float
        Keys that the reality takes; ``gravity_torque`` makes it a rotary bench.
    linear_bench : bool
        A bench that is not a robot.
    uncertainty : dict of str to float
        Standard deviations of mass, mu_coulomb and gain (relative) and clock (s).
    motor : dict of str to float
        Supply voltage, resistance and force constant, where power is measured.
    """

    nominal: dict[str, float]
    linear_bench: bool = False
    uncertainty: dict[str, float] = field(default_factory=dict)
    motor: dict[str, float] = field(default_factory=dict)

    @property
    def rotary(self) -> bool:
        """True on a bench where x is an angle."""
        return "gravity_torque" in self.nominal

    @property
    def level(self) -> float:
        """Coulomb level of the nominal file at the nominal slope, N or N m."""
        return self.true_level({})

    def true_level(self, shifts: dict[str, float]) -> float:
        """Return the level of what the rig really is, to which levels of effects refer."""
        n = self.true(shifts)
        if "coulomb_force" in n:
            return n["coulomb_force"]
        return (
            n["mu_coulomb"] * n["mass"] * n["gravity"] * float(np.cos(np.radians(n["slope_deg"])))
        )

    def true(self, shifts: dict[str, float]) -> dict[str, float]:
        """Return what the rig really is: `shifts` in standard deviations."""
        true = dict(self.nominal)
        for name, deviation in self.uncertainty.items():
            shift = deviation * shifts.get(name, 0.0)
            if name == "clock":
                true["clock"] = shift
            elif name == "mu_coulomb" and "coulomb_force" in true:
                true["coulomb_force"] *= 1.0 + shift
            else:
                true[name] *= 1.0 + shift
        return true


def _bench(rng: Generator) -> tuple[dict[str, float], bool]:
    """Numbers of a pendulum, a bench on rails or a robot; the latter most often."""
    kind = rng.choice(["rotary", "linear", "robot"], p=[0.1, 0.08, 0.82])
    common = {"gravity": 9.81, "viscous": 0.0, "slope_deg": 0.0, "gain": 1.0, "limit": np.inf}
    if rng.random() < 0.25:
        common["gain"] = rounded(log_uniform(rng, 0.2, 5.0))
    if kind == "rotary":
        torque = log_uniform(rng, 0.3, 5.0)
        return {
            **common,
            "segments": 1.0,
            "mass": rounded(torque / 9.81 * log_uniform(rng, 0.15, 0.8)),
            "coulomb_force": rounded(torque * log_uniform(rng, 0.02, 0.25)),
            "gravity_torque": rounded(torque),
        }, False
    mass = rounded(log_uniform(rng, 0.05, 5.0))
    mu = rounded(rng.uniform(0.05, 0.9), 2)
    if kind == "linear":
        force = rounded(mu * mass * 9.81)
        return {**common, "segments": 1.0, "mass": mass, "coulomb_force": force}, True
    rig = {**common, "segments": float(rng.integers(2, 9)), "mass": mass, "mu_coulomb": mu}
    if rng.random() < 0.25:
        steepest = min(8.0, np.degrees(np.arctan(0.6 * mu)))
        rig["slope_deg"] = round(float(rng.uniform(-steepest, steepest)), 1)
    return rig, False


def draw_rig(rng: Generator, *, exact: bool) -> Rig:
    """Draw a rig; `exact` leaves out the table of uncertainties."""
    nominal, linear_bench = _bench(rng)
    speed = log_uniform(rng, 0.05, 0.5)
    level = Rig(nominal).level
    if rng.random() < 0.3:
        nominal["viscous"] = rounded(level / speed * rng.uniform(0.02, 0.4), 2)
    uncertainty = {}
    # Drawn even if unused, so that what follows is the same.
    table, which = rng.random(), rng.random(4)
    sizes = [rng.uniform(0.005, 0.03), rng.uniform(0.01, 0.08), rng.uniform(0.005, 0.03)]
    clock = log_uniform(rng, 5e-4, 5e-3)
    if not exact and table < 0.15:
        names = ("mass", "mu_coulomb", "gain", "clock")
        for name, size, chance in zip(names, [*sizes, clock], which, strict=True):
            if chance < 0.75:
                uncertainty[name] = rounded(size, 2)
    motor = {}
    if rng.random() < 0.06:
        constant = rounded(rng.uniform(0.8, 3.0), 2)
        motor = {"supply_voltage": 12.0, "resistance": 8.0, "force_constant": constant}
    return Rig(nominal, linear_bench, uncertainty, motor)


def draw_sensors(rng: Generator, rig: Rig, travel: float, speed: float, force: float) -> Sensors:
    """Draw sensors that suit the motion: typical travel, speed and drive force."""
    noise = rounded(travel * log_uniform(rng, 1e-4, 8e-3), 2)
    resolution = rounded(noise * log_uniform(rng, 0.25, 2.5), 2)
    sets = [
        (),
        ("v",),
        ("force",),
        ("force", "v"),
        ("x_rear",),
        ("force", "x_rear"),
        ("force", "v", "x_rear"),
    ]
    channels = sets[rng.choice(len(sets), p=[0.5, 0.1, 0.16, 0.06, 0.08, 0.06, 0.04])]
    if rig.rotary or rig.linear_bench:
        channels = tuple(c for c in channels if c != "x_rear")
    sizes = [force * log_uniform(rng, 2e-3, 2e-2), speed * log_uniform(rng, 3e-3, 3e-2)]
    power = force * speed * log_uniform(rng, 5e-3, 5e-2)
    if rig.motor:
        channels = (*channels, "power")
    stated: tuple[str, ...] = (
        "position_noise",
        "position_resolution",
        "force_noise",
        "velocity_noise",
        "power_noise",
    )
    silent = rng.random()
    if silent < 0.05:
        stated = ()
    elif silent < 0.2:
        stated = stated[:3]
    return Sensors(
        noise,
        resolution,
        rounded(sizes[0], 2),
        rounded(sizes[1], 2),
        rounded(power, 2),
        channels,
        stated,
    )
