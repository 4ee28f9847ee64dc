"""The report: what was found about the runs, put together section by section."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.diagnosis.data.regimes import regimes_of
from locosweep.diagnosis.estimate.least_squares import evaluate, point_of
from locosweep.diagnosis.report import localization, sentences
from locosweep.diagnosis.report.comparison import compare_whole_runs
from locosweep.diagnosis.report.contributions import (
    Chain,
    chain_of,
    contributions,
    graded_contributions,
    graded_remaining,
    remaining,
)
from locosweep.diagnosis.report.free_runs import errors_by_length
from locosweep.diagnosis.report.identifiability import not_visible
from locosweep.diagnosis.report.improvement import gap_of, reduction
from locosweep.diagnosis.report.laws_found import laws_of_causes, unlisted_entry
from locosweep.diagnosis.report.model_file import calibrated
from locosweep.diagnosis.report.result import Diagnosis, Trace
from locosweep.diagnosis.report.units import rotary_unit
from locosweep.diagnosis.report.windowed import report_windows
from locosweep.diagnosis.select.shape import shape_of, shapes
from locosweep.diagnosis.select.stepwise import without
from locosweep.files.robot import Robot
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from locosweep.diagnosis.data.readings.finding import Finding
    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Point, Problem
    from locosweep.diagnosis.estimate.window_plan import WindowPlan
    from locosweep.diagnosis.report.comparison import Comparison
    from locosweep.diagnosis.select.graded import Graded
    from locosweep.diagnosis.select.search import Search
    from locosweep.diagnosis.select.verdict import Choice

_CANDIDATES = 8
"""Candidates that the report shows."""


@dataclass(frozen=True)
class Source:
    """Origin of the runs and of the nominal model."""

    robot: Robot
    given: Any
    """The nominal model as handed in: a path or a Robot."""
    runs_sha256: str
    seed: int
    runs: Any = None
    """The runs as handed in: a path, or columns."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """What was asked for beside them."""

    @property
    def nominal_sha256(self) -> str:
        """Checksum of the nominal file, or of the model's text where there is none."""
        if isinstance(self.given, Robot):
            return hashlib.sha256(repr(self.robot).encode()).hexdigest()
        return hashlib.sha256(Path(self.given).read_bytes()).hexdigest()


@dataclass(frozen=True)
class Findings:
    """Results of the steps before the report."""

    search: Search
    choice: Choice
    whole: Problem
    """The runs as they were measured."""
    plan: WindowPlan | None
    """Plan of the windows that they were cut into, if they were."""
    graded: Graded | None
    """Causes beside what nobody explains, where no set of effects leaves but noise."""
    kept_by_user: bool
    """True if the user chose the runs that are kept from fits: shares are of these."""
    next_experiment: dict[str, Any]
    left_out: Mapping[str, str]
    """Effects that have no meaning on this rig, and why."""
    warnings: tuple[str, ...]
    readings: tuple[Finding, ...] = ()
    """Faults of readings."""
    unlisted: str = ""
    """Variable of a force that no effect stands for and that does better than any, if any."""
    alike: str = ""
    """Variable of such a force that would do the same as a cause in these runs, if any."""

    @property
    def named(self) -> bool:
        """True if the verdict names effects."""
        return self.choice.status in ("explained", "ambiguous", "partial")

    @property
    def nominal(self) -> Point:
        """The nominal model as handed in; refitted where that accounts for the runs."""
        found = point_of(self.search.problem, self.search.none)
        if self.choice.status == "none":
            return found
        return replace(found, factors=self.search.problem.plain().factors)

    @property
    def augmented(self) -> Point:
        """The model with the effects that are named; the nominal one without any."""
        if not self.named:
            return self.nominal
        return point_of(self.search.problem, self.choice.fit)


