"""Cases of the blind check: a rig, its runs, and the reality that they are measured in.

Case `i` is the same whatever the number of cases.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.effects.catalogue import lacking
from locosweep.simulation.replay import effects
from locosweep.validation.case_truth import outside, over_background, pair, single
from locosweep.validation.drives import KINDS, draw_shape, sample_times
from locosweep.validation.experiment import COARSE, Drive, Experiment, World
from locosweep.validation.laws import (
    CAUSES,
    LAWS,
    OUTSIDE,
    Cause,
    Scale,
    draw_background,
    draw_cause,
)
from locosweep.validation.rigs import Rig, Sensors, draw_rig, draw_sensors, log_uniform
from locosweep.validation.sizes import Nuisances

if TYPE_CHECKING:
    from numpy.random import Generator
    from numpy.typing import NDArray

    from locosweep.validation.experiment import Effect

    Floats = NDArray[np.float64]

KINDS_OF_CASE = {"none": 0.25, "one": 0.45, "two": 0.15, "outside": 0.15}
"""Shares of the mixture."""
_MISMATCH = 1 / 3
"""Share of single effects with another functional form than the listed one."""
_MOST_SAMPLES = 16000
"""Largest number of samples of all runs of a case."""
_LEAST, _MOST = 0.8, 600.0
"""Sizes outside are drawn anew: an effect that sets in at once cannot be made small."""
_TRIES = 200
"""Draws until one can be seen, at most: far more than the 3 that the worst of 12 cases over a
background took (`--only background --seed 991`)."""
_FLOORS = (3.0, 100.0)
"""Error that a background alone makes, in deviations of a reading, about the 19 that the best
causes leave on a measured pendulum (docs/pendulum.md)."""
_TIMES = (3.0, 30.0)
"""Size of an effect's gap over that of its background."""
_FRESH = 3
"""Fresh runs that are drawn with a case, before its effects: with another number, the cases of all
seeds would be others."""
_MORE_FRESH = 9
"""Fresh runs that are drawn once a case can be seen. All twelve are more than any case has measured
runs (8): what a claim is held against has to be better known than the claim."""
_NO_SENSORS = Sensors(1.0, 1.0)
"""Sensors that do not matter yet."""


@dataclass(frozen=True)
class Case:
    """One case, before noise: runs for the diagnosis, fresh ones, their reality, the truth.

    `kind` is one of `KINDS_OF_CASE`; `check` are fresh runs of the same `world`.
    """

    kind: str
    experiment: Experiment
    check: Experiment
    world: World
    truth: dict[str, Any] = field(default_factory=dict)


def _excess(rig: Rig, slope_deg: float, sign: float) -> float:
    """Return the drive force that just moves the head from rest in a direction."""
    n = rig.nominal
    if rig.rotary:
        return rig.level
    alpha = np.radians(slope_deg)
    weight = n["mass"] * n["gravity"]
    level = n.get("coulomb_force", n.get("mu_coulomb", 0.0) * weight * np.cos(alpha))
    return float(level + sign * weight * np.sin(alpha))


def _sized(
    rig: Rig, shape: Floats, t: Floats, slope_deg: float, sign: float, travel: float
) -> Floats:
    """Scale a command such that the head travels about so far, back and forth."""
    least = max(_excess(rig, slope_deg, sign), 0.1 * rig.level) / rig.nominal["gain"]
    low, high = 1.0, 8.0
    if rig.rotary:
        high += 3.0 * rig.nominal["gravity_torque"] / rig.level
    sizes = np.geomspace(low * 1.02, high, 14)
    drives = [Drive(t, sign * least * size * shape, slope_deg, (0.0, 0.0), 0) for size in sizes]
    read = Experiment(rig, tuple(drives), _NO_SENSORS).read([World()], 5e-4, 1)[0]
    paths = np.array([np.abs(np.diff(run["x"])).sum() for run in read])
    logs = np.log(np.maximum.accumulate(paths) + 1e-9)
    size = float(np.exp(np.interp(np.log(travel), logs, np.log(sizes))))
    command: Floats = sign * least * size * shape
    return command


def _round_command(command: Floats) -> Floats:
    step = 10.0 ** np.floor(np.log10(max(np.abs(command).max(), 1e-6)) - 3)
    whole: Floats = np.round(np.round(command / step) * step, 12)
    return whole


