"""The report: what was found about the runs, put together section by section."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.diagnosis.data.regimes import regimes_of
from locosweep.diagnosis.estimate.least_squares import evaluate, point_of
from locosweep.diagnosis.report import localization, sentences
from locosweep.diagnosis.report.identifiability import not_visible
from locosweep.diagnosis.report.improvement import gap_of, started
from locosweep.diagnosis.report.model_file import calibrated
from locosweep.diagnosis.report.result import Diagnosis, Trace
from locosweep.diagnosis.report.windowed import ShotReport
from locosweep.diagnosis.select.stepwise import without
from locosweep.files.robot import Robot
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    from collections.abc import Mapping

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Point, Problem
    from locosweep.diagnosis.estimate.window_plan import Plan
    from locosweep.diagnosis.select.nearest import Nearest
    from locosweep.diagnosis.select.search import Search
    from locosweep.diagnosis.select.verdict import Choice

_CANDIDATES = 8
"""Candidates that the report shows."""


@dataclass(frozen=True)
class Source:
    """Where the runs and the nominal model come from."""

    robot: Robot
    given: Any
    """The nominal model as handed in: a path or a Robot."""
    runs_sha256: str
    seed: int

    @property
    def nominal_sha256(self) -> str:
        """Checksum of the nominal file, or of the model's text where there is none."""
        if isinstance(self.given, Robot):
            return hashlib.sha256(repr(self.robot).encode()).hexdigest()
        return hashlib.sha256(Path(self.given).read_bytes()).hexdigest()


@dataclass(frozen=True)
class Findings:
    """What the steps before the report have found."""

    search: Search
    choice: Choice
    whole: Problem
    """The runs as they were measured."""
    plan: Plan | None
    """How they were cut into windows, if they were."""
    nearest: Nearest | None
    """The set that comes nearest, where none of a gap in windows is confirmed."""
    next_experiment: dict[str, Any]
    left_out: Mapping[str, str]
    """Effects that have no meaning on this rig, and why."""
    warnings: tuple[str, ...]

    @property
    def named(self) -> bool:
        """Whether the verdict names effects."""
        return self.choice.status in ("explained", "ambiguous")

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


@dataclass(frozen=True)
class _Located:
    """The sections on size and place of the gap, and the curves behind them."""

    gap: dict[str, Any]
    where: dict[str, Any]
    traces: tuple[Trace, ...]
    warnings: list[str]
    nearest: dict[str, Any] | None = None


def assemble(found: Findings, source: Source) -> Diagnosis:
    """Return the report of what was found, with both models and the curves of the runs."""
    choice = found.choice
    windows = ShotReport(found.whole, found.plan) if found.plan else None
    located = _in_windows(found, windows, source) if windows else _in_whole_runs(found, source)
    effects = _by_importance(found.search, choice.fit) if found.named else []
    classes = dict(zip(choice.fit.model.names, choice.classes, strict=False))
    verdict: dict[str, Any] = {
        "status": choice.status,
        "effects": effects,
        "probability": choice.probability,
        "equivalent": [classes[name] for name in effects],
        "alternatives": choice.sets,
        "law_mismatch": choice.law_mismatch,
        "summary": "",
    }
    report: dict[str, Any] = {
        "schema": "locosweep.diagnosis/1",
        "verdict": verdict,
        "gap": located.gap,
        "where": {**located.where, "site": effect(effects[0]).site if effects else None},
        "candidates": _candidates(found, windows, located.gap["channel"], source.seed),
        "not_visible": not_visible(found.search, choice.known, found.left_out),
        "next_experiment": found.next_experiment,
        "warnings": [*found.warnings, *located.warnings],
        "provenance": _provenance(found, source),
    }
    if choice.unlisted:
        verdict["unlisted"] = {"variable": choice.unlisted, "effects": list(choice.fit.model.names)}
    if windows and choice.status == "unexplained":
        verdict["nearest"] = located.nearest
    if choice.shape:
        report["gap"]["left"] = [{"variable": v, "share": s} for v, s in choice.shape[:5]]
    verdict["summary"] = sentences.summary(report)
    whole, problem = found.whole, found.search.problem
    details: dict[str, Any] = {
        "noise": {c: n.sd for c, n in problem.noise.items()},
        "force_view": localization.force_view(whole, found.nominal, problem.nominal["mass"]),
    }
    if not isinstance(source.given, Robot):
        details["nominal_text"] = Path(source.given).read_text(encoding="utf-8")
    augmented = source.robot
    if found.named:
        augmented = calibrated(source.robot, found.augmented, choice.fit.named())
    return Diagnosis(report, located.traces, source.robot, augmented, details)