def assemble(found: Findings, source: Source) -> Diagnosis:
    """Return the report of what was found, with both models and the curves of the runs."""
    choice, problem = found.choice, found.search.problem
    windows = report_windows(found.whole, found.plan) if found.plan else None
    compare = windows.compare if windows else partial(compare_whole_runs, found.whole)
    comparison = compare(found.nominal, found.augmented)
    gap = gap_of(comparison, source.seed)
    explained = found.named and not choice.law_mismatch
    where = localization.where_of(comparison, gap["channel"], explained=explained)
    classes = _classes(found) if found.named else []
    effects = [alike[0] for alike in classes]
    graded = found.graded if choice.status == "partial" and not found.kept_by_user else None
    chain = None
    if classes:
        chain = chain_of(found.search, choice.known, choice.fit, classes, alone=not graded)
    shares = []
    if graded:
        shares = graded_contributions(graded, source.seed)
    elif chain:
        shares = _contributions(found, chain, compare, gap["channel"], source.seed)
    verdict: dict[str, Any] = {
        "status": choice.status,
        "effects": effects,
        "probability": choice.probability,
        "equivalent": classes,
        "alternatives": choice.sets,
        "law_mismatch": choice.law_mismatch,
        "contributions": shares,
        "remaining": _remaining(found, gap),
        "unlisted": unlisted_entry(found),
        "laws": laws_of_causes(found),
        "summary": "",
    }
    report: dict[str, Any] = {
        "schema": "locosweep.diagnosis/2",
        "verdict": verdict,
        "gap": gap,
        "where": {**where, "site": effect(effects[0]).site if effects else None},
        "candidates": _candidates(found, compare, gap["channel"], source.seed, effects),
        "not_visible": not_visible(found.search, choice.known, found.left_out),
        "next_experiment": found.next_experiment,
        "readings": [one.row() for one in found.readings],
        "warnings": list(found.warnings),
        "provenance": _provenance(found, source),
    }
    if gap["shrink"] is None and comparison.validates and not comparison.same:
        report["warnings"].append(sentences.no_gap("windows" if windows else "runs"))
    if windows:
        count = len(windows.problem.runs)
        report["warnings"] += sentences.odd_windows(comparison, gap["channel"], count)
    verdict["summary"] = sentences.summary(report)
    later = {
        chain.classes[i][0]: compare(point_of(problem, fit), found.augmented)
        for i, fit in enumerate(chain.fits)
    } if chain else {}  # fmt: skip
    details: dict[str, Any] = {
        "noise": {c: n.sd for c, n in problem.noise.items()},
        "force_view": localization.force_view(found.whole, found.nominal, problem.nominal["mass"]),
        "free_runs": errors_by_length(comparison, later, gap["channel"]),
        # The last one is the augmented model.
        "stages": {name: one.readings[0] for name, one in list(later.items())[:-1]},
    }
    # Not in the report: the same input gives the same report.
    details["made"] = _today()
    if not isinstance(source.given, Robot):
        details["nominal_text"] = Path(source.given).read_text(encoding="utf-8")
    augmented = source.robot
    if found.named:
        augmented = calibrated(source.robot, found.augmented, choice.fit.named())
    return Diagnosis(report, _traces(comparison), source.robot, augmented, details)


def _classes(found: Findings) -> list[list[str]]:
    """Return the classes of the named effects, most important first."""
    choice = found.choice
    if choice.status == "partial":
        return choice.classes
    own = dict(zip(choice.fit.model.names, choice.classes, strict=True))
    return [own[name] for name in _by_importance(found.search, choice.fit)]


def _contributions(
    found: Findings,
    chain: Chain,
    compare: Callable[[Point, Point], Comparison],
    channel: str,
    seed: int,
) -> list[dict[str, Any]]:
    problem = found.search.problem
    graded = found.graded if found.choice.status == "partial" else None
    rows = contributions(problem, found.nominal, chain, compare, channel, seed=seed)
    for row, cause in zip(rows, graded.causes if graded else (), strict=False):
        row["agrees_between_runs"] = cause.agrees
    return rows


def _remaining(found: Findings, gap: dict[str, Any]) -> dict[str, Any]:
    shape = _shape(found)
    graded = found.graded if found.choice.status == "partial" else None
    if graded and not found.kept_by_user:
        return graded_remaining(graded, found.search.problem.noise["x"].sd, shape)
    return remaining(gap, shape)


def _shape(found: Findings) -> list[dict[str, Any]]:
    """Return what would carry the rest, where more than noise is left."""
    if found.graded is not None:
        return shape_of(found.graded.problem, found.graded.last.fit)
    return shapes(found.choice.shape)


