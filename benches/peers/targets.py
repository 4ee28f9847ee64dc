"""What locosweep promises in comparison, as ratios of measured times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from peers.memory import LIMIT_MB
from peers.work import CLOSED, FRESH, REUSED, SEARCH

Times = Mapping[tuple[str, str, int], float]

# Smaller arrays fit into caches, and fixed costs of a call show: no target holds.
LEAST_SCALE = 0.1


@dataclass(frozen=True)
class Target:
    """The time of ``over`` over that of ``under`` is at most or at least ``bound``."""

    text: str
    group: str
    over: tuple[str, int]
    under: tuple[str, int]
    sign: str
    bound: float


@dataclass(frozen=True)
class Verdict:
    """A target with what was measured."""

    text: str
    wanted: str
    measured: str
    met: bool | None


_OURS, _OURS2 = ("ours", 1), ("ours", 2)
_AVX2, _AVX512 = ("ours.avx2", 1), ("ours.avx512", 1)

TARGETS = [
    Target("locosweep / plain fill, 1 thread", REUSED, _OURS, ("fill", 1), "<=", 1.15),
    Target("locosweep / plain fill, 2 threads", REUSED, _OURS2, ("fill", 2), "<=", 1.15),
    Target("numba / locosweep, 1 thread", REUSED, ("numba", 1), _OURS, ">=", 1.3),
    Target("numba / locosweep, 2 threads", REUSED, ("numba", 2), _OURS2, ">=", 1.1),
    Target("numpy broadcasting / locosweep, 1 thread", REUSED, ("numpy", 1), _OURS, ">=", 25),
    Target("avx2 / avx512", REUSED, _AVX2, _AVX512, "<=", 2.2),
    Target("locosweep / fresh fill, 1 thread", FRESH, _OURS, ("fill", 1), "<=", 1.4),
    Target("locosweep / fresh fill, 2 threads", FRESH, _OURS2, ("fill", 2), "<=", 1.4),
    Target("numba / locosweep, 1 thread", SEARCH, ("numba", 1), _OURS, ">=", 8),
    Target("1 thread / 2 threads", SEARCH, _OURS, _OURS2, ">=", 1.8),
    Target("avx2 / avx512", SEARCH, _AVX2, _AVX512, "<=", 2.2),
    Target("numba / locosweep, 1 thread", CLOSED, ("numba", 1), _OURS, ">=", 1),
    Target("avx2 / avx512", CLOSED, _AVX2, _AVX512, "<=", 2.2),
]


def judge(times: Times, memory: Mapping[str, float], scale: float) -> list[Verdict]:
    """Hold the measured times against every target; only ratios for small arrays."""
    found = []
    for target in TARGETS:
        over = times.get((target.group, *target.over))
        under = times.get((target.group, *target.under))
        ratio = over / under if over and under else None
        met = None
        if ratio is not None and scale >= LEAST_SCALE:
            met = ratio <= target.bound if target.sign == "<=" else ratio >= target.bound
        text = f"{target.group}: {target.text}"
        measured = "not measured" if ratio is None else f"{ratio:.2f}"
        found.append(Verdict(text, f"{target.sign} {target.bound:g}", measured, met))
    beside = memory["beside_mb"]
    text = f"{FRESH}: peak memory beside the result"
    found.append(Verdict(text, f"<= {LIMIT_MB} MB", f"{beside:.0f} MB", beside <= LIMIT_MB))
    return found
