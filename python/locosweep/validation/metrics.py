"""Figures of a blind check, each with its interval and its target."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import binomtest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from locosweep.validation.judge import Judged

PLAIN = 10.0
"""Size from which a cause must be named, in standard deviations."""
_RESAMPLES = 1000
"""Of a bootstrap interval: what Efron and Tibshirani (1993) advise for percentiles."""


@dataclass(frozen=True)
class Figure:
    """One figure of the table.

    Attributes
    ----------
    name : str
        What it is.
    value, low, high : float
        Figure and 95 % interval; NaN without cases.
    count : int
        Cases that it rests on.
    target : str
        What it must reach; empty for figures that are only reported.
    met : bool or None
        Whether it does; None without target or cases.
    """

    name: str
    value: float
    low: float
    high: float
    count: int
    target: str = ""
    met: bool | None = None


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Return the 95 % interval of a share, after Wilson.

    Examples
    --------
    >>> from locosweep.validation.metrics import wilson
    >>> low, high = wilson(0, 200)
    >>> round(low, 4), round(high, 4)
    (0.0, 0.0188)
    """
    if count == 0:
        return math.nan, math.nan
    interval = binomtest(hits, count).proportion_ci(method="wilson")
    return float(interval.low), float(interval.high)


def _share(
    name: str,
    of: Iterable[bool | None],
    target: str = "",
    reaches: Callable[[float, float, float], bool] | None = None,
) -> Figure:
    known = [bool(hit) for hit in of if hit is not None]
    low, high = wilson(sum(known), len(known))
    if not known:
        return Figure(name, math.nan, math.nan, math.nan, 0, target)
    value = sum(known) / len(known)
    met = reaches(value, low, high) if reaches else None
    return Figure(name, value, low, high, len(known), target, met)


def _statistic(
    name: str,
    values: Sequence[float] | Sequence[tuple[float, float]],
    statistic: Callable[..., float],
    target: str = "",
    reaches: Callable[[float], bool] | None = None,
) -> Figure:
    """Return a mean, median or the like with its bootstrap interval."""
    from scipy.stats import bootstrap

    if not values:
        return Figure(name, math.nan, math.nan, math.nan, 0, target)
    columns = np.atleast_2d(np.asarray(values, dtype=float).T)
    value = low = high = float(statistic(*columns))
    if len(values) > 1:
        low, high = bootstrap(
            columns, statistic, n_resamples=_RESAMPLES, method="percentile", paired=True,
            vectorized=False, rng=0,
        ).confidence_interval  # fmt: skip
    met = reaches(value) if reaches else None
    return Figure(name, value, float(low), float(high), len(values), target, met)


def _at_least(bar: float) -> Callable[[float, float, float], bool]:
    return lambda value, _low, _high: value >= bar


def _at_most(bar: float) -> Callable[[float, float, float], bool]:
    return lambda value, _low, _high: value <= bar


def calibration_error(pairs: np.ndarray) -> float:
    """Mean distance of stated probability and share that is right, over ten bins."""
    bins = np.clip((pairs[:, 0] * 10).astype(int), 0, 9)
    error = 0.0
    for b in np.unique(bins):
        inside = pairs[bins == b]
        error += inside.shape[0] * abs(float(inside[:, 0].mean() - inside[:, 1].mean()))
    return error / len(pairs)


def _counts(case: Judged) -> bool:
    """Whether a verdict on a case can be held against it: nothing there, or plain to see."""
    return case.kind == "none" or case.d >= PLAIN


