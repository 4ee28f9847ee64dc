"""The diagnosis: runs and a nominal model in, where, which and how much out."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl

from locosweep import _core
from locosweep.diagnosis.data.checks import check_runs, usable
from locosweep.diagnosis.data.holdout import hold_out
from locosweep.diagnosis.data.regimes import regimes_of
from locosweep.diagnosis.design.next_experiment import next_experiment
from locosweep.diagnosis.effects.catalogue import candidates
from locosweep.diagnosis.effects.scale import scale_of
from locosweep.diagnosis.estimate.initial_state import moving_starts
from locosweep.diagnosis.estimate.least_squares import Nuisances, point_of
from locosweep.diagnosis.estimate.nominal import gaps_of
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.estimate.shooting import ShotProblem
from locosweep.diagnosis.estimate.window_plan import (
    for_planning,
    plan_of,
    problem_of,
    scale_in_windows,
)
from locosweep.diagnosis.report import localization as where
from locosweep.diagnosis.report import sentences
from locosweep.diagnosis.report.identifiability import not_visible
from locosweep.diagnosis.report.improvement import gap_of, started
from locosweep.diagnosis.report.model_file import calibrated
from locosweep.diagnosis.report.result import Diagnosis, Trace
from locosweep.diagnosis.report.windowed import ShotReport
from locosweep.diagnosis.select.nearest import nearest
from locosweep.diagnosis.select.search import Search
from locosweep.diagnosis.select.verdict import choose
from locosweep.diagnosis.select.whiteness import stray_readings
from locosweep.engine import whole
from locosweep.errors import InputError
from locosweep.files.robot import Robot, load_robot
from locosweep.files.runs import Run, load_runs, runs_from_frame
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping, Sequence

    from locosweep.diagnosis.effects.scale import Scale
    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Point
    from locosweep.diagnosis.select.nearest import Nearest
    from locosweep.diagnosis.select.verdict import Choice

__all__ = ["diagnose"]

_CANDIDATES = 8
"""Candidates that the report shows."""


def diagnose(
    runs: str | os.PathLike[str] | pl.DataFrame | Mapping[str, Any],
    nominal: str | os.PathLike[str] | Robot,
    *,
    holdout: Sequence[str] | None = None,
    max_effects: int = 3,
    seed: int = 0,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    threads: int | None = None,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """Say where measured runs leave their nominal model, and which effect makes them.

    Parameters
    ----------
    runs : path-like, polars.DataFrame or mapping of str to array
        Measured runs, long form: columns t, drive and x, and if measured run, v,
        x_rear, force, power, slope_deg (SI units).
    nominal : path-like or Robot
        The nominal model (`load_robot`).
    holdout : sequence of str, optional
        Runs kept from fits and choice; chosen by the program if not given.
    max_effects : int
        Effects at once, at most: 1 to 3.
    seed : int
        Of the resampling that intervals come from.
    columns, units : mapping of str to str, optional
        As in `locosweep.files.runs.load_runs`; only where `runs` is a file.
    threads : int, optional
        As in `sweep`. The report does not depend on it.
    progress : callable, optional
        Is told what is being done.

    Returns
    -------
    Diagnosis
        The report and all that its pictures need.

    Raises
    ------
    InputError, DataFileError
        What was wrong with an argument or a file, in one line.

    Examples
    --------
    >>> import numpy as np
    >>> import locosweep as ls
    >>> from locosweep.files.robot import Robot
    >>> robot = Robot({"mass": 0.2, "mu_coulomb": 0.3, "gravity": 9.81, "segments": 4.0})
    >>> t = np.linspace(0.0, 1.0, 101)
    >>> drive = np.where(t > 0.1, 0.5, 0.0)
    >>> noise = np.random.default_rng(0).normal(0.0, 1e-5, t.size)
    >>> ls.diagnose({"t": t, "drive": drive, "x": noise}, robot).status
    'none'
    """
    if not 1 <= max_effects <= 3:
        raise InputError(f"max_effects is {max_effects}: allowed is 1 to 3")
    say = progress or (lambda _: None)
    workers = _core.threads_to_use(whole("threads", threads))
    robot = nominal if isinstance(nominal, Robot) else load_robot(nominal)
    if robot.effects:
        given = ", ".join(robot.effects)
        raise InputError(f"the nominal model has effects ({given}): allowed is a model without")
    say("reading")
    records, notices, digest = _read(runs, columns or {}, units or {})
    records, missing = usable(records)
    warnings = [*notices, *missing, *check_runs(records, robot)]
    problem = Problem(robot, records, workers)
    scale = scale_of(robot, records)
    gaps = gaps_of(problem, Nuisances((), _spread(robot), scale.speed))
    held, tail, by_user = hold_out(records, holdout, gaps)
    uncut = problem = replace(problem, held=held, tail=tail)
    shots = None
    if plan := plan_of(uncut):
        problem = problem_of(uncut, plan, warnings)
        scale = scale_in_windows(scale, robot, problem)
        shots = ShotReport(uncut, plan)
    names, left_out = candidates(robot, {c for run in records for c in run.channels})
    spread = _spread(robot)
    search = _search_of(problem, spread, scale, names, say, judges=not by_user)
    choice = choose(search, max_effects)
    quiet = choice.status == "none"
    if (quiet or choice.refuted) and held and not by_user and shots is None:
        # What few runs leave open to an uncertain model, the others may refute; and what
        # shows in one run alone, that run has to show.
        problem = replace(uncut, held=())
        every = _search_of(problem, spread, scale, names, say, judges=True)
        every.hints = search.fits
        found = choose(every, max_effects)
        if choice.refuted or found.status != "none":
            search, choice = every, found
            said = "show a gap that the others do not"
            said = said if quiet else "refute what the others allow"
            warnings.append(
                f"the runs kept from the fit {said}: all are fitted, "
                "and how far the gap shrinks on unseen ones is not known"
            )
    elif choice.refuted and choice.fit.model.names:
        warnings.append("the runs kept from the fit refute what the others allow")
        sure = float(np.clip(1.0 - choice.probability, 0.5, 0.95))
        choice = replace(choice, status="unexplained", probability=sure)
    if shots is None and choice.status != "unexplained":
        warnings += stray_readings(search.problem, choice.fit.residual)
    say("where the gap lies")
    return _report(search, choice, (robot, nominal), (digest, seed), warnings, left_out, shots)


def _search_of(
    problem: Problem,
    spread: tuple[float, float, float, float],
    scale: Scale,
    names: Sequence[str],
    say: Callable[[str], None],
    *,
    judges: bool,
) -> Search:
    """Return a search with the nuisances of its runs."""
    places = tuple(enumerate(problem.priors["x"].tolist())) if problem.placed else ()
    problem.pace = scale.speed
    nuisances = Nuisances((), spread, scale.speed, places)
    if not isinstance(problem, ShotProblem):
        problem.starting = moving_starts(problem, nuisances)
        free = tuple(r for r in problem.starting if r not in problem.held)
        nuisances = replace(nuisances, moving=free)
    return Search(problem, nuisances, scale, tuple(names), say, judges=judges)


def _read(
    runs: Any, columns: Mapping[str, str], units: Mapping[str, str]
) -> tuple[list[Run], list[str], str]:
    if isinstance(runs, pl.DataFrame):
        frame = runs
    elif hasattr(runs, "items"):
        try:
            frame = pl.DataFrame({str(k): np.asarray(v) for k, v in runs.items()})
        except (TypeError, ValueError, pl.exceptions.PolarsError) as error:
            raise InputError(f"runs: not columns of one length: {error}") from None
    else:
        records, notices = load_runs(runs, columns, units)
        return records, notices, hashlib.sha256(Path(runs).read_bytes()).hexdigest()
    if columns or units:
        raise InputError("columns and units: allowed only where runs is a file")
    digest = hashlib.sha256(frame.write_csv().encode()).hexdigest()
    return runs_from_frame(frame), [], digest


def _spread(robot: Robot) -> tuple[float, float, float, float]:
    """Return the deviations that the nominal file allows; 0 where its value is exact."""
    keys = ("mass", "mu_coulomb", "gain", "clock")
    found = [float(robot.other.get(f"uncertainty.{key}", 0.0)) for key in keys]
    return found[0], found[1], found[2], found[3]


def _report(
    search: Search,
    choice: Choice,
    model: tuple[Robot, Any],
    provenance: tuple[str, int],
    warnings: list[str],
    left_out: Mapping[str, str],
    shots: ShotReport | None,
) -> Diagnosis:
    problem = search.problem
    robot, given = model
    named = choice.status in ("explained", "ambiguous")
    fit = choice.fit if named else search.none
    nominal_point = _as_given(search, choice)
    point = point_of(problem, fit) if named else nominal_point
    chosen = fit.named() if named else {}
    augmented = calibrated(robot, point, chosen) if named else robot
    digest, seed = provenance
    near = nearest(search) if shots is not None and choice.status == "unexplained" else None
    if shots is not None:
        gap = shots.gap(nominal_point, point, seed, warnings)
        places = shots.places(nominal_point, point, gap["channel"])
        nearer = point_of(problem, near.fit) if near else point
        rows = shots.runs(nominal_point, nearer, gap["channel"])
        warnings += shots.said_of_runs(rows, gap["channel"])
        warnings += shots.said_of_windows(nearer, gap["channel"])
        traces, whole = shots.traces(nominal_point, point), shots.whole
    else:
        explained = named and not choice.law_mismatch
        gap, places, traces = _whole_runs(
            problem, (nominal_point, point), seed, warnings, explained=explained
        )
        whole = problem
    effects_of = list(fit.model.names) if named else []
    effects_of = _by_weight(search, fit) if len(effects_of) > 1 else effects_of
    order = [choice.fit.model.names.index(name) for name in effects_of]
    site = effect(effects_of[0]).site if effects_of else None
    classes = [choice.classes[i] for i in order] if named else []
    verdict: dict[str, Any] = {
        "status": choice.status,
        "effects": effects_of,
        "probability": choice.probability,
        "equivalent": classes,
        "alternatives": choice.sets,
        "law_mismatch": choice.law_mismatch,
        "summary": "",
    }
    report: dict[str, Any] = {
        "schema": "locosweep.diagnosis/1",
        "verdict": verdict,
        "gap": gap,
        "where": {**places, "site": site},
        "candidates": _candidates(search, choice, gap, seed, shots, near),
        "not_visible": not_visible(search, left_out),
        "next_experiment": _next(search, choice, whole),
        "warnings": warnings,
        "provenance": {
            "locosweep": _core.version(),
            "runs_sha256": digest,
            "nominal_sha256": _digest_of(given, robot),
            "seed": seed,
            "largest_rest": {
                "channel": choice.lack.channel,
                "samples": choice.lack.block,
                "deviations": choice.lack.deviations,
            },
            "start_speed_free": [problem.runs[r].label for r in search.nuisances.moving],
        },
    }
    if choice.unlisted:
        verdict["unlisted"] = {"variable": choice.unlisted, "effects": list(choice.fit.model.names)}
    if near:
        part = shots.without_worst(nominal_point, nearer, gap["channel"]) if shots else None
        verdict["nearest"] = {**near.told(), "shrink_without_worst": part, "runs": rows}
    elif shots is not None and choice.status == "unexplained":
        verdict["nearest"] = None
    if choice.shape:
        report["gap"]["left"] = [{"variable": v, "share": s} for v, s in choice.shape[:5]]
    verdict["summary"] = sentences.summary(report)
    details: dict[str, Any] = {
        "noise": {c: n.sd for c, n in problem.noise.items()},
        "force_view": where.force_view(whole, nominal_point, problem.nominal["mass"]),
    }
    if not isinstance(given, Robot):
        details["nominal_text"] = Path(given).read_text(encoding="utf-8")
    return Diagnosis(report, traces, robot, augmented, details)


def _as_given(search: Search, choice: Choice) -> Point:
    """Return the nominal model as handed in; refitted where that accounts for the runs."""
    found = point_of(search.problem, search.none)
    return (
        found if choice.status == "none" else replace(found, shares=search.problem.plain().shares)
    )


def _whole_runs(
    problem: Problem,
    points: tuple[Point, Point],
    seed: int,
    warnings: list[str],
    *,
    explained: bool,
) -> tuple[dict[str, Any], dict[str, Any], tuple[Trace, ...]]:
    """Return gap, places and curves of runs that are replayed from end to end."""
    nominal, point = (started(problem, one) for one in points)
    if nominal.names != point.names:
        nominal = replace(nominal, speeds=point.speeds, places=point.places)
    gap, tables = gap_of(problem, nominal, point, seed, warnings)
    everything = list(range(len(problem.runs)))
    before = problem.replay([nominal], everything)
    after = problem.replay([point], everything)
    channel = gap["channel"]
    squares = where.gap_squares(problem, channel, before, after if explained else None)
    regimes = [regimes_of(problem, r) for r in everything]
    places = {
        "channels": tables["channels"],
        "runs": tables["runs"],
        "windows": where.windows(problem, squares),
        "origin": where.origin(problem, nominal),
        "regimes": where.regime_shares(squares, regimes),
    }
    return gap, places, _traces(problem, before, after, regimes)


def _by_weight(search: Search, fit: Fit) -> list[str]:
    """Effects of a set by what the fit loses without each, first what it loses most."""
    from locosweep.diagnosis.estimate.least_squares import evaluate

    losses = []
    for name in fit.model.names:
        keep = [i for i, f in enumerate(fit.model.free) if f.effect != name]
        tail = list(range(len(fit.model.free), fit.theta.size))
        rest = search.model([n for n in fit.model.names if n != name])
        without = type(fit)(rest, fit.nuisances, fit.theta[keep + tail])
        evaluate(search.problem, [without])
        losses.append(without.chi2)
    order = np.argsort(-np.array(losses), kind="stable")
    return [fit.model.names[i] for i in order]


def _candidates(
    search: Search,
    choice: Choice,
    gap: dict[str, Any],
    seed: int,
    shots: ShotReport | None,
    near: Nearest | None,
) -> list[dict[str, Any]]:
    rows = []
    shown = list(choice.ranked[:_CANDIDATES])
    if near:
        shown = near.weighed([f for f, _ in shown], len(search.problem.fitted))[:_CANDIDATES]
    chosen = frozenset(choice.fit.model.names)
    if not any(frozenset(f.model.names) == chosen for f, _ in shown):
        shown += [pair for pair in choice.ranked if frozenset(pair[0].model.names) == chosen]
    points = [point_of(search.problem, f) for f, _ in shown]
    nominal = _as_given(search, choice)
    if shots is None:
        nominal = started(search.problem, nominal)
    for (fit, weight), point in zip(shown, points, strict=True):
        if shots is None:
            problem = search.problem
            own, _ = gap_of(
                problem, nominal, started(problem, point), seed, [], channel=gap["channel"]
            )
        else:
            own = shots.gap(nominal, point, seed, [], channel=gap["channel"])
        parameters: dict[str, dict[str, Any]] = {name: {} for name in fit.model.names}
        for f, value, std in zip(fit.model.free, fit.parameters, fit.stds, strict=True):
            size = np.inf if f.log else f.size
            parameters[f.effect][f.name] = {
                "value": float(value),
                "std": float(std) if std < 1e3 * max(size, abs(value)) else None,
                "unit": f.unit,
            }
        rows.append(
            {
                "effects": list(fit.model.names),
                "probability": float(weight),
                "gap_after": own["after"],
                "shrink": own["shrink"],
                "shrink_ci": own["shrink_ci"],
                "parameters": parameters,
            }
        )
    return rows


def _next(search: Search, choice: Choice, whole: Problem) -> dict[str, Any]:
    if choice.status != "ambiguous":
        return {"separates": [], "suggestion": None}
    rivals = []
    for place, name in enumerate(choice.fit.model.names):
        for other in choice.classes[place]:
            key = frozenset(other if n == name else n for n in choice.fit.model.names)
            if other != name and key in search.fits:
                rivals.append(search.fits[key])
    rivals += [search.fits[frozenset(s)] for s in choice.sets if frozenset(s) in search.fits]
    if not rivals:
        return {"separates": [], "suggestion": None}
    search.report("next experiment")
    fits = [choice.fit, *rivals]
    known = {frozenset(fit.model.names): weight for fit, weight in choice.ranked}
    weights = [known.get(frozenset(fit.model.names), 0.0) for fit in fits]
    if whole is not search.problem:
        search = for_planning(search, whole)
    return next_experiment(search, fits, weights)


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


def _digest_of(given: Any, robot: Robot) -> str:
    if isinstance(given, Robot):
        return hashlib.sha256(repr(robot).encode()).hexdigest()
    return hashlib.sha256(Path(given).read_bytes()).hexdigest()
