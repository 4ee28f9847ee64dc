"""Figures of a blind check, each with its interval and its target."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import binomtest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from locosweep.validation.judge import Judged

PLAIN = 10.0
"""Size from which a cause must be named, in standard deviations."""
_RESAMPLES = 1000
"""Resamples of a bootstrap interval, as Efron and Tibshirani (1993) advise for percentiles."""


@dataclass(frozen=True)
class Figure:
    """One figure of the table.

    Attributes
    ----------
    name : str
        As in the table.
    value, low, high : float
        Figure and 95 % interval; NaN without cases.
    count : int
        Cases that it rests on.
    target : str
        What it must reach; empty for figures that are only reported.
    met : bool or None
        Target reached; None without target or cases, or where these are too few to tell.
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


@dataclass(frozen=True)
class _Target:
    """A bound for a figure, in words and as a condition."""

    text: str
    reached: Callable[[Figure], bool | None]
    """None where the cases are too few to tell."""


def at_least(bar: float) -> _Target:
    """Return the target of a share that is to be large."""
    return _Target(f"at least {bar:.2f}", lambda figure: figure.value >= bar)


def at_most(bar: float) -> _Target:
    """Return the target of a share that is to be small."""
    return _Target(f"at most {bar:.2f}", lambda figure: figure.value <= bar)


def bounded(value: float, bar: float, bound: float, most: float) -> bool | None:
    """Return whether a share of errors is small for certain.

    None where the share is within its bar, and too few cases keep its bound from being so.

    Examples
    --------
    >>> bounded(0.0, 0.03, 0.01, 0.045), bounded(0.0, 0.03, 0.56, 0.045)
    (True, None)
    >>> bounded(0.1, 0.03, 0.12, 0.045)
    False
    """
    return False if value > bar else bound <= most or None


_FALSE_POSITIVES = _Target(
    "at most 0.03, upper bound at most 0.045",
    lambda figure: bounded(figure.value, 0.03, figure.high, 0.045),
)


def within(bar: float) -> _Target:
    """Return the target of a bias."""
    return _Target(f"within {bar:.2f}", lambda figure: abs(figure.value) <= bar)


_COVERED = _Target("0.85 to 0.95", lambda figure: 0.85 <= figure.value <= 0.95)


def _figure(name: str, found: tuple[float, float, float], count: int, to: _Target | None) -> Figure:
    figure = Figure(name, *found, count, to.text if to else "")
    return replace(figure, met=to.reached(figure)) if to and count else figure


def share(name: str, hits: Iterable[bool | None], target: _Target | None = None) -> Figure:
    """Return the share of hits, those that are None left out, with its Wilson interval."""
    known = [bool(hit) for hit in hits if hit is not None]
    value = sum(known) / len(known) if known else math.nan
    return _figure(name, (value, *wilson(sum(known), len(known))), len(known), target)


def summary(
    name: str,
    values: Sequence[float] | Sequence[tuple[float, float]],
    statistic: Callable[..., float],
    target: _Target | None = None,
) -> Figure:
    """Return a mean, median or the like with its bootstrap interval."""
    from scipy.stats import bootstrap

    if not values:
        return _figure(name, (math.nan, math.nan, math.nan), 0, target)
    columns = np.atleast_2d(np.asarray(values, dtype=float).T)
    value = low = high = float(statistic(*columns))
    if len(values) > 1:
        low, high = bootstrap(
            columns, statistic, n_resamples=_RESAMPLES, method="percentile", paired=True,
            vectorized=False, rng=0,
        ).confidence_interval  # fmt: skip
    return _figure(name, (value, float(low), float(high)), len(values), target)


def _by_probability(pairs: np.ndarray, bins: int = 10) -> list[np.ndarray]:
    """Part pairs of stated probability and 1 for right, 0 for wrong, by the former."""
    at = np.clip((pairs[:, 0] * bins).astype(int), 0, bins - 1)
    return [pairs[at == b] for b in np.unique(at)]


def calibration_error(pairs: np.ndarray) -> float:
    """Mean distance of stated probability and share that is right, over ten bins."""
    parts = _by_probability(pairs)
    errors = (len(p) * abs(float(p[:, 0].mean() - p[:, 1].mean())) for p in parts)
    return sum(errors, 0.0) / len(pairs)


def _stated(judged: Sequence[Judged]) -> list[tuple[float, float]]:
    """Probability and correctness of verdicts on cases with no gap, or one plain to see."""
    counted = [c for c in judged if c.kind == "none" or c.d >= PLAIN]
    return [(c.probability, float(c.right)) for c in counted if not c.error]


def claims(judged: Sequence[Judged], bias: float) -> list[Figure]:
    """Compare claimed reductions with those on fresh runs, where the cause is right.

    `bias` is what they may differ by on average.
    """
    rows = [(c.claimed, c.fresh, c.interval) for c in judged if c.right]
    return _against_fresh("claimed reduction", "claimed", rows, bias)


def stated_shares(judged: Sequence[Judged], bias: float) -> list[Figure]:
    """Compare shares that `partial` verdicts state with reductions on fresh runs.

    Where the cause is right, and the only one that is named.
    """
    rows = [(c.stated, c.fresh, c.stated_interval) for c in judged if c.right]
    return _against_fresh("stated share of one cause, `partial`", "stated", rows, bias)


def _against_fresh(
    what: str,
    said: str,
    rows: Sequence[tuple[float | None, float | None, tuple[float, float] | None]],
    bias: float,
) -> list[Figure]:
    pairs = [
        (told, fresh, ends) for told, fresh, ends in rows if told is not None and fresh is not None
    ]
    return [
        summary(
            f"bias of the {what} ({said} less that on fresh runs), mean",
            [told - fresh for told, fresh, _ in pairs],
            np.mean,
            within(bias),
        ),
        share(
            f"reduction on fresh runs inside the {said} interval",
            (ends[0] <= fresh <= ends[1] for _, fresh, ends in pairs if ends is not None),
            _COVERED,
        ),
    ]