def figures(judged: Sequence[Judged]) -> list[Figure]:
    """All figures of the table, in its order."""
    gap_free = [c for c in judged if c.kind == "none"]
    gaps = [c for c in judged if c.kind != "none"]
    plain = [c for c in gaps if c.d_name >= PLAIN]
    single = [c for c in plain if c.kind == "one" and not c.mismatch]
    pairs = [c for c in plain if c.kind == "two"]
    alien = [c for c in plain if c.kind == "outside"]
    twins = [c for c in judged if c.twin]
    forms = [c for c in plain if c.kind == "one" and c.mismatch]
    effects = [c for c in plain if c.kind in ("one", "two")]
    detected = [c for c in effects if c.status != "none"]
    stated = [(c.probability, float(c.right)) for c in judged if _counts(c) and not c.error]
    shrinks = [c for c in effects if c.right and c.claimed is not None and c.fresh is not None]
    biases = [c.claimed - c.fresh for c in shrinks if c.claimed is not None and c.fresh is not None]
    inside = [
        c.interval[0] <= c.fresh <= c.interval[1]
        for c in shrinks
        if c.interval is not None and c.fresh is not None
    ]
    errors = [e for c in effects if c.right for e in c.parameters]
    seen = [c for c in gaps if c.d >= PLAIN]
    return [
        _share(
            "false-positive rate: a gap reported where there is none",
            (c.status != "none" for c in gap_free),
            "<= 0.03, upper bound <= 0.045",
            lambda value, _, high: value <= 0.03 and high <= 0.045,
        ),
        _share(
            "false-positive rate: a cause named where there is no gap", (c.named for c in gap_free)
        ),
        _share(
            "detection rate, d >= 6",
            (c.status != "none" for c in gaps if c.d >= 6.0),
            ">= 0.90",
            _at_least(0.90),
        ),
        _share(
            "detection rate, d >= 10",
            (c.status != "none" for c in seen),
            ">= 0.99",
            _at_least(0.99),
        ),
        _share("one effect: correct class", (c.right for c in single), ">= 0.97", _at_least(0.97)),
        _share(
            "one effect: correct class, d >= 10 before rivals are projected out",
            (c.right for c in seen if c.kind == "one" and not c.mismatch),
        ),
        _share(
            "one effect: exact name, where the class has one member",
            (c.exact for c in single if c.alone),
            ">= 0.95",
            _at_least(0.95),
        ),
        _share("two effects: both correct", (c.right for c in pairs), ">= 0.85", _at_least(0.85)),
        _share(
            "two effects: at least one correct",
            (c.one_right for c in pairs),
            ">= 0.98",
            _at_least(0.98),
        ),
        _share(
            "cause outside the list: unexplained",
            (c.status == "unexplained" for c in alien),
            ">= 0.90",
            _at_least(0.90),
        ),
        _share(
            "cause outside the list: a wrong name",
            (c.named for c in alien),
            "<= 0.05",
            _at_most(0.05),
        ),
        _share(
            "a single name given although a rival is nearer than 2 standard deviations",
            (c.single_name for c in twins),
            "<= 0.01",
            _at_most(0.01),
        ),
        _statistic(
            "mean probability given to the true class",
            [c.probability if c.right else 0.0 for c in detected],
            np.mean,
            ">= 0.92",
            lambda value: value >= 0.92,
        ),
        _statistic(
            "expected calibration error",
            stated,
            lambda *columns: calibration_error(np.column_stack(columns)),
            "<= 0.05",
            lambda value: value <= 0.05,
        ),
        _statistic(
            "bias of the claimed reduction (claimed less that on fresh runs), mean",
            biases,
            np.mean,
            "within 0.02",
            lambda value: abs(value) <= 0.02,
        ),
        _share(
            "reduction on fresh runs inside the claimed interval",
            inside,
            "0.85 to 0.95",
            lambda value, _low, _high: 0.85 <= value <= 0.95,
        ),
        _statistic(
            "parameter error, median",
            errors,
            np.median,
            "<= 0.02",
            lambda value: value <= 0.02,
        ),
        _share(
            "location of the gap correct",
            (None if c.window_share is None else c.window_share >= 0.5 for c in seen),
            ">= 0.95",
            _at_least(0.95),
        ),
        _share("site correct", (c.site_right for c in effects), ">= 0.95", _at_least(0.95)),
        _share(
            "one effect with a functional form other than the listed one: correct class",
            (c.right for c in forms),
            ">= 0.90",
            _at_least(0.90),
        ),
        _share(
            "next experiment resolves the rivals",
            (c.next_resolves for c in judged if c.next_possible),
            ">= 0.90",
            _at_least(0.90),
        ),
        _share("some experiment could", (c.next_possible for c in judged)),
        _statistic(
            "processor time of a diagnosis, median [s]",
            [c.seconds for c in judged if math.isfinite(c.seconds)],
            np.median,
        ),
        _share("diagnoses that failed", (bool(c.error) for c in judged)),
    ]


_SIZES = (0.0, 3.0, 6.0, 10.0, 20.0, 40.0, 100.0, math.inf)


def power(judged: Sequence[Judged]) -> list[tuple[float, float, Figure, Figure]]:
    """Share detected and share right by size: lower and upper size, two figures."""
    rows = []
    for low, high in itertools.pairwise(_SIZES):
        inside = [c for c in judged if c.kind != "none" and low <= c.d < high]
        if inside:
            seen = _share("detected", (c.status != "none" for c in inside))
            rows.append((low, high, seen, _share("right", (c.right for c in inside))))
    return rows


def calibration(judged: Sequence[Judged], bins: int = 10) -> list[tuple[float, Figure]]:
    """Mean stated probability and share that is right, by bins of the former."""
    pairs = [(c.probability, c.right) for c in judged if _counts(c) and not c.error]
    rows = []
    for b in range(bins):
        inside = [(p, r) for p, r in pairs if min(int(p * bins), bins - 1) == b]
        if inside:
            stated = float(np.mean([p for p, _ in inside]))
            rows.append((stated, _share("right", (r for _, r in inside))))
    return rows


def splits(judged: Sequence[Judged]) -> dict[str, list[Figure]]:
    """Share right by family, by excitation, by channels and by size, of what can be named."""
    plain = [c for c in judged if c.kind != "none" and c.d_name >= PLAIN]

    def by(key: Callable[[Judged], str], cases: Sequence[Judged]) -> list[Figure]:
        names = sorted({key(c) for c in cases})
        return [_share(name, (c.right for c in cases if key(c) == name)) for name in names]

    def size(case: Judged) -> str:
        at = max(i for i, low in enumerate(_SIZES[:-1]) if case.d >= low)
        return f"d {_SIZES[at]:>5g} to {_SIZES[at + 1]:g}"

    return {
        "effect": by(lambda c: c.family, [c for c in plain if c.kind != "two"]),
        "kind": by(lambda c: c.kind + (", another law" if c.mismatch else ""), plain),
        "excitation": by(lambda c: c.mode, plain),
        "channels": by(lambda c: " ".join(c.channels), plain),
        "size": by(size, [c for c in judged if c.kind != "none"]),
    }


def confusion(judged: Sequence[Judged]) -> dict[tuple[str, str], int]:
    """How often what was said of what, of single effects, disturbances and no gap.

    Names that the data cannot tell apart count as the truth.
    """
    counts: dict[tuple[str, str], int] = {}
    for case in judged:
        if case.kind == "two" or not (case.kind == "none" or case.d_name >= PLAIN):
            continue
        true = "outside the list" if case.kind == "outside" else case.family
        said = case.said
        if "+" in said:
            said = "several"
        if case.right:
            said = "unexplained" if case.kind == "outside" else true
            said = case.said if case.kind == "outside" and case.named else said
        key = true, said
        counts[key] = counts.get(key, 0) + 1
    return counts
