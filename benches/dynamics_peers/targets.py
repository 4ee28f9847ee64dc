"""What locosweep promises of its dynamics, in one table: ours, theirs, ratio, target, limit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from dynamics_peers import battery
from dynamics_peers.battery import Rate
from dynamics_peers.limits import COUNTS, Machine, units
from dynamics_peers.measure import Row
from dynamics_peers.memory import LIMIT_MB, Held
from dynamics_peers.work import BRISTLES, LUGRE, PULSES, REPLAY, ROBOT, STRIBECK, UNITS

# With fewer points fixed costs of a call show: no target holds.
LEAST_SCALE = 0.1


@dataclass(frozen=True)
class Target:
    """How many times slower a way is than ours at least, per core."""

    work: str
    key: str
    peer: str
    bounds: Mapping[str, float]
    """For each SIMD level that the promise is about; empty where only the ratio is shown."""
    threads: int = 1
    ours: str = "ours"


@dataclass(frozen=True)
class Verdict:
    """One row of the table."""

    work: str
    ours: str
    peer: str
    theirs: str
    ratio: str
    wanted: str
    limit: str
    met: str


TARGETS = [
    Target(STRIBECK, "jax", "jax", {"avx512": 3}),
    Target(STRIBECK, "numpy.blocked", "numpy, blocks in place", {"avx512": 5}),
    Target(STRIBECK, "numpy", "numpy, whole arrays", {}),
    Target(STRIBECK, "numba", "numba", {"avx512": 25}),
    Target(STRIBECK, "numba.lanes", "numba, lanes by hand", {}),
    Target(STRIBECK, "heyoka.compiled", "heyoka, RK4 compiled", {}),
    Target(STRIBECK, "heyoka", "heyoka, Taylor", {}),
    Target(STRIBECK, "diffrax", "diffrax, Tsit5", {}),
    Target(STRIBECK, "scipy.LSODA", "scipy, LSODA", {}),
    Target(LUGRE, "heyoka", "heyoka", {"avx2": 40, "avx512": 40}),
    Target(LUGRE, "scipy.LSODA.compiled", "LSODA, compiled rate", {"avx2": 90, "avx512": 90}),
    Target(LUGRE, "scipy.LSODA", "LSODA", {}),
    Target(LUGRE, "diffrax", "diffrax, Kvaerno5", {}),
    Target(LUGRE, "numba.rk4", "numba, RK4", {}),
    Target(PULSES, "ours.located", "locosweep RK4, stops to 1e-9", {"avx2": 35, "avx512": 80}),
    Target(PULSES, "numba.located", "numba, RK4, stops to 1e-9 s", {}),
    Target(PULSES, "numba.exact", "numba, exact pieces", {}),
    Target(PULSES, "numpy", "numpy, exact pieces", {}),
    Target(ROBOT, "mujoco.rollout", "mujoco, rollout", {"avx2": 50, "avx512": 50}),
    Target(ROBOT, "mujoco", "mujoco, mj_step", {}),
    Target(ROBOT, "scipy", "scipy, smoothed", {}),
    Target(ROBOT, "numba.stepped", "numba, time stepping", {}),
    Target(REPLAY, "numba", "numba, exact pieces", {}),
    Target(REPLAY, "numpy", "numpy, exact pieces", {}),
    Target(BRISTLES, "numba", "numba, RK4", {}),
    Target(BRISTLES, "scipy", "scipy, LSODA", {}),
]
# Sample-steps per second and core, every effect with its finite differences.
RATES = {battery.EXACT: 1e8, battery.BRISTLES: 2e7}


def judge(
    groups: Mapping[str, Sequence[Row]], machine: Machine, level: str, scale: float
) -> list[Verdict]:
    """Hold the measured times against every target; only ratios for few points."""
    found = []
    for target in TARGETS:
        rows = {(row.way.key, row.way.threads): row for row in groups.get(target.work, ())}
        ours = rows.get((target.ours, target.threads))
        if ours is None:
            continue
        unit, factor = UNITS[target.work]
        theirs = rows.get((target.key, target.threads))
        ratio = theirs.seconds / ours.seconds if theirs else None
        bound = target.bounds.get(level)
        met = "-"
        if ratio is not None and bound is not None and scale >= LEAST_SCALE:
            met = "yes" if ratio >= bound else "NO"
        wanted = "-" if bound is None else f">= {bound:g}"
        if bound is None and target.bounds:
            wanted = ", ".join(f">= {value:g} with {name}" for name, value in target.bounds.items())
        found.append(
            Verdict(
                target.work,
                f"{factor * ours.seconds:.3g} {unit}",
                target.peer,
                f"{factor * theirs.seconds:.3g} {unit}" if theirs else "not installed",
                "-" if ratio is None else f"{ratio:.3g}",
                wanted,
                _limit(target.work, ours, machine),
                met,
            )
        )
    return found


def _limit(work: str, ours: Row, machine: Machine) -> str:
    least = machine.seconds(work)
    if least is None:
        return "-"
    unit, factor = UNITS[work]
    return f"{factor * least * units(work, ours.way.steps):.3g} {unit}"


def rates(found: Iterable[Rate], machine: Machine) -> list[Verdict]:
    """Hold the rates of the effects against what is asked for, kind by kind."""
    found = list(found)
    verdicts = []
    for kind in (battery.EXACT, battery.BRISTLES, battery.STEPPED):
        rate = battery.pooled(found, kind)
        if rate is None:
            continue
        bound = RATES.get(kind)
        count = sum(r.kind == kind for r in found)
        least = machine.seconds(REPLAY) if kind == battery.EXACT else None
        verdicts.append(
            Verdict(
                f"{count} effect{'s' if count > 1 else ''}, {kind}",
                f"{rate:.2e}/s",
                "none",
                "-",
                "-",
                "-" if bound is None else f">= {bound:.0e}/s",
                "-" if least is None else f"{1 / least:.2e}/s",
                "-" if bound is None else "yes" if rate >= bound else "NO",
            )
        )
    return verdicts


def memory(found: Iterable[Held]) -> list[Verdict]:
    """Hold the memory of ensembles against its limit."""
    return [
        Verdict(
            f"memory, {held.trajectories:,} x {held.steps:,} steps",
            f"{held.beside_mb:.1f} MB",
            "none",
            "-",
            "-",
            f"<= {LIMIT_MB} MB",
            f"result {held.result_mb:.3g} MB",
            "yes" if held.beside_mb <= LIMIT_MB else "NO",
        )
        for held in found
    ]


def cells(found: Iterable[Verdict]) -> list[list[str]]:
    """Return the table's lines; times are of one trajectory on one core."""
    head = ["work", "locosweep", "beside", "takes", "ratio", "target", "limit", "met"]
    return [head, *([*vars(verdict).values()] for verdict in found)]


def limits_note(machine: Machine) -> str:
    """Say what the limits are made of."""
    counted = ", ".join(f"{work} {n} per {unit}" for work, (n, unit) in COUNTS.items())
    return (
        f"limit: {machine.multiply_adds / 1e9:.1f}e9 multiply-adds per second and core (measured "
        f"by a matrix product), {machine.written / 1e9:.1f} GB/s written; multiply-adds needed: "
        f"{counted}"
    )
