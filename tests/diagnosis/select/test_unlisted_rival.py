"""Forces that no effect stands for: which causes they refute, and which not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from diagnosis_search import fits_of
from locosweep.diagnosis.estimate.least_squares import fit_all, start_fits
from locosweep.diagnosis.select import unlisted_rival as module
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.search import Collection
from locosweep.diagnosis.select.unlisted_rival import unlisted_rival
from locosweep.files.runs import Run
from test_diagnosis import ROBOT, drives, measured


def sprung(runs: list[Run], stiffness: float) -> pl.DataFrame:
    """Runs that a weak spring pulls back to the start, told without it."""
    nominal = measured({}, runs)
    pulled = [
        replace(
            run,
            drive=run.drive
            - stiffness * nominal.filter(pl.col("run") == run.label)["x"].to_numpy(),
        )
        for run in runs
    ]
    told = pl.Series(np.concatenate([run.drive for run in runs]))
    return measured({}, pulled).with_columns(drive=told)


def laws_take(monkeypatch: pytest.MonkeyPatch, gains: dict[str, float]) -> None:
    """Let laws of variables take so much of chi2, those of others nothing, and a push nothing."""

    def factor(_: object, variables: list[str], __: float) -> float:
        return gains.get(variables[0], 0.0)

    monkeypatch.setattr(NonparametricCorrection, "log_bayes_factor", factor)
    monkeypatch.setattr(module, "noise_level", lambda *_: 1.0)
    monkeypatch.setattr(module.RestForce, "log_bayes_factor", lambda *_: -1e9)


def test_a_force_by_position_refutes_a_single_effect_that_it_outdoes() -> None:
    """A spring to the start is no friction that drifts; but a slope stays a slope."""
    runs = drives(count=5)
    names = ("friction_drift", "slope_error")
    spring = sprung(runs, 0.005)
    for frame, refuted in (
        (spring, "terrain"),
        (measured({"slope_error": {"d_alpha_deg": 0.05}}, runs), ""),
    ):
        search, fits = fits_of(ROBOT, frame, *names)
        found = min(fits, key=search.score)
        known = Collection({frozenset(): search.none})
        assert search.none.chi2 - found.chi2 > 100.0
        rival, _ = unlisted_rival(search, known, found, search.score(found), mismatch=False)
        assert rival == refuted


def test_friction_along_a_way_passed_in_one_direction_is_not_refuted_by_a_force_by_place() -> None:
    """The same spring both ways is no friction."""
    for forward in (True, False):
        runs = [replace(r, drive=np.abs(r.drive) if forward else r.drive) for r in drives(count=5)]
        spring = sprung(runs, 0.02)
        search, (found,) = fits_of(ROBOT, spring, "position_dependent_friction")
        known = Collection({frozenset(): search.none})
        score = search.score(found)
        rival, _ = unlisted_rival(search, known, found, score, mismatch=False)
        assert (rival == "terrain") == (not forward)


def test_beside_another_cause_such_friction_is_not_refuted_either() -> None:
    rough = {"position_dependent_friction": {"a": 0.02, "L": 0.05, "p": 0.3}}
    names = ("position_dependent_friction", "sensor_drift")
    runs = [replace(run, drive=np.abs(run.drive)) for run in drives(count=5)]
    frame = measured({**rough, "sensor_drift": {"b": 2e-3}}, runs)
    search, fits = fits_of(ROBOT, frame, *names)
    model = search.model(names)
    truth = np.array([[0.02, 0.05, 0.3, 2e-3]])
    (found,) = fit_all(search.problem, start_fits(search.nuisances, model, truth), steps=20)
    known = Collection({frozenset({"sensor_drift"}): fits[1]})
    # As if the two did no better than the drift alone.
    score = search.score(fits[1])
    assert unlisted_rival(search, known, found, score, mismatch=False)[0] != "terrain"


@pytest.mark.parametrize(("by_speed", "refuted"), [(125.0, ""), (110.0, "terrain")])
def test_a_law_in_place_of_its_formula_is_not_refuted_by_another_force(
    by_speed: float, refuted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A force of any form that takes 100 of chi2, 10 more than a law beside the formula."""
    search, (fit,) = fits_of(
        ROBOT, measured({"quadratic_drag": {"c2": 0.05}}, drives(count=5)), "viscous_friction"
    )
    laws_take(monkeypatch, {"speed": by_speed, "terrain": 100.0})
    known = Collection({frozenset(): search.none})
    score = search.score(search.none) - 90.0
    assert unlisted_rival(search, known, fit, score, mismatch=True)[0] == refuted


@pytest.mark.parametrize(("by_drive", "refuted"), [(105.0, ""), (85.0, "acceleration")])
def test_a_force_by_acceleration_refutes_only_what_no_listed_variable_does_as_well(
    by_drive: float, refuted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that takes 110 of chi2, 20 more than the effect that was found."""
    search, (fit,) = fits_of(
        ROBOT, measured({"viscous_friction": {"c": 0.05}}, drives(count=5)), "viscous_friction"
    )
    laws_take(monkeypatch, {"drive": by_drive, "acceleration": 110.0})
    known = Collection({frozenset(): search.none})
    score = search.score(search.none) - 90.0
    assert unlisted_rival(search, known, fit, score, mismatch=False)[0] == refuted


def test_a_push_of_each_runs_own_refutes_what_does_no_better() -> None:
    """Friction that drifts takes much of a push that grows; drag comes again in every run."""
    runs = drives(count=5)
    pushed = [
        replace(run, drive=run.drive + 0.02 * np.sin(1.5 * run.t + 2.0 * i) * run.t)
        for i, run in enumerate(runs)
    ]
    told = pl.Series(np.concatenate([r.drive for r in runs]))
    names = ("viscous_friction", "friction_drift", "slope_error")
    for frame, refuted in (
        (measured({}, pushed).with_columns(drive=told), "push"),
        (measured({"viscous_friction": {"c": 0.05}}, runs), ""),
    ):
        search, fits = fits_of(ROBOT, frame, *names)
        found = min(fits, key=search.score)
        assert search.none.chi2 - found.chi2 > 100.0
        # No force by place is asked for without what is known of the nominal model.
        known = Collection({})
        rival, _ = unlisted_rival(search, known, found, search.score(found), mismatch=False)
        assert rival == refuted
