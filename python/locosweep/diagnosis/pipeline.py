"""The diagnosis: data checks, effects, estimate, selection, report, design."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.diagnosis.data.checks import check_runs, usable
from locosweep.diagnosis.data.chosen import as_labels, chosen
from locosweep.diagnosis.data.gap_drives import told_by_motion
from locosweep.diagnosis.data.holdout import hold_out, known_labels
from locosweep.diagnosis.data.inputs import nominal_model, read_runs
from locosweep.diagnosis.data.noise import noise_warnings
from locosweep.diagnosis.data.readings.columns import check_columns
from locosweep.diagnosis.data.readings.drive_spikes import check_drives
from locosweep.diagnosis.data.readings.find import Checked, check_readings
from locosweep.diagnosis.data.readings.finding import sentences
from locosweep.diagnosis.design.next_experiment import back_again, next_experiment, once_more
from locosweep.diagnosis.effects.catalogue import candidates
from locosweep.diagnosis.effects.scale import scale_of
from locosweep.diagnosis.estimate.equation_error import EquationError, equation_error
from locosweep.diagnosis.estimate.initial_state import initial_states
from locosweep.diagnosis.estimate.least_squares import Nuisances
from locosweep.diagnosis.estimate.nominal import gaps_of, spread_of
from locosweep.diagnosis.estimate.problem import Problem, ReplayMeter
from locosweep.diagnosis.estimate.window_plan import (
    GRADED_SAMPLES,
    WindowPlan,
    for_planning,
    plan_of,
    problem_of,
    scale_in_windows,
)
from locosweep.diagnosis.report.assemble import Findings, Source, assemble
from locosweep.diagnosis.select import thresholds as limits
from locosweep.diagnosis.select.by_place import BY_PLACE, is_one_by_place, passes_both_ways
from locosweep.diagnosis.select.graded import (
    Graded,
    confirmed_on_kept,
    graded,
    predicts_kept,
    refitted,
)
from locosweep.diagnosis.select.isolated import isolated_readings
from locosweep.diagnosis.select.reading_steps import stepped_readings
from locosweep.diagnosis.select.search import Search
from locosweep.diagnosis.select.spectral_line import spectral_line
from locosweep.diagnosis.select.unlisted_rival import BY_TIME
from locosweep.diagnosis.select.verdict import (
    Choice,
    choose,
    kept_may_show_a_gap,
    leaving_line,
    partial_choice,
)
from locosweep.diagnosis.select.whiteness import stray_readings
from locosweep.engine import whole
from locosweep.errors import InputError
from locosweep.files.csv_form import CsvForm
from locosweep.linear_algebra import on_one_thread
from locosweep.progress import Steps, progress_of
from locosweep.simulation.replay import nominal_of, sensor_of

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Mapping, Sequence

    from locosweep.diagnosis.effects.scale import Scale
    from locosweep.diagnosis.report.result import Diagnosis
    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run
    from locosweep.progress import Progress


@on_one_thread
def diagnose(
    runs: Any,
    nominal: str | os.PathLike[str] | Robot,
    *,
    holdout: Sequence[str | int] | None = None,
    labels: Sequence[str | int] | None = None,
    max_effects: int = 2,
    seed: int = 0,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    threads: int | None = None,
    progress: bool | Progress | None = None,
) -> Diagnosis:
    """Say where measured runs leave their nominal model, and which effect makes them.

    Parameters
    ----------
    runs : path-like, list of path-like, or frame
        Measured runs, long form: columns t, drive and x, and if measured run, v,
        x_rear, force, power, slope_deg (SI units). Files, a folder of them or columns in memory
        (Polars, pandas, Arrow, mapping of arrays), as `locosweep.measured.load_runs` takes them.
    nominal : path-like or Robot
        The nominal model (`load_robot`).
    holdout : sequence of str, optional
        Labels of runs kept from fits and choice; chosen by the program if not given.
    labels : sequence of str, optional
        Labels of the runs that take part; all if not given. Numbers stand for the labels
        that a file has.
    max_effects : int
        Effects at once, at most: 1 to 3. With three, runs that two leave unexplained take
        longer, and a cause that is in no list may be named as three of the list.
    seed : int
        Of the resampling that intervals come from.
    columns, units : mapping of str to str, optional
        As in `locosweep.measured.load_runs`.
    separator, decimal : str, optional
        Of a CSV file, where its text leaves them open: ``"semicolon"``, ``"comma"``.
    threads : int, optional
        As in `sweep`. The report does not depend on it.
    progress : bool or callable, optional
        As in `sweep`; it counts steps, and its method ``say``, if it has one, receives the name
        of the step that begins.

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
    say = Steps(progress_of(progress, "diagnose", "steps"), _steps(max_effects))
    workers = _core.threads_to_use(whole("threads", threads))
    robot = nominal_model(nominal)
    say("reading")
    held, wanted = as_labels("holdout", holdout), as_labels("labels", labels)
    records, notices, digest = read_runs(
        runs, columns or {}, units or {}, robot, CsvForm(separator, decimal)
    )
    records = chosen(records, wanted)
    known_labels(records, held)
    checked = _reading_checks(robot, records)
    data = _prepared(robot, checked, held, workers)
    measured = {c for run in data.whole.runs for c in run.channels}
    names, left_out = candidates(robot, measured)
    task = _Task(tuple(names), max_effects, say)
    selected = _not_searched(data, task) if checked.hopeless else _select(data, task)
    if data.plan is None and not checked.hopeless:
        checked, data, selected = _without_late_findings(
            checked, data, selected, lambda left: _if_enough(robot, left, held, workers), task
        )
    alike = BY_PLACE if is_one_by_place(selected.search, selected.choice) else ""
    if alike and selected.choice.status == "explained":
        selected = replace(selected, choice=replace(selected.choice, status="ambiguous"))
    next_run = _next_experiment(selected, data, alike)
    say("where the gap lies")
    judged = data.whole if data.plan else selected.search.problem
    found = Findings(
        selected.search,
        selected.choice,
        whole=replace(judged, held=()) if selected.to_all else judged,
        plan=data.plan,
        graded=selected.graded,
        kept_by_user=data.held_by_user,
        next_experiment=next_run,
        left_out=left_out,
        readings=checked.findings,
        unlisted=selected.unlisted,
        alike=alike,
        warnings=(*notices, *data.warnings, *selected.warnings),
    )
    asked = {
        "holdout": held,
        "labels": wanted,
        "max_effects": max_effects,
        "columns": dict(columns or {}),
        "units": dict(units or {}),
    }
    report = assemble(found, Source(robot, nominal, digest, seed, runs, asked))
    say.end()
    return report


