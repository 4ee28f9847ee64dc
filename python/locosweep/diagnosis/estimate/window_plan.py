"""When runs are replayed in windows, how long these are, and which take part in fits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.noise import Noise
from locosweep.diagnosis.effects.scale import scale_of
from locosweep.diagnosis.estimate.free_run import free_errors
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.estimate.shooting import WindowProblem, cut, knows_start
from locosweep.diagnosis.estimate.windows import (
    LEAD,
    LEAST,
    TURNS,
    chosen_windows,
    growth_rates,
    spread,
    windows_along,
)
from locosweep.errors import DataFileError
from locosweep.files.channels import CHANNELS
from locosweep.files.runs import Run

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.effects.scale import Scale
    from locosweep.files.robot import Robot

    Floats = NDArray[np.float64]

GROWTH = 2.5
"""Exponent by which a start's error may grow along a run: beyond it, twelvefold, the
error of a free run says more about its start than about the model."""
LONG = 10.0
"""Seconds from which a run is long: a free run over them is asked of no simulator."""
ROWS = 100_000
LONG_ROWS = 15_000
"""Samples of all runs, and of long ones, above which a search over whole runs takes too long."""
REACH = 0.1
"""Error of a free run over the motion in it, up to which fits follow it."""
ASTRAY, NEAR = 1.0, 0.5
"""Error of a free run over the motion in it, from which a plant that falls over has gone
elsewhere than its model, and up to which windows of it are near enough for a fit."""
_SAMPLES = 64
"""Samples of a window that are enough: denser runs are decimated."""
_UNSEEN = 0.05
"""Part of the noise by which thinning may shift the motion."""
FITTED_SAMPLES, HELD_SAMPLES = 2_000, 2_000
"""Samples that take part in a search, and in its check."""
GRADED_SAMPLES = 5_000
"""Samples in which models are compared beside a rest: fits that begin near their ends see more."""
_PLANNED = 1_000
"""Samples of a run that a next one is compared with."""
_WINDOWS = 40
"""Windows that are tried to find out how far free runs reach."""


@dataclass(frozen=True)
class WindowPlan:
    """Windows of `seconds`, because of `why`; `noise` of each channel."""

    seconds: float
    why: str
    noise: dict[str, Noise]


def plan_of(whole: Problem) -> WindowPlan | None:
    """Say how runs are cut into windows; None where they are replayed as a whole."""
    runs = whole.runs
    growth = max(_growth(run, whole.nominal) for run in runs)
    longest = max(float(run.t[-1] - run.t[0]) for run in runs)
    noise = {c: _as_seen(whole, c) for c in whole.channels}
    if growth > GROWTH:
        fastest = max(float(growth_rates(run, whole.nominal).max()) for run in runs)
        factor = f"{np.exp(growth):.2g} times" if growth < 7.0 else "more than a thousandfold"
        why = f"small errors grow {factor} along a run"
        return WindowPlan(_fitting(runs, TURNS / fastest), why, noise)
    many = whole.count > (LONG_ROWS if longest > LONG else ROWS)
    if longest <= LONG and not many:
        return _astray(whole, longest, noise)
    reach = _reach(whole, longest)
    if reach >= longest and not many:
        return None
    why = f"runs last up to {longest:.3g} s"
    if many:
        why = f"the runs have {whole.count} samples"
        # As long as it takes to go there and back.
        travel = [np.ptp(x[np.isfinite(x)]) / _pace(run)
                  for run in runs for x in [run.channels["x"]]]  # fmt: skip
        reach = min(reach, 2.0 * float(np.median(travel)))
    return WindowPlan(_fitting(runs, reach), why, noise)


def _astray(whole: Problem, longest: float, noise: dict[str, Noise]) -> WindowPlan | None:
    """Cut the runs of a plant that may fall over where its nominal model goes elsewhere."""
    if "gravity_torque" not in whole.nominal:
        return None
    error, motion = _compare(whole, longest)
    if error <= ASTRAY * motion:
        return None
    why = f"the nominal model goes astray by {error / motion:.2g} times the motion"
    return WindowPlan(_fitting(whole.runs, _reach(whole, longest, NEAR)), why, noise)


def _pace(run: Run) -> float:
    ok = np.isfinite(run.channels["x"])
    t, x = run.t[ok], run.channels["x"][ok]
    stride = max(1, x.size // 400)
    slopes = np.abs(np.diff(x[::stride]) / np.diff(t[::stride]))
    return max(float(np.quantile(slopes, 0.9)), 1e-9) if slopes.size else 1e-9


def _fitting(runs: Sequence[Run], seconds: float) -> float:
    """Make a window long enough for its samples, and a run hold several."""
    step = max(float(np.median(np.diff(run.t))) for run in runs)
    shortest = min(float(run.t[-1] - run.t[0]) for run in runs)
    return float(np.clip(seconds, LEAST * step, max(0.25 * shortest, LEAST * step)))


def _growth(run: Run, nominal: dict[str, float]) -> float:
    rates = growth_rates(run, nominal)
    return float(np.sum(rates[:-1] * np.diff(run.t)))


def _as_seen(whole: Problem, channel: str) -> Noise:
    """Return the noise as stated, or as large as readings show it: files often understate it."""
    stated = whole.noise[channel]
    thirds = [np.diff(y[np.isfinite(y)], 3) for run in whole.runs
              if (y := run.channels.get(channel)) is not None]  # fmt: skip
    thirds = [np.abs(third) for third in thirds if third.size >= 8]
    if not thirds:
        return stated
    seen = float(np.median([np.median(third) for third in thirds])) / 0.6745 / np.sqrt(20.0)
    if seen <= stated.sd:
        return stated
    return replace(stated, sd=float(seen), gaussian=float(max(seen, stated.gaussian)))


def _reach(whole: Problem, longest: float, share: float = REACH) -> float:
    """Longest free run whose error stays below a share of the motion in it."""
    step = float(np.median([np.median(np.diff(run.t)) for run in whole.runs]))
    seconds = longest
    while seconds > 2.0 * LEAST * step:
        error, motion = _compare(whole, seconds)
        if error <= share * motion:
            break
        seconds *= 0.5
    return seconds


def _compare(whole: Problem, seconds: float) -> tuple[float, float]:
    """Root mean squares of error and motion in nominal free runs of some length.

    Of those whose start and something behind it was measured; 0 where there are none.
    """
    cuts = []
    for r, run in enumerate(whole.runs):
        since = run.since_start
        marks = np.arange(0.0, max(since[-1] - seconds, 0.0) + 0.5 * seconds, seconds)
        for a in np.searchsorted(since, marks):
            b = int(np.searchsorted(since, since[a] + seconds, side="right"))
            known = knows_start(run, int(a), LEAD * seconds)
            if b - a >= 5 and known and np.isfinite(run.channels["x"][a:b]).any():
                cuts.append((r, int(a), b))
    if not cuts:
        return 0.0, 0.0
    cuts = [cuts[i] for i in spread(len(cuts), _WINDOWS)]
    errors, motions = [], []
    for (r, a, b), e in zip(cuts, free_errors(whole, whole.plain(), cuts), strict=True):
        x = whole.runs[r].channels["x"][a:b]
        errors.append(e[np.isfinite(e)])
        motions.append((x - x[np.isfinite(x)][0])[np.isfinite(x)])
    error, motion = np.concatenate(errors), np.concatenate(motions)
    return float(np.sqrt(np.mean(error**2))), float(np.sqrt(np.mean(motion**2)))


def _interval(whole: Problem, plan: WindowPlan) -> float:
    """Longest interval between samples that windows need.

    A drive F that is taken as its mean over an interval D shifts the motion by
    F D^2 / (12 m): that has to stay well below the noise.
    """
    drives = np.concatenate([run.drive for run in whole.runs]) * whole.nominal["gain"]
    force = max(float(np.sqrt(np.mean(drives**2))), 1e-12)
    shift = _UNSEEN * plan.noise["x"].sd
    exact = float(np.sqrt(12.0 * shift * whole.nominal["mass"] / force))
    return min(plan.seconds / _SAMPLES, exact)


def decimated(run: Run, interval: float) -> Run:
    """Take every k-th sample of a run that is denser than windows need.

    The drive, and the force that follows it, are means over what is left out: that
    keeps their impulse.
    """
    step = float(np.median(np.diff(run.t)))
    k = int(1.0001 * interval / step)
    if k < 2:
        return run
    # Of a sensor that is read more rarely than the drive, the samples that have a reading.
    read = np.isfinite(run.channels["x"])
    phase = int(np.argmax([np.count_nonzero(read[i::k]) for i in range(k)]))
    starts = np.arange(phase, run.t.size, k)
    run = run if phase == 0 else _from(run, phase)
    starts -= phase
    width = np.append(np.diff(run.t), step)

    def mean(values: Floats) -> Floats:
        ok = np.isfinite(values)
        top = np.add.reduceat(np.where(ok, values * width, 0.0), starts)
        bottom = np.add.reduceat(np.where(ok, width, 0.0), starts)
        return np.where(bottom > 0.0, top / np.where(bottom > 0.0, bottom, 1.0), np.nan)

    channels = {c: mean(y) if CHANNELS[c].averaged else y[starts]
                for c, y in run.channels.items()}  # fmt: skip
    bounds = run.drive_deviation
    if bounds is not None:
        # Rows of one gap err together.
        bounds = np.add.reduceat(bounds * width, starts) / np.add.reduceat(width, starts)
    return Run(run.label, run.t[starts], mean(run.drive), channels, run.slope_deg, bounds)


def _leads(runs: Sequence[Run], seconds: float) -> list[int]:
    steps = [float(np.median(np.diff(run.t))) for run in runs]
    return [max(2, round(LEAD * seconds / step)) for step in steps]


def adjoining_windows(
    whole: Problem, plan: WindowPlan, runs: Sequence[int] | None = None
) -> WindowProblem:
    """Cut runs into windows from end to end, as they were measured, for the report."""
    leads = _leads(whole.runs, plan.seconds)
    windows = [
        (r, a, b)
        for r in (range(len(whole.runs)) if runs is None else runs)
        for a, b in windows_along(whole.runs[r], leads[r], plan.seconds, whole.nominal)
    ]
    return _problem(whole, whole.runs, windows, leads, plan, ())


def problem_of(
    whole: Problem, plan: WindowPlan, fitted_samples: int = FITTED_SAMPLES
) -> tuple[WindowProblem, str]:
    """Choose the windows of the search and of its check; say in a sentence how runs were cut.

    About `fitted_samples` samples take part in fits.
    """
    interval = _interval(whole, plan)
    runs = [decimated(run, interval) for run in whole.runs]
    leads = _leads(runs, plan.seconds)
    fitted: dict[int, list[tuple[int, int, int]]] = {}
    held: dict[int, list[tuple[int, int, int]]] = {}
    for r, run in enumerate(runs):
        for a, b in windows_along(run, leads[r], plan.seconds, whole.nominal):
            kept = r in whole.held or (
                whole.train_fraction < 1.0 and b > whole.train_fraction * run.t.size
            )
            (held if kept else fitted).setdefault(r, []).append((r, a, b))
    if not fitted:
        raise DataFileError(
            f"runs: no window of {plan.seconds:.3g} s has enough values of x, from its start on"
        )
    noise = plan.noise["x"].sd
    chosen = chosen_windows(runs, fitted, fitted_samples, noise)
    checked = chosen_windows(runs, held, HELD_SAMPLES, noise)
    total = sum(len(w) for part in (fitted, held) for w in part.values())
    dense = [old.t.size // new.t.size for old, new in zip(whole.runs, runs, strict=True)]
    said = (
        f"runs are replayed in windows of {plan.seconds:.3g} s from the measured state: {plan.why}"
    )
    if len(chosen) + len(checked) < total:
        said += (
            f"; {len(chosen)} windows of {total} take part in the fit, {len(checked)} in its check"
        )
    if max(dense) > 1:
        said += f"; one sample in {max(dense)} of the densest run"
    windows = [*chosen, *checked]
    held_windows = tuple(range(len(chosen), len(windows)))
    return _problem(whole, runs, windows, leads, plan, held_windows), said


def _problem(
    whole: Problem,
    runs: Sequence[Run],
    windows: Sequence[tuple[int, int, int]],
    leads: Sequence[int],
    plan: WindowPlan,
    held: tuple[int, ...],
) -> WindowProblem:
    half = LEAD * plan.seconds
    return WindowProblem(
        whole.robot,
        cut(runs, windows, leads, plan.noise, half),
        whole.threads,
        held=held,
        known=plan.noise,
        records=tuple(runs),
    )


def scale_in_windows(scale: Scale, robot: Robot, problem: WindowProblem) -> Scale:
    """Return a rig's scale where its runs are replayed in windows."""
    own = scale_of(robot, problem.runs)
    return replace(
        scale, speed=max(own.speed, scale.speed), interval=own.interval, replayed=own.duration
    )


def for_planning(whole: Problem) -> Problem:
    """Return the first windows of whole runs, which start at rest as a planned run does."""
    runs = []
    for run in whole.runs:
        ok = np.isfinite(run.channels["x"])
        far = np.abs(run.channels["x"] - run.start[0]) > 0.1 * np.ptp(run.channels["x"][ok])
        begins = int(np.argmax(far & ok))
        runs.append(_first(run, begins))
    return Problem(whole.robot, runs, whole.threads, known=whole.noise)


def _first(run: Run, begins: int) -> Run:
    a = max(0, begins - _PLANNED // 2)
    return _from(run, a, a + _PLANNED)


def _from(run: Run, a: int, end: int | None = None) -> Run:
    """Return a part of a run."""
    channels = {name: values[a:end] for name, values in run.channels.items()}
    bounds = None if run.drive_deviation is None else run.drive_deviation[a:end]
    return Run(run.label, run.t[a:end], run.drive[a:end], channels, run.slope_deg, bounds)
