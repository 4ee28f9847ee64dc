"""Friction laws and drives from their formulas, in plain Python: a reference.

Nothing here shares code with the engine: the formulas are those that
``locosweep.laws()`` and ``locosweep.drives()`` print.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from math import cos, exp, pi, sin, sqrt, tanh
from typing import TYPE_CHECKING, Any

import locosweep as ls

if TYPE_CHECKING:
    import random

Given = dict[str, Any]
Force = Callable[[float], float]

DEFAULTS = {p.name: p.default for p in ls.parameters() if p.default is not None}
KINDS = {law.name: law.kind for law in ls.laws()}
DRY = ("stribeck", "tustin", "quadratic", "power_drag", "hess_soom", "ripple", "buildup", "mixed")
SMOOTH = ("tanh", "threlfall", "bengisu_akay", "brown_mcphee", "simscape")
BRISTLE = ("lugre", "dahl", "elasto_plastic", "gonthier", "maxwell_slip")


@dataclass
class Plant:
    """One segment: its parameters, and the forces that follow from them."""

    law: str
    drive: str
    given: Given
    table: tuple[list[float], list[float]] | None = None

    def __post_init__(self) -> None:
        p: dict[str, float] = {**DEFAULTS, **self.given}
        self.p = p
        weight = p["mass"] * p["gravity"]
        self.weight = weight * sin(math.radians(p["slope_deg"]))
        normal = weight * cos(math.radians(p["slope_deg"])) + p["wall_force"]
        self.sliding = p.get("mu_coulomb", 0.0) * normal
        self.static = p.get("mu_static", p.get("mu_coulomb", 0.0)) * normal

    def pieces(self) -> list[tuple[float, Force]]:
        """Ends of the drive's smooth pieces and the force within each."""
        p, end = self.p, self.p["duration"]
        offset, size = p["drive_force"], p["drive_amplitude"]
        turn, phase = 2 * pi * p["drive_frequency"], math.radians(p["drive_phase_deg"])
        out: list[tuple[float, Force]] = []
        if self.drive == "constant":
            out.append((end, lambda _: offset))
        elif self.drive == "sine":
            out.append((end, lambda t: offset + size * sin(turn * t + phase)))
        elif self.drive == "multisine":
            count = int(p["drive_harmonics"])
            rms = size * sqrt(2 / count)
            parts = [(j * turn, phase - pi * j * (j - 1) / count) for j in range(1, count + 1)]
            out.append((end, lambda t: offset + rms * sum(sin(w * t + b) for w, b in parts)))
        elif self.drive == "chirp":
            grow = pi * (p["drive_frequency_end"] - p["drive_frequency"]) / end
            out.append((end, lambda t: offset + size * sin((turn + grow * t) * t + phase)))
        elif self.drive == "ramp":
            rate, sign = p["drive_rate"], math.copysign(1.0, size)
            top, rise = abs(size), abs(size) / p["drive_rate"]
            down = rise + p["drive_hold"]
            out.append((rise, lambda t: offset + sign * rate * t))
            out.append((down, lambda _: offset + sign * top))
            out.append((down + rise, lambda t: offset + sign * (top - rate * (t - down))))
            out.append((end, lambda _: offset))
        else:
            raise AssertionError(self.drive)
        return [(min(until, end), self.limited(force)) for until, force in out]

    def limited(self, force: Force) -> Force:
        limit = self.p["drive_limit"]
        if math.isinf(limit):
            return force
        return lambda t: max(-limit, min(limit, force(t)))

    def pull(self, t: float, x: float, v: float) -> float:
        """Force of the spring."""
        p = self.p
        stretch = p["pull_speed"] * t - x
        return p["spring_stiffness"] * stretch + p["spring_damping"] * (p["pull_speed"] - v)

    def dry(self, speed: float, way: int, x: float, swept: float, drive: float) -> float:
        """Resistance at a speed counted along `way`."""
        p, law = self.p, self.law
        film, drop = p["viscous"] * speed, self.static - self.sliding
        u = max(speed, 0.0) / p["stribeck_speed"]
        if law == "stribeck":
            return self.sliding + drop * exp(-u * u) + film
        if law == "tustin":
            return self.sliding + drop * exp(-u) + film
        if law == "bo_pavelescu":
            return self.sliding + drop * exp(-(u ** p["stribeck_exponent"])) + film
        if law == "hess_soom":
            return self.sliding + drop / (1 + u * u) + film
        if law == "modelica":
            return self.sliding + drop * exp(-p["modelica_decay"] * max(speed, 0.0)) + film
        if law == "quadratic":
            return self.sliding + p["quadratic"] * speed * abs(speed) + film
        if law == "power_drag":
            drag: float = max(speed, 0.0) ** p["power_exponent"]
            return self.sliding + p["power_drag"] * drag
        if law == "ripple":
            return self.sliding * self.wave(x) + film
        if law == "buildup":
            heap = p["buildup"] * swept + p["buildup_root"] * sqrt(max(swept, 0.0))
            heap += p["snowplough"] * speed * abs(speed)
            return self.sliding + film + (heap if way > 0 else 0.0)
        if law == "mixed":
            dry = exp(-((max(speed, 0.0) / p["mixed_speed"]) ** p["mixed_exponent"]))
            return self.static * dry + (1 - dry) * film
        if law == "directional":
            return self.sliding * (p["skin_ratio"] if way < 0 else 1.0) + film
        if law == "load_friction":
            return self.sliding + p["load_friction"] * abs(drive) + film
        assert law in ("coulomb", "coulomb_viscous", "static_coulomb", "static_viscous")
        return self.sliding + (film if law.endswith("viscous") else 0.0)

    def wave(self, x: float) -> float:
        p = self.p
        phase = math.radians(p["ripple_phase_deg"])
        return 1 + p["ripple_amplitude"] * sin(2 * pi * x / p["ripple_length"] + phase)

    def holds(self, way: int, x: float, drive: float) -> float:
        """The largest push in direction `way` that does not start motion."""
        level = self.static
        if self.law in ("coulomb", "coulomb_viscous", "quadratic", "power_drag", "buildup"):
            level = self.sliding
        if self.law == "ripple":
            level *= self.wave(x)
        if self.law == "directional" and way < 0:
            level *= self.p["skin_ratio"]
        if self.law == "load_friction":
            level += self.p["load_friction"] * abs(drive)
        return max(level, self.dry(0.0, way, x, 0.0, drive))

    def smooth(self, v: float) -> float:
        p, law = self.p, self.law
        film, drop, u = p["viscous"] * v, self.static - self.sliding, v / p["transition_speed"]
        sign, size = math.copysign(1.0, v), abs(v)
        if law == "tanh":
            return (self.sliding + drop * exp(-((v / p["stribeck_speed"]) ** 2))) * tanh(u) + film
        if law == "threlfall":
            return -self.sliding * math.expm1(-3 * min(abs(u), 1.0)) * sign + film
        if law == "bengisu_akay":
            if abs(u) <= 1:
                return self.static * (1 - (abs(u) - 1) ** 2) * sign + film
            fall = exp(-(size - p["transition_speed"]) / p["stribeck_speed"])
            return (self.sliding + drop * fall) * sign + film
        if law == "brown_mcphee":
            return self.sliding * tanh(4 * u) + drop * u / (u * u / 4 + 0.75) ** 2 + film
        assert law == "simscape"
        peak = v / (sqrt(2) * p["transition_speed"])
        bump = sqrt(2 * math.e) * drop * exp(-peak * peak) * peak
        return bump + self.sliding * tanh(10 * u) + film

    def bristle(self, v: float, z: list[float]) -> tuple[float, list[float]]:
        """Force against the motion, and the rates of the states."""
        p, law = self.p, self.law
        stiff, film = p["bristle_stiffness"], p["viscous"] * v
        drop, sign = self.static - self.sliding, math.copysign(1.0, v)
        if law == "dahl":
            margin = 1 - stiff * z[0] / self.sliding * sign
            rate = v * abs(margin) ** p["dahl_exponent"] * math.copysign(1.0, margin)
            return stiff * z[0] + film, [rate]
        bell = exp(-((v / p["stribeck_speed"]) ** 2))
        level = self.sliding + drop * bell
        if law == "maxwell_slip":
            return self.elements(v, z, level)
        damping = p["bristle_damping"]
        if law == "gonthier":
            stuck = bell * (stiff * z[0] + damping * v) + (1 - bell) * self.sliding * sign
            cap = self.sliding + drop * z[1]
            force = max(-cap, min(cap, stuck))
            pace = stiff / damping if bell < z[1] else 1 / p["dwell_time"]
            return force + film, [(force - stiff * z[0]) / damping, (bell - z[1]) * pace]
        share = 1.0
        if law == "elasto_plastic":
            end, elastic = (
                level / stiff,
                p["elastic_share"] * min(self.sliding, self.static) / stiff,
            )
            size = abs(z[0])
            if z[0] * v < 0 or size <= elastic:
                share = 0.0
            elif size < end:
                share = 0.5 * (1 + sin(pi * (size - (end + elastic) / 2) / (end - elastic)))
        rate = v - share * abs(v) * stiff / level * z[0]
        return stiff * z[0] + damping * exp(-((v / p["damping_speed"]) ** 2)) * rate + film, [rate]

    def elements(self, v: float, z: list[float], level: float) -> tuple[float, list[float]]:
        p, sign = self.p, math.copysign(1.0, v)
        parts = [p["stiffness_spread"] ** i for i in range(4)]
        springs = [p["bristle_stiffness"] * part / sum(parts) for part in parts]
        rates = []
        for k, bent in zip(springs, z, strict=True):
            load = 4 * k * bent / level * sign
            bends = min(1.0, max(0.0, (1 - load) / (1 - p["elastic_share"])))
            back = p["attraction"] / (4 * k) * max(load - 1, 0.0) * sign
            rates.append(v * bends - back)
        return sum(k * bent for k, bent in zip(springs, z, strict=True)) + p["viscous"] * v, rates