def _traces(comparison: Comparison) -> tuple[Trace, ...]:
    problem = comparison.problem
    before, after = comparison.readings
    return tuple(
        Trace(
            run.label,
            run.t,
            run.drive,
            problem.nominal["slope_deg"] if run.slope_deg is None else run.slope_deg,
            dict(run.channels),
            {c: rows[r] for c, rows in before.items()},
            {c: rows[r] for c, rows in after.items()},
            regimes_of(problem.motions[r]),
            r in problem.held,
        )
        for r, run in enumerate(problem.runs)
    )


def _by_importance(search: Search, fit: Fit) -> list[str]:
    """Return the effects of a set by what the fit loses without each, the most first."""
    names = fit.model.names
    if len(names) < 2:
        return list(names)
    fewer = evaluate(search.problem, [without(search, fit, name) for name in names])
    order = np.argsort([-one.chi2 for one in fewer], kind="stable")
    return [names[i] for i in order]


def _candidates(
    found: Findings,
    compare: Callable[[Point, Point], Comparison],
    channel: str,
    seed: int,
    named: Sequence[str],
) -> list[dict[str, Any]]:
    """Return the best sets of effects, with their parameters and what they leave.

    Each set stands once, at the weight of its best fit, its effects in the order of the verdict
    and then by name.
    """
    problem, choice = found.search.problem, found.choice
    best: dict[frozenset[str], tuple[Fit, float]] = {}
    for fit, weight in choice.ranked:
        key = frozenset(fit.model.names)
        if key not in best or fit is choice.fit:
            best[key] = (fit, max(weight, best.get(key, (fit, 0.0))[1]))
    chosen = frozenset(choice.fit.model.names)
    shown = list(best.values())[:_CANDIDATES]
    if chosen in best and best[chosen] not in shown:
        shown.append(best[chosen])
    place = {name: i for i, name in enumerate(named)}
    rotary = "gravity_torque" in problem.nominal
    rows = []
    for fit, weight in shown:
        names = sorted(fit.model.names, key=lambda name: (place.get(name, len(place)), name))
        gap = reduction(compare(found.nominal, point_of(problem, fit)), channel, seed)
        rows.append(
            {
                "effects": names,
                "probability": float(weight),
                "gap_after": gap["after"],
                "shrink": gap["shrink"],
                "shrink_ci": gap["shrink_ci"],
                "parameters": _parameters(fit, rotary=rotary),
            }
        )
    return rows


def _parameters(fit: Fit, *, rotary: bool) -> dict[str, dict[str, Any]]:
    parameters: dict[str, dict[str, Any]] = {name: {} for name in fit.model.names}
    for f, value, std in zip(fit.model.free, fit.parameters, fit.stds, strict=True):
        size = np.inf if f.log else f.size
        parameters[f.effect][f.name] = {
            "value": float(value),
            "std": float(std) if std < 1e3 * max(size, abs(value)) else None,
            "unit": rotary_unit(f.unit) if rotary else f.unit,
        }
    return parameters


def _today() -> str:
    """Return the day; that of SOURCE_DATE_EPOCH, where builds that repeat set it."""
    fixed = os.environ.get("SOURCE_DATE_EPOCH", "")
    now = datetime.now(UTC)
    if fixed.isascii() and fixed.isdigit():
        now = datetime.fromtimestamp(int(fixed), UTC)
    return now.date().isoformat()


def _file_name(given: Any) -> str | None:
    """Return the name of a file that was handed in; None for what is in memory."""
    return Path(given).name if isinstance(given, str | os.PathLike) else None


def _provenance(found: Findings, source: Source) -> dict[str, Any]:
    whiteness, runs = found.choice.whiteness, found.search.problem.runs
    return {
        "locosweep": _core.version(),
        "runs_file": _file_name(source.runs),
        "runs_sha256": source.runs_sha256,
        "nominal_file": _file_name(source.given),
        "nominal_sha256": source.nominal_sha256,
        "seed": source.seed,
        "options": dict(source.options),
        "largest_rest": {
            "channel": whiteness.channel,
            "samples": whiteness.block,
            "deviations": whiteness.deviations,
        },
        "start_speed_free": [runs[r].label for r in found.search.nuisances.moving],
    }