def _drives(rng: Generator, rig: Rig, count: int, plan: dict[str, Any]) -> list[Drive]:
    """Draw the runs of one session."""
    drives: list[Drive] = []
    kinds = rng.permutation(np.array(KINDS)).tolist()
    for i in range(count):
        duration = plan["duration"] * rng.uniform(0.8, 1.2)
        t = sample_times(rng, plan["rate"], duration, jitter=plan["jitter"])
        one_way = plan["mode"] == "forward" or (plan["mode"] == "mixed" and rng.random() < 0.5)
        shape = draw_shape(rng, kinds[i % len(kinds)], t, one_way=one_way)
        slope = rig.nominal["slope_deg"]
        if plan["slopes"]:
            most = min(10.0, np.degrees(np.arctan(0.6 * rig.nominal["mu_coulomb"])))
            slope = round(float(rng.uniform(-most, most)), 1)
        travel = plan["travel"] * log_uniform(rng, 0.4, 2.5)
        turned = plan["mode"] == "mixed" and one_way and rng.random() < 0.3
        command = _round_command(_sized(rig, shape, t, slope, -1.0 if turned else 1.0, travel))
        speed = 0.0
        if plan["starts_moving"]:
            speed = float(rng.normal(0.0, 0.2)) * travel / duration * 4.0
            speed = abs(speed) if plan["mode"] == "forward" else speed
        start = (float(rng.uniform(-0.5, 0.5)) * plan["offset"], speed)
        seed = int(rng.integers(2**53))
        drives.append(Drive(t, command, slope, start, seed, plan["slopes"]))
    if plan["repeats"] and count > 2:
        # The same command once more: what differs then is noise.
        drives[-1] = replace(drives[0], seed=drives[-1].seed)
    return drives


def _plan(rng: Generator, rig: Rig) -> dict[str, Any]:
    count = int(rng.integers(3, 9))
    duration = float(rng.uniform(2.0, 8.0))
    rate = float(rng.choice([50, 100, 125, 200, 250, 400, 500, 1000]))
    while rate * duration * count > _MOST_SAMPLES and rate > 50:
        rate /= 2
    travel = log_uniform(rng, 0.15, 2.0) if rig.rotary else log_uniform(rng, 0.015, 0.4)
    chances = rng.random(5)
    return {
        "count": count,
        "duration": duration,
        "rate": rate,
        "jitter": bool(chances[0] < 0.25),
        "mode": str(rng.choice(["forward", "both", "mixed"], p=[0.3, 0.35, 0.35])),
        "slopes": bool(chances[1] < 0.15 and "mu_coulomb" in rig.nominal),
        "repeats": bool(chances[2] < 0.25),
        "starts_moving": bool(chances[3] < 0.12),
        "offset": travel if chances[4] < 0.4 and not rig.rotary else 0.0,
        "travel": travel,
    }


def scale_of_runs(experiment: Experiment, shifts: dict[str, float] | None = None) -> Scale:
    """Read the scale of a rig off its nominal runs; the level is that of a rig with `shifts`."""
    rig = experiment.rig
    n = rig.nominal
    read = experiment.read([World()], COARSE, 1)[0]
    weight = (n["segments"] - 1.0) * n["mass"] * n["gravity"]
    return Scale(
        level=rig.true_level(shifts or {}),
        force=float(max(np.abs(d.command).max() for d in experiment.drives) * n["gain"]),
        mass=n["mass"],
        grip=weight * float(np.cos(np.radians(n["slope_deg"]))),
        speed=float(max(np.abs(r["v"]).max() for r in read)),
        travel=float(np.median([np.ptp(r["x"]) for r in read])),
        low=float(min(r["x"].min() for r in read)),
        high=float(max(r["x"].max() for r in read)),
        duration=float(np.mean([d.t[-1] for d in experiment.drives])),
        mu=n.get("mu_coulomb", float("nan")),
    )


def absent_of(rig: Rig) -> list[str]:
    """Causes that have no meaning on a bench."""
    return list(lacking({"body": not (rig.rotary or rig.linear_bench), "slope": not rig.rotary}))


def _form(rng: Generator, rig: Rig, name: str, *, mismatch: bool) -> str:
    forms = [form for cause, form in LAWS if cause == name]
    others = [form for form in forms if form not in ("law", "force")]
    if mismatch and others:
        return str(rng.choice(others))
    if name == "coulomb_error" and "coulomb_force" in rig.nominal:
        return "force"
    return forms[0]


def _target(rng: Generator, kind: str) -> float:
    """Size to be reached: from 1 to 300, a good half of them between 3 and 40.

    Of two effects each hides much of the other: both start where one alone is named.
    """
    if kind == "two":
        return log_uniform(rng, 10.0, 300.0)
    return log_uniform(rng, 3.0, 40.0) if rng.random() < 0.25 else log_uniform(rng, 1.0, 300.0)