def figures(judged: Sequence[Judged]) -> list[Figure]:
    """All figures of the table, in its order."""
    gap_free = [c for c in judged if c.kind == "none"]
    gaps = [c for c in judged if c.kind != "none"]
    seen = [c for c in gaps if c.d >= PLAIN]
    plain = [c for c in gaps if c.d_name >= PLAIN]
    one = [c for c in plain if c.kind == "one"]
    single = [c for c in one if not c.mismatch]
    pairs = [c for c in plain if c.kind == "two"]
    outside = [c for c in plain if c.kind == "outside"]
    effects = [c for c in plain if c.kind in ("one", "two")]
    return [
        share(
            "false-positive rate: a gap reported where there is none",
            (c.status != "none" for c in gap_free),
            _FALSE_POSITIVES,
        ),
        share(
            "false-positive rate: a cause named where there is no gap", (c.named for c in gap_free)
        ),
        share("detection rate, d >= 6", (c.detected for c in gaps if c.d >= 6), at_least(0.9)),
        share("detection rate, d >= 10", (c.detected for c in seen), at_least(0.99)),
        share("one effect: correct class", (c.right for c in single), at_least(0.97)),
        share(
            "one effect: correct class, d >= 10 before rivals are projected out",
            (c.right for c in seen if c.kind == "one" and not c.mismatch),
        ),
        share(
            "one effect: exact name, where the class has one member",
            (c.exact for c in single if c.alone),
            at_least(0.95),
        ),
        share("two effects: both correct", (c.right for c in pairs), at_least(0.85)),
        share("two effects: at least one correct", (c.one_right for c in pairs), at_least(0.98)),
        share(
            "outside the list: `unexplained`, what copies the cause, or the fault of the readings",
            (c.right for c in outside),
            at_least(0.9),
        ),
        share(
            "outside the list: a wrong name",
            (c.named and not c.right for c in outside),
            at_most(0.05),
        ),
        share(
            "a single name given although a rival is nearer than 2 standard deviations",
            (c.single_name for c in judged if c.twin),
            at_most(0.01),
        ),
        summary(
            "mean probability given to the true class",
            [c.probability if c.right else 0.0 for c in effects if c.status != "none"],
            np.mean,
            at_least(0.92),
        ),
        summary(
            "expected calibration error",
            _stated(judged),
            lambda *columns: calibration_error(np.column_stack(columns)),
            at_most(0.05),
        ),
        *claims(effects, 0.02),
        summary(
            "parameter error, median",
            [error for c in effects if c.right for error in c.parameters],
            np.median,
            at_most(0.02),
        ),
        share(
            "location of the gap correct",
            (None if c.window_share is None else c.window_share >= 0.5 for c in seen),
            at_least(0.95),
        ),
        share("site correct", (c.site_right for c in effects), at_least(0.95)),
        share(
            "one effect with a functional form other than the listed one: correct class",
            (c.right for c in one if c.mismatch),
            at_least(0.9),
        ),
        share(
            "next experiment separates the rivals, where some run of the menu would",
            (c.next_resolves for c in judged if c.next_possible),
            at_least(0.9),
        ),
        share("some run of the menu would separate the rivals", (c.next_possible for c in judged)),
        summary(
            "processor time of a diagnosis, median [s]",
            [c.seconds for c in judged if math.isfinite(c.seconds)],
            np.median,
        ),
        share("diagnoses that failed", (bool(c.error) for c in judged)),
    ]


_SIZES = (0.0, 3.0, 6.0, 10.0, 20.0, 40.0, 100.0, math.inf)


def power(judged: Sequence[Judged]) -> list[tuple[float, float, Figure, Figure]]:
    """Share detected and share right by size: lower and upper size, two figures."""
    rows = []
    for low, high in itertools.pairwise(_SIZES):
        inside = [c for c in judged if c.kind != "none" and low <= c.d < high]
        if inside:
            seen = share("detected", (c.detected for c in inside))
            rows.append((low, high, seen, share("right", (c.right for c in inside))))
    return rows


def calibration(judged: Sequence[Judged]) -> list[tuple[float, Figure]]:
    """Mean stated probability and share that is right, by bins of the former."""
    parts = _by_probability(np.array(_stated(judged)).reshape(-1, 2))
    return [(float(p[:, 0].mean()), share("right", p[:, 1] > 0.0)) for p in parts]


def splits(judged: Sequence[Judged]) -> dict[str, list[Figure]]:
    """Share right by family, by excitation, by channels and by size, of what can be named."""
    plain = [c for c in judged if c.kind != "none" and c.d_name >= PLAIN]

    def by(key: Callable[[Judged], str], cases: Sequence[Judged]) -> list[Figure]:
        names = sorted({key(c) for c in cases})
        return [share(name, (c.right for c in cases if key(c) == name)) for name in names]

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
    """Count pairs of truth and verdict over single effects, disturbances and no gap.

    Names that the data cannot separate from the truth count as the truth.
    """
    counts: Counter[tuple[str, str]] = Counter()
    for case in judged:
        if case.kind == "two" or not (case.kind == "none" or case.d_name >= PLAIN):
            continue
        true = "outside the list" if case.kind == "outside" else case.family
        said = "several" if "+" in case.said else case.said
        if case.right:
            said = true
            if case.kind == "outside":
                said = case.said if case.named else "unexplained"
        counts[true, said] += 1
    return counts