def _steps(most: int) -> list[str]:
    """Name the steps of a diagnosis in their order; a search may leave some out."""
    several = [f"{count} effects at once" for count in range(2, most + 1)]
    searched = ["single effects", *several, "rivals", "causes beside what nobody explains"]
    return ["reading", *searched, "next experiment", "where the gap lies"]


@dataclass(frozen=True)
class _Data:
    """Runs that passed the checks, and how fits see them."""

    whole: Problem
    """The runs as they were measured, with those kept from fits."""
    problem: Problem
    """The runs, or windows of them, that fits see."""
    scale: Scale
    plan: WindowPlan | None
    """Plan of the windows, if runs are cut."""
    held_by_user: bool
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class _Task:
    """Candidate effects, how many at once, and the callback of progress."""

    names: tuple[str, ...]
    max_effects: int
    say: Callable[[str], None]


@dataclass(frozen=True)
class _Selected:
    """The search that the verdict rests on."""

    search: Search
    choice: Choice
    warnings: tuple[str, ...] = ()
    graded: Graded | None = None
    """Causes beside what nobody explains, where no set of effects leaves but noise."""
    to_all: bool = False
    """True if the models were fitted to all runs, those kept for a check too."""

    @property
    def unlisted(self) -> str:
        """Variable of a force that no effect stands for and that does better than any, if any."""
        beside = self.graded.unlisted if self.graded else ""
        return beside or self.choice.unlisted


def _reading_checks(robot: Robot, records: Sequence[Run]) -> Checked:
    """Find bad readings, and mask those that can be done without."""
    known, missing = usable(records)
    known, drives = check_drives(known)
    columns = check_columns(known, robot)
    readings = Checked(columns.runs)
    if not columns.hopeless:
        readings = check_readings(columns.runs, nominal_of(robot), sensor_of(robot))
    findings = (*drives, *columns.findings, *readings.findings)
    return Checked(readings.runs, findings, tuple(missing))