def _strength(nuisances: Nuisances, cause: Cause, target: float) -> tuple[float, Floats]:
    """Find the strength at which a cause has a size, as near as it gets, and its gap."""
    # A force sensor sees the shortest delay by a whole sample: none is shorter than 1 ms.
    shown = cause.name == "drive_delay" and "force" in nuisances.experiment.sensors.channels
    grid = np.geomspace(5e-3 if shown else 1e-3, 1.0, 7)
    found = nuisances.differences([(cause.effect(s),) for s in grid.tolist()])
    sizes = np.array([np.linalg.norm(f) for f in found])
    above = np.flatnonzero(sizes >= target)
    if above.size == 0:
        best = int(np.argmax(sizes))
        return float(grid[best]), found[best]
    at = int(above[0])
    high, seen = float(grid[at]), found[at]
    if at == 0 and shown:
        return high, seen
    low = float(grid[at - 1]) if at else 1e-6
    for _ in range(14):
        if abs(np.linalg.norm(seen) / target - 1.0) < 0.05:
            break
        middle = float(np.sqrt(low * high))
        tried = nuisances.differences([(cause.effect(middle),)])[0]
        if np.linalg.norm(tried) >= target:
            high, seen = middle, tried
        else:
            low = middle
    return high, seen


def _rounded(parameters: dict[str, float]) -> dict[str, float]:
    return {name: float(f"{value:.6g}") for name, value in parameters.items()}


def _effect(cause: Cause, strength: float) -> Effect:
    name, form, parameters = cause.effect(strength)
    return name, form, _rounded(parameters)


def _pick(rng: Generator, rig: Rig, channels: tuple[str, ...], count: int) -> list[str]:
    """Pick causes that the sensors could show."""
    absent = {*absent_of(rig), *lacking({"rear_sensor": "x_rear" in channels})}
    names = [c for c in CAUSES if c not in absent]
    both = {"transmission_backlash", "transmission_compliance"}
    # No effect where the nominal file says that the value is uncertain.
    left_open = {record.name for record in effects() if record.error_of in rig.uncertainty}
    while True:
        picked = [str(name) for name in rng.choice(names, count, replace=False)]
        if not both <= set(picked) and not left_open & set(picked):
            return picked


@dataclass(frozen=True)
class Wanted:
    """What a case is asked to be.

    Attributes
    ----------
    kind : str
        One of `KINDS_OF_CASE`, or ``background``: one effect over one that nobody names.
    exact : bool
        The nominal values are true.
    mismatch : bool or None
        Another functional form than the listed one; None draws it.
    families : tuple of str
        Disturbances that a case outside the list may have.
    """

    kind: str
    exact: bool = False
    mismatch: bool | None = None
    families: tuple[str, ...] = OUTSIDE


def draw_case(seed: int, index: int, *, gap_free: bool = False, threads: int = 1) -> Case:
    """Draw one case of a seed; it does not depend on `threads`, those of the reality.

    With `gap_free` the case has no gap and exactly the nominal values.
    """
    rng = np.random.default_rng([seed, int(gap_free), index])
    kind = str(rng.choice(list(KINDS_OF_CASE), p=list(KINDS_OF_CASE.values())))
    wanted = Wanted("none" if gap_free else kind, exact=gap_free)
    return draw_wanted(rng, wanted, f"case {index} of seed {seed}", threads=threads)


def draw_wanted(rng: Generator, wanted: Wanted, label: str, *, threads: int = 1) -> Case:
    """Draw cases until one can be seen; `label` names it where none can."""
    for _ in range(_TRIES):
        # Strengths are tried until a gap has its size, and at some of them a run diverges: its
        # size is no number, and the next draw takes its place.
        with np.errstate(over="ignore", invalid="ignore"):
            case = _try_case(rng, wanted, threads)
        if case is not None:
            return _with_more_fresh(rng, case)
    raise RuntimeError(f"{label}: nothing drawn can be seen")


def _with_more_fresh(rng: Generator, case: Case) -> Case:
    """Draw more fresh runs of a case, by random numbers of their own."""
    rig, plan = case.experiment.rig, {**case.truth["plan"], "repeats": False}
    more = _drives(rng.spawn(1)[0], rig, _MORE_FRESH, plan)
    return replace(case, check=replace(case.check, drives=(*case.check.drives, *more)))