def random_plant(rng: random.Random, law: str) -> Plant:
    """A segment of 0.5 to 2 kg on ground where friction is a few newtons, driven
    so that it stops, rests and breaks away several times.
    """
    own = {p.name for entry in ls.laws() if entry.name == law for p in entry.parameters}
    gravity, mass = rng.uniform(5, 12), rng.uniform(0.5, 2.0)
    coulomb = rng.uniform(0.1, 0.4)
    static = coulomb * rng.uniform(1.05, 1.6)
    options = {
        "mu_coulomb": coulomb,
        "mu_static": static,
        "viscous": rng.choice((0.0, rng.uniform(0.1, 2.0))),
        "stribeck_speed": rng.uniform(0.05, 0.4),
        "stribeck_exponent": rng.choice((1.0, 2.0)),
        "modelica_decay": rng.uniform(2.0, 20.0),
        "quadratic": rng.uniform(0.0, 2.0),
        "power_drag": rng.uniform(0.0, 2.0),
        "power_exponent": rng.choice((1.0, 2.0, 1.75, 3.0)),
        "ripple_amplitude": rng.uniform(0.1, 0.6),
        "ripple_length": rng.uniform(0.03, 0.3),
        "ripple_phase_deg": rng.uniform(-180, 180),
        "buildup": rng.uniform(0.0, 20.0),
        "buildup_root": 0.0,
        "snowplough": rng.uniform(0.0, 2.0),
        "mixed_speed": rng.uniform(0.05, 0.5),
        "mixed_exponent": rng.choice((1.0, 2.0)),
        "skin_ratio": rng.uniform(0.5, 2.5),
        "load_friction": rng.uniform(0.0, 0.3),
        "transition_speed": rng.uniform(0.02, 0.1),
        "bristle_stiffness": rng.uniform(1e3, 2e4),
        "bristle_damping": rng.uniform(10.0, 60.0),
        "damping_speed": rng.choice((0.2, math.inf)),
        "elastic_share": rng.uniform(0.4, 0.8),
        "stiffness_spread": rng.uniform(1.0, 3.0),
        "attraction": rng.uniform(20.0, 200.0),
        "dwell_time": rng.uniform(0.02, 0.2),
        "dahl_exponent": 1.0,
    }
    given = {name: options[name] for name in own}
    weight = mass * gravity
    given |= {"mass": mass, "gravity": gravity, "duration": rng.uniform(0.5, 1.2)}
    given["slope_deg"] = rng.choice((0.0, rng.uniform(-8, 8)))
    given["start_speed"] = rng.choice((0.0, rng.uniform(-0.5, 0.5)))
    drive = rng.choice(("sine", "sine", "chirp", "ramp", "multisine"))
    given["drive_amplitude"] = weight * static * rng.uniform(1.1, 2.5) * rng.choice((-1, 1))
    given["drive_force"] = weight * static * rng.choice((0.0, rng.uniform(-0.5, 0.5)))
    if drive == "multisine":
        given["drive_amplitude"] *= 0.7
        given["drive_harmonics"] = float(rng.randint(2, 5))
    if drive == "ramp":
        given["drive_rate"] = abs(given["drive_amplitude"]) * rng.uniform(2.5, 6.0)
        given["drive_hold"] = rng.uniform(0.0, 0.2)
    else:
        given["drive_frequency"] = rng.uniform(0.8, 2.5)
        given["drive_phase_deg"] = rng.uniform(-180, 180)
    if drive == "chirp":
        given["drive_frequency_end"] = rng.uniform(2.0, 5.0)
    if rng.random() < 0.3:
        given["spring_stiffness"] = rng.uniform(5.0, 100.0)
        given["spring_damping"] = rng.choice((0.0, rng.uniform(0.0, 2.0)))
        given["pull_speed"] = rng.choice((0.0, rng.uniform(-0.3, 0.3)))
    return Plant(law, drive, given)