def _prepared(robot: Robot, checked: Checked, holdout: Sequence[str] | None, workers: int) -> _Data:
    """Choose the runs that are kept from fits, and cut them where they are long."""
    runs, spoilt = usable(told_by_motion(checked.runs, robot))
    warnings = [*checked.warnings, *sentences(checked.findings), *spoilt]
    left = {run.label for run in runs}
    kept_labels = [label for label in holdout or () if label in left]
    warnings += [
        f"run {label} was to be kept from the fit: too few of its readings can be used"
        for label in holdout or ()
        if label not in left
    ]
    if not checked.hopeless:
        warnings += [*check_runs(runs, robot), *noise_warnings(runs, sensor_of(robot))]
    scale = scale_of(robot, runs)
    problem = Problem(robot, runs, workers, speed_scale=scale.speed)
    gaps = gaps_of(problem, Nuisances((), spread_of(robot), scale.speed))
    held, fraction, by_user = hold_out(runs, kept_labels, gaps)
    kept = replace(problem, held=held, train_fraction=fraction, meter=ReplayMeter())
    plan = None if checked.hopeless else plan_of(kept)
    if plan is None:
        return _Data(kept, kept, scale, None, by_user, tuple(warnings))
    windows, said = problem_of(kept, plan)
    scale = scale_in_windows(scale, robot, windows)
    return _Data(kept, windows, scale, plan, by_user, (*warnings, said))


def _if_enough(
    robot: Robot, checked: Checked, holdout: Sequence[str] | None, workers: int
) -> _Data | None:
    """Prepare runs from which readings were masked; None if too few are left."""
    try:
        return _prepared(robot, checked, holdout, workers)
    except InputError:
        return None


def _without_late_findings(
    checked: Checked,
    data: _Data,
    selected: _Selected,
    prepared: Callable[[Checked], _Data | None],
    task: _Task,
) -> tuple[Checked, _Data, _Selected]:
    """Mask the readings that only fits show to be bad, and choose again.

    `prepared` is None where too few readings would be left.
    """
    problem, choice = selected.search.problem, selected.choice
    if choice.status != "none":
        law = choice.law_mismatch
        flags, found = stepped_readings(problem, selected.search.none, choice.fit, other_law=law)
        if found:
            left = checked.without(flags, found)
            alone = prepared(left)
            again = _select(alone, task) if alone else None
            # Where a cause is named still, jumps may have stood in for it.
            if alone and again and again.choice.status in ("none", "unexplained"):
                return left, alone, again
    if choice.status == "partial":
        return checked, data, selected
    flags, found = isolated_readings(problem, choice.fit)
    if not found:
        return checked, data, selected
    left = checked.without(flags, found)
    alone = prepared(left)
    return (left, alone, _select(alone, task)) if alone else (checked, data, selected)


def _not_searched(data: _Data, task: _Task) -> _Selected:
    """Leave readings unexplained that no cause could make."""
    search = _search_of(data.problem, data.scale, replace(task, names=()), None, judges=False)
    choice = replace(choose(search, 1), status="unexplained", probability=limits.UNEXPLAINED_SURE)
    return _Selected(search, choice)


def _select(data: _Data, task: _Task) -> _Selected:
    """Choose the effects that the gap needs, on all runs where those kept disagree."""
    along = equation_error(replace(data.whole, meter=ReplayMeter()))
    search = _search_of(data.problem, data.scale, task, along, judges=not data.held_by_user)
    choice = choose(search, task.max_effects)
    selected = _Selected(search, choice)
    may_add = bool(data.whole.held) and not data.held_by_user and data.plan is None
    if may_add and (choice.refuted or kept_may_show_a_gap(search, choice)):
        selected = _fitted_to_all(data, task, selected)
    elif choice.refuted and choice.fit.model.names:
        sure = float(np.clip(1.0 - choice.probability, limits.TOSS_UP, limits.UNEXPLAINED_SURE))
        refuted = replace(
            choice,
            status="unexplained",
            probability=sure,
            classes=[],
            sets=[],
            law_mismatch=False,
        )
        said = "the readings kept from the fit refute what the others allow"
        selected = _Selected(search, refuted, (said,))
    problem, residual = selected.search.problem, selected.choice.fit.residual
    if line := spectral_line(problem, residual):
        found = leaving_line(selected.search, selected.choice, line)
        told = (*selected.warnings, line.told(problem))
        selected = replace(selected, choice=found, warnings=told)
    if selected.choice.status == "unexplained" and not selected.choice.outdone:
        return _graded(data, task, selected)
    if data.plan is None:
        stray = stray_readings(problem, residual)
        selected = replace(selected, warnings=(*selected.warnings, *stray))
    return selected


