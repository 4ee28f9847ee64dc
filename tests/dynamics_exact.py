"""Motion of one segment from event to event in many digits: a reference.

Written from the equation of motion m v' = F - R - m g sin(alpha) alone. Between
events the drive is constant and friction is level + b v, so that v decays to its
limit; a stop is where it passes zero, and a segment at rest moves when the push
exceeds what friction holds.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import mpmath as mp

import locosweep as ls

if TYPE_CHECKING:
    from collections.abc import Callable

DIGITS = 50
# Damping of 1e-12 cancels some forty digits in the textbook forms used here.
WORK_DIGITS = 110
EPS = 2.0**-52
ZERO = mp.mpf(0)

LINEAR_LAWS = (
    "coulomb",
    "coulomb_viscous",
    "static_coulomb",
    "static_viscous",
    "load_friction",
    "load_viscous",
    "directional",
)
OUTPUTS = (
    "final_position",
    "final_speed",
    "peak_position",
    "peak_motion",
    "average_velocity",
    "stroke_time",
    "stuck_time",
    "stick_phases",
    "work_in",
    "dissipated",
    "stored",
)
DEFAULTS = {p.name: p.default for p in ls.parameters() if p.default is not None}

Numbers = dict[str, mp.mpf]


@dataclass
class Case:
    """What a sweep is given."""

    law: str
    drive: str
    given: dict[str, Any]
    table: tuple[list[float], list[float]] | None = None

    def found(self) -> dict[str, float]:
        """Outputs of the engine, and its energy residual."""
        names = (*OUTPUTS, "energy_residual")
        result = ls.sweep(names, law=self.law, drive=self.drive, table=self.table, **self.given)
        return {name: float(result[name]) for name in names}

    def expected(self, shake: random.Random | None = None) -> tuple[Numbers, Numbers]:
        """Outputs of the reference; with `shake` every input is off by up to one
        rounding, which shows how far the exact answer itself then moves.
        """

        def near(value: float) -> mp.mpf:
            return mp.mpf(value) * (1 + EPS * shake.uniform(-1, 1) if shake else 1)

        with mp.workdps(WORK_DIGITS):
            values = {name: near(value) for name, value in {**DEFAULTS, **self.given}.items()}
            times, levels = self.table or ([], [])
            samples = ([near(t) for t in times], [near(u) for u in levels])
            return Motion(self.law, self.drive, values, samples).outputs()


@dataclass
class Motion:
    """One exact trajectory."""

    law: str
    drive: str
    p: Numbers
    table: tuple[list[mp.mpf], list[mp.mpf]]
    t: mp.mpf = ZERO
    way: int = 0
    stuck: mp.mpf = ZERO
    sticks: int = 0
    work: mp.mpf = ZERO
    heat: mp.mpf = ZERO
    stroke: mp.mpf | None = None
    ends: list[tuple[mp.mpf, mp.mpf]] = field(default_factory=list)

    def __post_init__(self) -> None:
        p = self.p
        angle, half = mp.radians(p["slope_deg"]), mp.radians(p["corner_deg"])
        weight = p["mass"] * p["gravity"]
        self.weight = weight * mp.sin(angle)
        self.normal = weight * mp.cos(angle) / mp.cos(half) + p["wall_force"]
        self.x, self.v = p["start_position"], p["start_speed"]

    def friction(self, way: int, drive: mp.mpf) -> tuple[mp.mpf, mp.mpf, mp.mpf]:
        """Level and viscous coefficient in motion, and what holds at rest."""
        p, law = self.p, self.law
        level = p["mu_coulomb"] * self.normal
        hold = p.get("mu_static", ZERO) * self.normal
        viscous = p["viscous"]
        if law in ("coulomb", "static_coulomb"):
            viscous = ZERO
        if law in ("coulomb", "coulomb_viscous", "load_viscous"):
            hold = level
        if law == "load_viscous":
            viscous += p["viscous_load"] * self.normal ** p["load_exponent"]
        if law == "load_friction":
            level, hold = (f + p["load_friction"] * abs(drive) for f in (level, hold))
        if law == "directional" and way < 0:
            level, hold = level * p["skin_ratio"], hold * p["skin_ratio"]
        return level, viscous, max(hold, level)

    def pieces(self) -> list[tuple[mp.mpf, mp.mpf]]:
        """Ends and forces of the drive's pieces, up to the end of the run."""
        p, end = self.p, self.p["duration"]
        out: list[tuple[mp.mpf, mp.mpf]] = []
        if self.drive == "constant":
            out.append((end, p["drive_force"]))
        elif self.drive == "pulse":
            count = 0
            while not out or out[-1][0] < end:
                start = count * p["drive_period"]
                forward = p["drive_force"] + p["drive_amplitude"]
                back = p["drive_force"] - p["drive_back"]
                out.append((start + p["drive_duty"] * p["drive_period"], forward))
                out.append((start + p["drive_period"], back))
                count += 1
        else:
            times, values = self.table
            for until, value in zip([*times[1:], mp.inf], values, strict=True):
                out.append((until, p["drive_force"] + p["gain"] * value))
        limit = p["drive_limit"]
        return [(min(until, end), max(-limit, min(limit, force))) for until, force in out]

    def leg(self, drive: mp.mpf, until: mp.mpf) -> None:
        """Slide until the piece ends or the speed is zero."""
        level, viscous, _ = self.friction(self.way, drive)
        mass, v, span = self.p["mass"], self.v, until - self.t
        pull, rate = (drive - self.weight - self.way * level) / mass, viscous / mass

        def fade(t: mp.mpf, rate: mp.mpf = rate) -> mp.mpf:
            return t if rate == 0 else -mp.expm1(-rate * t) / rate

        def speed(t: mp.mpf) -> mp.mpf:
            return v + (pull - rate * v) * fade(t)

        def path(t: mp.mpf) -> mp.mpf:
            if rate == 0:
                return v * t + pull * t * t / 2
            return v * fade(t) + pull / rate * (t - fade(t))

        stops = self.way * speed(span) < 0
        if stops:
            brake = -v / pull
            span = mp.log1p(rate * brake) / rate if rate else brake
        gone, after = path(span), ZERO if stops else speed(span)
        target = self.p["start_position"] + self.p["stroke"]
        if self.stroke is None and self.x < target <= self.x + gone:
            self.stroke = self.t + arrival(path, speed, target - self.x, span)
        self.work += drive * gone
        self.heat += level * abs(gone)
        if rate:
            top = pull / rate
            gap = v - top
            squares = top**2 * span + 2 * top * gap * fade(span) + gap**2 * fade(span, 2 * rate)
            self.heat += viscous * squares
        self.x, self.v, self.t = self.x + gone, after, self.t + span
        self.ends.append((self.x, abs(self.v)))
        if stops:
            self.way = self.release(drive)
            self.sticks += self.way == 0

    def release(self, drive: mp.mpf) -> int:
        """Direction in which what is at rest moves; 0 where friction holds it."""
        push = drive - self.weight
        way = int(mp.sign(push))
        return way if abs(push) > self.friction(way, drive)[2] else 0

    def outputs(self) -> tuple[Numbers, Numbers]:
        """Values, and the terms whose cancellation any run must suffer: it holds
        places, not distances, and gains of energy as differences.
        """
        p = self.p
        self.way = int(mp.sign(self.v))
        self.ends.append((self.x, abs(self.v)))
        for until, drive in self.pieces():
            if self.t < until and self.way == 0:
                self.way = self.release(drive)
            while self.t < until and self.way != 0:
                self.leg(drive, until)
            if self.t < until:
                self.stuck += until - self.t
                self.t = until
        moved = self.x - p["start_position"]
        before, after = (p["mass"] * v**2 / 2 for v in (p["start_speed"], self.v))
        far = abs(self.x) + abs(p["start_position"])
        terms = {
            "average_velocity": far / p["duration"],
            "stored": before + after + abs(self.weight) * far,
        }
        values = {
            "final_position": self.x,
            "final_speed": self.v,
            "peak_position": max(x for x, _ in self.ends),
            "peak_motion": max(v for _, v in self.ends),
            "average_velocity": moved / p["duration"],
            "stroke_time": mp.nan if self.stroke is None else self.stroke,
            "stuck_time": self.stuck,
            "stick_phases": mp.mpf(self.sticks),
            "work_in": self.work,
            "dissipated": self.heat,
            "stored": after - before + self.weight * moved,
        }
        return values, terms


