"""Every effect that a diagnosis tries: what a column of its finite differences costs.

Six runs of 2000 samples; for each effect and run the model itself and one column for each of
its parameters, moved by a thousandth. Nothing else computes these, so there is no peer.
"""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from dynamics_peers.replays import NOMINAL, RUNS, SAMPLES, SLOPE_DEG, drives, times
from locosweep import _core

EXACT, BRISTLES, STEPPED = "exact", "bristles", "stepped"
# Of visible size, in the order of each effect's parameters; those of dynamics.rs.
SIZES: dict[str, tuple[float, ...]] = {
    "viscous_friction": (0.6,),
    "quadratic_drag": (3.0,),
    "stribeck_friction": (0.7, 0.02, 1.0),
    "presliding_compliance": (2e4, 30.0),
    "direction_dependent_friction": (0.3, 0.5),
    "position_dependent_friction": (0.4, 0.01, 0.7),
    "load_dependent_friction": (0.2,),
    "friction_drift": (0.5, 0.8),
    "lubricant_buildup": (5.0,),
    "drive_saturation": (0.6,),
    "drive_lag": (0.03,),
    "drive_delay": (0.0123,),
    "drive_deadzone": (0.1,),
    "drive_gain_error": (-0.15,),
    "back_emf": (0.5,),
    "supply_sag": (0.3, 0.7),
    "transmission_backlash": (5e-4, 0.03),
    "transmission_compliance": (400.0, 1.0, 0.05),
    "slope_error": (1.5,),
    "payload_mass": (0.08,),
    "coulomb_error": (0.05, 0.0),
    "anchor_slip": (0.1, 0.06),
    "sensor_scale": (0.03,),
    "sensor_drift": (1e-3,),
    "sensor_delay": (0.0077,),
}
# Where motion between samples is not known in closed form.
_KINDS = {
    "presliding_compliance": BRISTLES,
    "quadratic_drag": STEPPED,
    "stribeck_friction": STEPPED,
    "position_dependent_friction": STEPPED,
    "lubricant_buildup": STEPPED,
    "transmission_backlash": STEPPED,
    "transmission_compliance": STEPPED,
}


@dataclass(frozen=True)
class Rate:
    """Sample-steps per second and core."""

    name: str
    kind: str
    columns: int
    per_second: float


def measure(rounds: int, tell: Callable[[str], None]) -> list[Rate]:
    """Time all effects in turn, on one thread: A B C A B C ..."""
    job = _core.Replay({**NOMINAL}, [(times(), drive, SLOPE_DEG) for drive in drives()])
    effects = _core.effects()
    if missing := {effect.name for effect in effects} ^ set(SIZES):
        raise SystemExit(f"no size, or no effect, for {', '.join(sorted(missing))}")
    calls = {effect.name: _call(job, effect) for effect in effects}
    taken: dict[str, list[float]] = {name: [] for name in calls}
    for call, _ in calls.values():
        call()
    gc.disable()
    for turn in range(rounds):
        tell(f"effects: round {turn + 1} of {rounds}")
        for name, (call, _) in calls.items():
            start = time.process_time()
            call()
            taken[name].append(time.process_time() - start)
    gc.enable()
    return [
        Rate(name, _KINDS.get(name, EXACT), columns, columns * SAMPLES / statistics.median(spent))
        for (name, spent), (_, columns) in zip(taken.items(), calls.values(), strict=True)
    ]


def _call(job: _core.Replay, effect: _core.Effect) -> tuple[Callable[[], None], int]:
    sizes = np.array(SIZES[effect.name])
    parameters = slice(effect.first, effect.first + sizes.size)
    each = 1 + sizes.size
    values = np.zeros((RUNS * each, _core.effect_parameter_count()))
    values[:, parameters] = sizes
    for i in range(sizes.size):
        values[1 + i :: each, effect.first + i] *= 1.001
    columns = [(run, 0, SAMPLES, [effect.name]) for run in range(RUNS) for _ in range(each)]
    shares = np.tile([1.0, 1.0, 1.0, 0.0], (len(columns), 1))
    starts = np.zeros((len(columns), 2))

    def call() -> None:
        x = job.run(columns, values, shares, starts, 1)[0]
        assert np.isfinite(x).all(), effect.name

    return call, len(columns)


def pooled(rates: Iterable[Rate], kind: str) -> float | None:
    """Return the rate of all effects of a kind together."""
    chosen = [rate for rate in rates if rate.kind == kind]
    if not chosen:
        return None
    seconds = sum(rate.columns * SAMPLES / rate.per_second for rate in chosen)
    return sum(rate.columns * SAMPLES for rate in chosen) / seconds


def cells(rates: Iterable[Rate]) -> list[list[str]]:
    """Return a line for each effect."""
    head = ["effect", "kind", "columns", "samples/s and core", "ns/sample"]
    lines = [
        [r.name, r.kind, str(r.columns), f"{r.per_second:.2e}", f"{1e9 / r.per_second:.3g}"]
        for r in sorted(rates, key=lambda r: r.per_second)
    ]
    return [head, *lines]