def _try_case(rng: Generator, wanted: Wanted, threads: int) -> Case | None:
    kind = wanted.kind
    rig = draw_rig(rng, exact=wanted.exact)
    plan = _plan(rng, rig)
    drives = _drives(rng, rig, plan["count"], plan)
    fresh = _drives(rng, rig, _FRESH, {**plan, "repeats": False})
    blind = Experiment(rig, tuple(drives), _NO_SENSORS)
    scale = scale_of_runs(blind)
    if scale.travel < 0.2 * plan["travel"] / 2.5:
        return None
    sensors = draw_sensors(rng, rig, scale.travel, scale.speed, scale.force)
    if kind in ("one", "two") and rng.random() < 0.04 and not rig.rotary and not rig.linear_bench:
        # Not by a set, whose order differs between processes and with it the drawn noise.
        channels = dict.fromkeys((*sensors.channels, "x_rear"))
        sensors = replace(sensors, channels=tuple(channels))
    experiment = replace(blind, sensors=sensors)
    check = Experiment(rig, tuple(fresh), sensors)
    shifts = {name: float(np.clip(rng.normal(), -2.0, 2.0)) for name in rig.uncertainty}
    scale = replace(scale, level=rig.true_level(shifts))
    truth: dict[str, Any] = {
        "kind": kind,
        "plan": plan,
        "drives": len(drives),
        "channels": ["x", *sensors.channels],
        "shifts": shifts,
        "bench": "rotary" if rig.rotary else "linear" if rig.linear_bench else "robot",
        "effects": [],
    }
    if kind == "none":
        truth |= {"status": "none", "accepted": [], "d": 0.0}
    case = Case(kind, experiment, check, World(shifts), truth)
    if kind == "none":
        return case
    nuisances = Nuisances(experiment, scale, World(shifts), threads)
    if kind == "outside":
        return _outside(rng, case, nuisances, wanted.families)
    if kind == "background":
        return _over_background(rng, case, nuisances)
    names = _pick(rng, rig, sensors.channels, 1 if kind == "one" else 2)
    mismatch = wanted.mismatch
    if mismatch is None:
        mismatch = kind == "one" and rng.random() < _MISMATCH
    forms = [_form(rng, rig, name, mismatch=mismatch) for name in names]
    causes = [draw_cause(rng, scale, name, form) for name, form in zip(names, forms, strict=True)]
    chosen, gaps = [], []
    for cause in causes:
        strength, gap = _strength(nuisances, cause, _target(rng, kind))
        chosen.append(_effect(cause, strength))
        gaps.append(gap)
    sizes = [float(np.linalg.norm(gap)) for gap in gaps]
    if min(sizes) < _LEAST or max(sizes) > _MOST:
        return None
    case = replace(case, world=World(shifts, tuple(chosen)))
    absent = absent_of(rig)
    return (
        single(case, nuisances, gaps[0], absent) if kind == "one" else pair(case, nuisances, absent)
    )


def _outside(
    rng: Generator, case: Case, nuisances: Nuisances, families: tuple[str, ...]
) -> Case | None:
    cause = draw_cause(rng, nuisances.scale, str(rng.choice(families)), "outside")
    strength, gap = _strength(nuisances, cause, _target(rng, "outside"))
    effect = _effect(cause, strength)
    world = World(nuisances.world.shifts, (effect,))
    d = nuisances.size(world.effects)
    if not _LEAST <= d <= _MOST:
        return None
    return outside(replace(case, world=world), nuisances, gap, absent_of(case.experiment.rig), d)


def _over_background(rng: Generator, case: Case, nuisances: Nuisances) -> Case | None:
    """Draw one effect over a weak disturbance, which leaves more than the sensors' noise."""
    rig, sensors = case.experiment.rig, case.experiment.sensors
    weak = draw_background(rng, nuisances.scale)
    floors = log_uniform(rng, *_FLOORS)
    strength, left = _strength(nuisances, weak, floors * float(np.sqrt(nuisances.base.size)))
    size = float(np.linalg.norm(left))
    if size < _FLOORS[0] * np.sqrt(nuisances.base.size):
        return None
    background = _effect(weak, strength)
    shifts = nuisances.world.shifts
    around = Nuisances(case.experiment, nuisances.scale, World(shifts, (background,)), 1)
    (picked,) = _pick(rng, rig, sensors.channels, 1)
    cause = draw_cause(rng, nuisances.scale, picked, _form(rng, rig, picked, mismatch=False))
    target = size * log_uniform(rng, *_TIMES)
    strength, gap = _strength(around, cause, target)
    found = float(np.linalg.norm(gap))
    if not 0.8 * target <= found <= 1.25 * target:
        return None
    effect = _effect(cause, strength)
    case = replace(case, world=World(shifts, (effect, background)))
    return over_background(case, around, gap, absent_of(rig), size)