def _in_windows(found: Findings, windows: ShotReport, source: Source) -> _Located:
    """Return gap, places and curves of runs that are replayed in windows."""
    warnings: list[str] = []
    nominal, point, near = found.nominal, found.augmented, found.nearest
    gap = windows.gap(nominal, point, source.seed, warnings)
    channel = gap["channel"]
    nearer = point_of(found.search.problem, near.fit) if near else point
    rows = windows.runs(nominal, nearer, channel)
    warnings += windows.said_of_runs(rows, channel)
    warnings += windows.said_of_windows(nearer, channel)
    told = None
    if near:
        part = windows.without_worst(nominal, nearer, channel)
        told = {**near.told(), "shrink_without_worst": part, "runs": rows}
    places = windows.places(nominal, point, channel)
    return _Located(gap, places, windows.traces(nominal, point), warnings, told)


def _in_whole_runs(found: Findings, source: Source) -> _Located:
    """Return gap, places and curves of runs that are replayed from end to end."""
    problem, warnings = found.search.problem, list[str]()
    nominal, point = started(problem, found.nominal), started(problem, found.augmented)
    if nominal.names != point.names:
        nominal = replace(nominal, speeds=point.speeds, start_offsets=point.start_offsets)
    gap, tables = gap_of(problem, nominal, point, source.seed, warnings)
    before, after = (problem.replay([one], range(len(problem.runs))) for one in (nominal, point))
    explained = found.named and not found.choice.law_mismatch
    squares = localization.gap_squares(
        problem, gap["channel"], before, after if explained else None
    )
    regimes = [regimes_of(motion) for motion in problem.motions]
    places = {
        "channels": tables["channels"],
        "runs": tables["runs"],
        "windows": localization.windows(problem, squares),
        "origin": localization.origin(problem, nominal),
        "regimes": localization.regime_shares(squares, regimes),
    }
    return _Located(gap, places, _traces(problem, before, after, regimes), warnings)


def _traces(
    problem: Problem, before: dict[str, Any], after: dict[str, Any], regimes: list[Any]
) -> tuple[Trace, ...]:
    traces = []
    for r, run in enumerate(problem.runs):
        a, b = problem.starts_at[r], problem.starts_at[r + 1]
        traces.append(
            Trace(
                run.label,
                run.t,
                run.drive,
                problem.nominal["slope_deg"] if run.slope_deg is None else run.slope_deg,
                dict(run.channels),
                {c: read[0, a:b] for c, read in before.items()},
                {c: read[0, a:b] for c, read in after.items()},
                regimes[r],
                r in problem.held,
            )
        )
    return tuple(traces)


def _by_importance(search: Search, fit: Fit) -> list[str]:
    """Return the effects of a set by what the fit loses without each, the most first."""
    names = fit.model.names
    if len(names) < 2:
        return list(names)
    fewer = evaluate(search.problem, [without(search, fit, name) for name in names])
    order = np.argsort([-one.chi2 for one in fewer], kind="stable")
    return [names[i] for i in order]


def _candidates(
    found: Findings, windows: ShotReport | None, channel: str, seed: int
) -> list[dict[str, Any]]:
    """Return the best sets of effects, with their parameters and what they leave."""
    problem, choice = found.search.problem, found.choice
    shown = list(choice.ranked[:_CANDIDATES])
    if found.nearest:
        fits = [fit for fit, _ in shown]
        shown = found.nearest.weighed(fits, len(problem.fitted))[:_CANDIDATES]
    chosen = frozenset(choice.fit.model.names)
    if not any(frozenset(fit.model.names) == chosen for fit, _ in shown):
        shown += [pair for pair in choice.ranked if frozenset(pair[0].model.names) == chosen]
    nominal = found.nominal if windows else started(problem, found.nominal)
    rows = []
    for fit, weight in shown:
        point = point_of(problem, fit)
        if windows:
            gap = windows.gap(nominal, point, seed, [], channel=channel)
        else:
            gap, _ = gap_of(problem, nominal, started(problem, point), seed, [], channel=channel)
        rows.append(
            {
                "effects": list(fit.model.names),
                "probability": float(weight),
                "gap_after": gap["after"],
                "shrink": gap["shrink"],
                "shrink_ci": gap["shrink_ci"],
                "parameters": _parameters(fit),
            }
        )
    return rows


def _parameters(fit: Fit) -> dict[str, dict[str, Any]]:
    parameters: dict[str, dict[str, Any]] = {name: {} for name in fit.model.names}
    for f, value, std in zip(fit.model.free, fit.parameters, fit.stds, strict=True):
        size = np.inf if f.log else f.size
        parameters[f.effect][f.name] = {
            "value": float(value),
            "std": float(std) if std < 1e3 * max(size, abs(value)) else None,
            "unit": f.unit,
        }
    return parameters


def _provenance(found: Findings, source: Source) -> dict[str, Any]:
    whiteness, runs = found.choice.whiteness, found.search.problem.runs
    return {
        "locosweep": _core.version(),
        "runs_sha256": source.runs_sha256,
        "nominal_sha256": source.nominal_sha256,
        "seed": source.seed,
        "largest_rest": {
            "channel": whiteness.channel,
            "samples": whiteness.block,
            "deviations": whiteness.deviations,
        },
        "start_speed_free": [runs[r].label for r in found.search.nuisances.moving],
    }