def _graded(data: _Data, task: _Task, first: _Selected) -> _Selected:
    """Name the causes that unseen runs confirm, where more than noise is left.

    All runs take part in the choice, each left out in turn, but those that the user keeps. The
    models that are named are fitted again without the runs kept from fits.
    """
    kept = problem_of(data.whole, data.plan, GRADED_SAMPLES)[0] if data.plan else data.whole
    alone = data.held_by_user or len(data.whole.runs) == 1
    every = kept if alone else replace(kept, held=())
    near = {frozenset[str](): first.search.none}
    search = _search_of(every, data.scale, task, None, judges=not data.held_by_user)
    search = replace(search, hints=near)
    found = graded(search, first.choice.known, task.max_effects)
    if not found.causes:
        return replace(first, graded=found)
    own = replace(_search_of(kept, data.scale, task, None, judges=False), hints=near)
    fits = refitted(own, found)
    if data.held_by_user:
        found = confirmed_on_kept(own, found, fits)
        if not found.causes:
            return replace(first, graded=found)
    choice = partial_choice(first.choice, found, fits)
    # Shares are of unseen runs now, whatever was said of fits to all.
    said_before = () if first.to_all else first.warnings
    if data.held_by_user or predicts_kept(own, choice.fit):
        return _Selected(own, choice, said_before, found)
    # What the kept runs say, each run left out in turn says as well, with one run less to fit.
    choice = partial_choice(first.choice, found, refitted(search, found))
    said = (
        "the runs kept from the fit say too little alone: models are fitted to all, and shares "
        "are of runs that are left out in turn"
    )
    return _Selected(search, choice, (*said_before, said), found, to_all=True)


def _fitted_to_all(data: _Data, task: _Task, first: _Selected) -> _Selected:
    """Choose again with no run kept from fits.

    Validation runs may refute what few runs leave open, or show what only they have.
    """
    problem = replace(data.whole, held=(), meter=ReplayMeter())
    search = _search_of(problem, data.scale, task, equation_error(problem), judges=True)
    search = replace(search, hints=first.choice.known.fits)
    choice = choose(search, task.max_effects)
    if choice.fit.model.names and choice.says == first.choice.says:
        said = (
            "the runs kept from the fit differ from their prediction by more than noise; "
            "the verdict is the same if all runs are fitted"
        )
        return replace(first, warnings=(said,))
    if not first.choice.refuted and choice.status == "none":
        return first
    said = "refute what the others allow"
    if not first.choice.refuted:
        what = "a gap" if first.choice.status == "none" else "a cause"
        said = f"show {what} that the others do not"
    said += ": all are fitted, and how far the gap shrinks on unseen ones is not known"
    return _Selected(search, choice, (f"the runs kept from the fit {said}",), to_all=True)


def _search_of(
    problem: Problem, scale: Scale, task: _Task, along: EquationError | None, *, judges: bool
) -> Search:
    """Return a search with the nuisances of its runs."""
    offsets = tuple(enumerate(problem.priors["x"].tolist())) if problem.position_matters else ()
    nuisances = Nuisances((), spread_of(problem.robot), scale.speed, offsets)
    if problem.starts_vary:
        problem = replace(problem, initial=initial_states(problem, nuisances))
        free = tuple(r for r in problem.starts.moving if r not in problem.held)
        nuisances = replace(nuisances, moving=free)
    return Search(problem, nuisances, scale, task.names, task.say, judges=judges, along=along)


def _next_experiment(selected: _Selected, data: _Data, alike: str) -> dict[str, Any]:
    """Say which further run would separate what ties."""
    search, choice = selected.search, selected.choice
    fits = choice.tied
    one_way = selected.unlisted == BY_PLACE and not passes_both_ways(data.whole)
    if one_way or (alike == BY_PLACE and len(fits) < 2):
        return back_again()
    if selected.unlisted == BY_TIME:
        return once_more(data.whole)
    if len(fits) < 2 or selected.unlisted == BY_PLACE:
        return {"separates": [], "suggestion": None}
    search.progress("next experiment")
    weights = [choice.weight(fit) for fit in fits]
    if data.plan:
        search = replace(search, problem=for_planning(data.whole))
    return next_experiment(search, fits, weights)
