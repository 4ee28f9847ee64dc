"""Figures of strata of the blind check, with bounds that hold at a stated confidence."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import binomtest

from locosweep.validation.judge import OF_READINGS, Judged
from locosweep.validation.laws import KEPT_OUT
from locosweep.validation.metrics import (
    PLAIN,
    Figure,
    at_least,
    bounded,
    claims,
    share,
    stated_shares,
    summary,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from locosweep.validation.bad_readings import BadJudged

_BIAS = 0.03
"""Difference of claimed and fresh reductions, on average, that another law, a second cause or a
background may make; without these it is 0.02."""


def upper_bound(hits: int, count: int) -> float:
    """Return what a share is at most, at 95 % confidence, after Clopper and Pearson.

    Examples
    --------
    >>> from locosweep.validation.strata_metrics import upper_bound
    >>> [round(upper_bound(hits, n), 3) for hits, n in ((0, 59), (3, 153), (5, 208))]
    [0.05, 0.05, 0.05]
    """
    if count == 0:
        return float("nan")
    # A two-sided interval at 90 % leaves 5 % above.
    return float(binomtest(hits, count).proportion_ci(0.9, "exact").high)


def _certified(name: str, hits: Iterable[bool], bar: float) -> Figure:
    """Return a share of errors that has to lie below a bar at 95 % confidence."""
    found = share(name, hits)
    if not found.count:
        return replace(found, target=f"at most {bar:.2f} at 95 % confidence")
    bound = upper_bound(round(found.value * found.count), found.count)
    return replace(
        found,
        target=f"at most {bar:.2f} at 95 % confidence ({bound:.3f})",
        met=bounded(found.value, bar, bound, bar),
    )


def _common(judged: Sequence[Judged]) -> list[Figure]:
    seconds = [case.seconds for case in judged if np.isfinite(case.seconds)]
    return [
        summary("processor time of a diagnosis, median [s]", seconds, np.median),
        share("diagnoses that failed", (bool(case.error) for case in judged)),
    ]


def _true_effects(judged: Sequence[Judged]) -> list[Figure]:
    """Compare the true effect's reductions on the measured and on fresh runs, where it is named.

    The background differs between runs as much as the effect does: what is left then is no fault of
    a claim.
    """
    rows = [
        (c.claimed, *c.reached)
        for c in judged
        if c.right and c.claimed is not None and c.reached is not None
    ]
    return [
        summary(
            "reduction by the true effect itself, less that on fresh runs, mean",
            [measured - fresh for _, measured, fresh in rows],
            np.mean,
        ),
        summary(
            "claimed reduction less that by the true effect on the measured runs, mean",
            [claimed - measured for claimed, measured, _ in rows],
            np.mean,
        ),
    ]


def stratum_figures(name: str, judged: Sequence[Judged]) -> list[Figure]:
    """Figures of a stratum, in the order of its table.

    Causes count from 10 deviations away from every other explanation, as in the mixture; over a
    background all count.
    """
    plain = [case for case in judged if case.d_name >= PLAIN]
    if name == "outside":
        new = [case for case in plain if case.family in KEPT_OUT]
        return [
            share(
                "no wrong name: `unexplained`, what copies the cause, or the fault of the readings",
                (case.right for case in plain),
                at_least(0.9),
            ),
            _certified("a wrong name", (case.named and not case.right for case in plain), 0.05),
            share("a wrong name, families that the mixture lacks",
                  (case.named and not case.right for case in new)),
            share("no gap seen, and no fault of the readings",
                  (case.status == "none" and not case.as_reading for case in plain)),
            share("told what it looks like: the right variable, of forces by place or time",
                  (case.looks_right for case in plain if case.looks_right is not None)),
            share("frozen or slipped readings: found as such, no cause named",
                  (case.as_reading for case in plain if case.family in OF_READINGS)),
            *_common(judged),
        ]  # fmt: skip
    if name == "another-law":
        wrong = [case.named and not case.one_right for case in plain]
        return [
            share("right class", (case.right for case in plain), at_least(0.85)),
            share("right class, or the cause beside another one",
                  (case.right or case.one_right for case in plain)),
            share("only wrong names", wrong),
            *claims(plain, _BIAS),
            *_common(judged),
        ]  # fmt: skip
    if name == "pairs":
        return [
            share("both right", (case.right for case in plain), at_least(0.88)),
            share("at least one right", (case.one_right for case in plain), at_least(0.98)),
            *claims(plain, _BIAS),
            *_common(judged),
        ]
    weak, strong = ([c for c in judged if (c.times >= 10.0) == far] for far in (False, True))
    return [
        share("first cause right, 10 to 30 times the background", (c.right for c in strong),
              at_least(0.9)),
        share("first cause right, 3 to 10 times", (c.right for c in weak), at_least(0.8)),
        share("a wrong first cause", (c.named and not c.right for c in judged)),
        *claims(judged, _BIAS),
        *stated_shares(judged, _BIAS),
        *_true_effects(judged),
        *_common(judged),
    ]  # fmt: skip


def bad_figures(judged: Sequence[BadJudged]) -> list[Figure]:
    """Figures of cases with bad readings, in the order of their table."""
    seconds = [case.seconds for case in judged if np.isfinite(case.seconds)]
    return [
        _certified("a confident false cause", (case.false_cause for case in judged), 0.02),
        share("the fault is named where it is", (case.found for case in judged)),
        share("the verdict of the case without its fault", (case.right for case in judged)),
        summary("processor time of a diagnosis, median [s]", seconds, np.median),
        share("diagnoses that failed", (bool(case.error) for case in judged)),
    ]


def by_family(judged: Sequence[Judged]) -> list[Figure]:
    """Share that is right by true cause, of what can be named."""
    plain = [c for c in judged if c.d_name >= PLAIN]
    return [
        share(name, (c.right for c in plain if c.family == name))
        for name in sorted({c.family for c in plain})
    ]


def by_fault(judged: Sequence[BadJudged]) -> list[Figure]:
    """Share without a confident false cause by fault."""
    return [
        share(name, (not c.false_cause for c in judged if c.fault == name))
        for name in sorted({c.fault for c in judged})
    ]