def arrival(
    path: Callable[[mp.mpf], mp.mpf],
    speed: Callable[[mp.mpf], mp.mpf],
    distance: mp.mpf,
    span: mp.mpf,
) -> mp.mpf:
    """When a path that rises up to `span` has covered a distance."""
    low, high, t = ZERO, span, span / 2
    for _ in range(400):
        miss = path(t) - distance
        low, high = (t, high) if miss < 0 else (low, t)
        slope = speed(t)
        step = t - miss / slope if slope else low
        new = step if low < step < high else (low + high) / 2
        if abs(new - t) <= span * mp.mpf(10) ** -DIGITS:
            return new
        t = new
    raise AssertionError("no arrival")


def log_uniform(rng: random.Random, low: float, high: float) -> float:
    return float(10 ** rng.uniform(mp.log10(low), mp.log10(high)))


def random_case(rng: random.Random) -> Case:
    """From all corners: no damping to huge, no friction to locked, steep slopes."""
    law = rng.choice(LINEAR_LAWS)
    drive = rng.choice(("constant", "pulse", "pulse", "table", "table"))
    mass, gravity = log_uniform(rng, 1e-2, 1e2), log_uniform(rng, 1e-1, 1e2)
    weight = mass * gravity
    coulomb = rng.choice((0.0, rng.uniform(0.02, 1.0), rng.uniform(0.02, 0.5)))
    given: dict[str, Any] = {
        "mass": mass,
        "gravity": gravity,
        "mu_coulomb": coulomb,
        "slope_deg": rng.choice((0.0, 0.0, rng.uniform(-60, 60), rng.uniform(-2, 2))),
        "stroke": log_uniform(rng, 1e-3, 1.0) * gravity,
        "duration": log_uniform(rng, 0.3, 5.0),
        "start_speed": rng.choice((0.0, rng.uniform(-1, 1))) * gravity,
        "start_position": rng.choice((0.0, rng.uniform(-2, 2))),
    }
    if law not in ("coulomb", "static_coulomb"):
        small, wide = log_uniform(rng, 1e-9, 1e-2), log_uniform(rng, 1e-2, 1e1)
        huge = log_uniform(rng, 1e1, 1e5)
        given["viscous"] = rng.choice((0.0, 1e-12, small, wide, wide, huge)) * mass
    if law in ("static_coulomb", "static_viscous", "load_friction", "directional"):
        given["mu_static"] = coulomb * rng.choice((0.5, 1.0, rng.uniform(1.0, 2.0)))
    if law == "load_friction":
        given["load_friction"] = rng.uniform(0.0, 0.9)
    if law == "load_viscous":
        given["viscous_load"] = log_uniform(rng, 1e-6, 1e2)
        given["load_exponent"] = rng.uniform(0.2, 2.5)
    if law == "directional":
        given["skin_ratio"] = log_uniform(rng, 0.2, 5.0)
    if rng.random() < 0.2:
        given["wall_force"] = rng.uniform(0.0, 1.0) * weight
    if rng.random() < 0.2:
        given["drive_limit"] = rng.uniform(0.2, 1.5) * weight
    # Forces near what friction holds: then there are stops, rests and turns.
    size = weight * (coulomb or 0.3)
    given["drive_force"] = rng.choice((0.0, rng.uniform(-1.5, 1.5))) * size
    table = None
    if drive != "constant":
        name = "gain" if drive == "table" else "drive_amplitude"
        given[name] = rng.uniform(0.5, 4.0) * rng.choice((-1, 1)) * size
    if drive == "pulse":
        given["drive_back"] = rng.uniform(-0.3, 1.3) * given["drive_amplitude"]
        given["drive_period"] = given["duration"] * rng.uniform(0.05, 1.2)
        given["drive_duty"] = rng.choice((0.0, 1.0, *(rng.uniform(0.2, 0.8) for _ in range(6))))
    if drive == "table":
        count = rng.randint(1, 12)
        times = sorted(rng.uniform(0.0, 1.1) * given["duration"] for _ in range(count))
        table = (times, [rng.uniform(-1.5, 1.5) for _ in range(count)])
    return Case(law, drive, given, table)
