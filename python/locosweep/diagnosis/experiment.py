"""The next experiment: which further run would tell apart what is left."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.diagnosis.fit import Fit, evaluate, fit_all, point_of, start_fits
from locosweep.diagnosis.noise import Noise
from locosweep.diagnosis.problem import FITTED, Problem
from locosweep.diagnosis.starts import starts_of
from locosweep.measured import Run

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from locosweep.diagnosis.search import Search

__all__ = ["FORCE_NOISE", "MENU", "PAYLOAD", "RESOLVED", "next_experiment"]

RESOLVED = 9.0
"""Squared distance, in deviations, from which two explanations are told apart."""
PAYLOAD, _INCLINE = 1.3, 5.0
FORCE_NOISE = 0.01
"""Of a force sensor that is added, in the drive's largest force."""
_SHOWN = 4
_BESIDE = 3
"""Runs so far that rivals have to go on explaining: those with the longest motion."""


def _reversed(run: Run, _: float) -> Run:
    return replace(run, drive=-run.drive)


def _same(run: Run, _: float) -> Run:
    return run


def _turned(run: Run, slope: float) -> Run:
    return replace(run, slope_deg=-(slope if run.slope_deg is None else run.slope_deg))


def _inclined(run: Run, slope: float) -> Run:
    return replace(run, slope_deg=(slope if run.slope_deg is None else run.slope_deg) + _INCLINE)


def _slower(run: Run, _: float) -> Run:
    return replace(run, t=run.t[0] + 3.0 * (run.t - run.t[0]))


def _dwelling(run: Run, _: float) -> Run:
    """Pause four times, for a tenth of the run's length."""
    step = float(np.median(np.diff(run.t)))
    pause = max(1, run.t.size // 10)
    parts = np.array_split(run.drive, 5)
    drive = np.concatenate([part for p in parts for part in (p, np.zeros(pause))][:-1])
    return replace(run, t=run.t[0] + step * np.arange(drive.size), drive=drive, channels={})


def _chirp(run: Run, _: float) -> Run:
    t = run.since_start
    span = max(float(t[-1]), 1e-9)
    top = float(np.abs(run.drive).max())
    last = 0.1 / max(float(np.median(np.diff(t))), 1e-9)
    turns = 0.3 / span * t * span + 0.5 * (min(last, 20.0) - 0.3) * t**2 / span
    return replace(run, drive=top * np.sin(2.0 * np.pi * turns))


MENU: tuple[tuple[str, Callable[[Run, float], Run], str], ...] = (
    ("reverse", _reversed, "drive it backward: the same run with the opposite drive"),
    ("turn round", _turned, "turn the robot round on the same ground and repeat the run"),
    ("payload", _same, "repeat the run with a known payload of 30 % of the head's mass"),
    ("incline", _inclined, "repeat the run on ground that is 5 degrees steeper"),
    ("slower", _slower, "repeat the run three times slower"),
    ("dwell", _dwelling, "repeat the run with four pauses without drive"),
    ("chirp", _chirp, "a chirp from 0.3 Hz upward with the run's largest drive"),
    ("force sensor", _same, "repeat the run with a sensor of the force between drive and head"),
)


def next_experiment(search: Search, fit: Fit, rivals: Sequence[Fit]) -> dict[str, Any]:
    """Simulate a menu of runs and say which one tells `fit` from its rivals.

    A distance is the least sum of squares, in deviations of the noise, that a rival
    leaves of what `fit` predicts for the runs so far and the new one together.
    """
    separates = [sorted(set(fit.model.names) ^ set(rival.model.names)) for rival in rivals]
    rows: list[dict[str, Any]] = []
    for name, change, text in MENU:
        distance = _distance(search, fit, rivals, name, change)
        if distance is not None:
            rows.append({"run": name, "distance": float(np.sqrt(distance)), "what": text})
    rows.sort(key=lambda row: -row["distance"])
    best = rows[0] if rows else None
    if best is None or best["distance"] ** 2 < RESOLVED:
        missing = "no motion of this rig in the menu can separate these"
        return {"separates": separates, "suggestion": missing, "possible": False, "menu": rows}
    return {
        "separates": separates,
        "suggestion": f"{best['what']} (expected distance {best['distance']:.0f} deviations)",
        "possible": True,
        "menu": rows[:_SHOWN],
    }


def _distance(
    search: Search,
    fit: Fit,
    rivals: Sequence[Fit],
    name: str,
    change: Callable[[Run, float], Run],
) -> float | None:
    problem = search.problem
    if name == "force sensor" and "force" in problem.channels:
        return None
    if "gravity_torque" in problem.nominal and name in ("turn round", "incline"):
        return None
    moved = [float(np.nanmax(r.channels["x"]) - np.nanmin(r.channels["x"])) for r in problem.runs]
    pattern = problem.runs[int(np.argmax(moved))]
    run = replace(change(pattern, problem.nominal["slope_deg"]), label="next")
    noise = dict(problem.noise)
    channels = list(problem.channels)
    if name == "force sensor":
        deviation = FORCE_NOISE * search.scale.force
        noise["force"] = Noise(deviation, deviation, 0.0, stated=False)
        channels.append("force")
    far = sorted(problem.fitted, key=lambda r: (-moved[r], r))[:_BESIDE]
    runs = [problem.runs[r] for r in sorted(far)]
    place = len(runs)
    blank = [_blank(r, channels) for r in runs] + [_blank(run, channels)]
    if name == "force sensor":
        for r in blank[:-1]:
            r.channels["force"] = np.full(r.t.size, np.nan)
    planned = Problem(
        problem.robot,
        blank,
        problem.threads,
        known=noise,
        heavier={place: PAYLOAD} if name == "payload" else {},
        turned=frozenset({place}) if name == "turn round" else frozenset(),
    )
    nuisances = replace(fit.nuisances, moving=(), places=())
    own = len(fit.model.free) + len(nuisances.shares)
    truth = Fit(fit.model, nuisances, fit.theta[:own])
    read = planned.replay([point_of(planned, truth)], range(place + 1))
    for c in planned.channels:
        gaps = np.isnan(planned.measured[c])
        planned.measured[c] = np.where(gaps, np.nan, read[c][0])
        if name == "force sensor" and c == "force":
            planned.measured[c][: planned.starts_at[place]] = np.nan
            planned.weights[c][: planned.starts_at[place]] = 0.0
    trials = []
    for rival in rivals:
        theta = rival.theta[: len(rival.model.free) + len(nuisances.shares)]
        trials.append(Fit(rival.model, nuisances, theta.copy()))
        new = [n for n in rival.model.names if n not in fit.model.names]
        if len(rival.model.names) == 1 and new:
            rows = starts_of(new[0], search.scale)
            more = start_fits(nuisances, rival.model, rows)
            # What the runs so far say is in the rival's own start.
            evaluate(planned, more, [place])
            for start in more:
                start.residual = np.zeros(0)
            trials.extend(sorted(more, key=lambda f: f.chi2)[:2])
    fit_all(planned, trials, steps=8)
    worst: dict[tuple[str, ...], float] = {}
    for trial in trials:
        key = trial.model.names
        worst[key] = min(worst.get(key, np.inf), trial.chi2)
    return max(min(worst.values()), 0.0)


def _blank(run: Run, channels: Sequence[str]) -> Run:
    """Return a run whose readings are still to be made up; x starts where it started."""
    x0 = run.start[0] if run.channels else 0.0
    made = {c: np.zeros(run.t.size) for c in channels if c in FITTED}
    made["x"] = np.full(run.t.size, x0)
    return Run(run.label, run.t, run.drive, made, run.slope_deg)
