"""Flexible terms: another law of an effect, and variables that no effect acts through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from locosweep.diagnosis import diagnose
from locosweep.diagnosis.effects.scale import scale_of
from locosweep.diagnosis.estimate.least_squares import Nuisances, fit_all, start_fits
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.select.law_mismatch import carried_by, carries
from locosweep.diagnosis.select.nonparametric import Flexible
from locosweep.diagnosis.select.search import Search
from locosweep.diagnosis.select.verdict import is_limit
from locosweep.files.runs import runs_from_frame
from test_diagnosis import ROBOT, drives, measured, tethered

FLAT = 1e4
"""Deviation of a fitted parameter's size: it may be anything."""


def terms_beside(frame: pl.DataFrame, *names: str) -> Flexible:
    """Terms beside the fit of some effects to measured runs."""
    records = runs_from_frame(frame)
    scale = scale_of(ROBOT, records)
    problem = Problem(ROBOT, records, 1, pace=scale.speed)
    nuisances = Nuisances((), (0.0, 0.0, 0.0, 0.0), scale.speed)
    search = Search(problem, nuisances, scale, names, lambda _: None)
    fit = search.none
    if names:
        model = search.model(names)
        fit = start_fits(nuisances, model, np.zeros((1, len(model.free))))[0]
        fit_all(problem, [fit], steps=20)
    return Flexible(problem, fit)


def log_density(
    terms: Flexible, variables: list[str], spread: float, places: np.ndarray | slice
) -> float:
    """Of residuals at some places, the sizes of terms and of fitted values integrated out."""
    own = np.isin(terms.names, variables)
    sizes = spread**2 * terms.alike * (own[:, None] & own)
    sizes += FLAT**2 * np.diag(terms.names == "fit")
    basis, residual = terms.basis[:, places], terms.residual[places]
    covariance = np.eye(residual.size) + basis.T @ sizes @ basis
    square = residual @ np.linalg.solve(covariance, residual)
    return -0.5 * float(square + np.linalg.slogdet(covariance)[1])


@pytest.mark.slow
@pytest.mark.parametrize("names", [(), ("coulomb_error",)])
def test_worth_is_the_ratio_of_marginal_likelihoods(names: tuple[str, ...]) -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=2, samples=80))
    terms = terms_beside(frame, *names)
    without = log_density(terms, [], 0.0, slice(None))
    for variable in ("speed", "drive", "place"):
        # The likeliest deviation, looked for without the decomposition that is tested.
        tried = [
            log_density(terms, [variable], spread, slice(None))
            for spread in np.geomspace(1e-6, 1.0, 61)
        ]
        assert terms.worth([variable], 1.0) == pytest.approx(
            2.0 * (max(tried) - without), rel=0.02, abs=0.3
        )


def test_runs_are_foretold_by_the_density_given_the_others() -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=3, samples=60))
    terms = terms_beside(frame)
    rows, root = terms._root(["speed"], 1.0)
    deviation = float(root[0, 0] / np.sqrt(terms.alike[rows[0], rows[0]]))
    gain = 0.0
    for place in terms._places:
        others = np.setdiff1d(np.arange(terms.residual.size), place)
        for sign, variables in ((1.0, ["speed"]), (-1.0, [])):
            whole = log_density(terms, variables, deviation, slice(None))
            gain += sign * 2.0 * (whole - log_density(terms, variables, deviation, others))
    assert terms.foreseen(["speed"], 1.0) == pytest.approx(gain, rel=1e-3)


def test_what_others_foretell_is_their_mean_over_its_deviation_given_the_others() -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=3, samples=60))
    terms = terms_beside(frame, "coulomb_error")
    rows, root = terms._root(["speed"], 1.0)
    deviation = float(root[0, 0] / np.sqrt(terms.alike[rows[0], rows[0]]))
    own = np.isin(terms.names, ["speed"])
    sizes = deviation**2 * terms.alike * (own[:, None] & own)
    sizes += FLAT**2 * np.diag(terms.names == "fit")
    covariance = np.eye(terms.residual.size) + terms.basis.T @ sizes @ terms.basis
    left = terms.foretold(["speed"], 1.0)
    for place, found in zip(terms._places, left, strict=True):
        others = np.setdiff1d(np.arange(terms.residual.size), place)
        known = np.linalg.solve(covariance[np.ix_(others, others)], terms.residual[others])
        missed = terms.residual[place] - covariance[np.ix_(place, others)] @ known
        told = np.linalg.solve(
            covariance[np.ix_(others, others)], covariance[np.ix_(others, place)]
        )
        unsure = covariance[np.ix_(place, place)] - covariance[np.ix_(place, others)] @ told
        values, vectors = np.linalg.eigh(unsure)
        expected = vectors @ ((vectors.T @ missed) / np.sqrt(values))
        np.testing.assert_allclose(found, expected, atol=2e-3 * np.abs(expected).max())


@pytest.mark.slow
def test_a_law_of_its_own_in_each_run_is_worth_the_ratio_of_marginal_likelihoods() -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=3, samples=60))
    terms = terms_beside(frame, "coulomb_error")
    own, fitted = terms.names == "speed", terms.names == "fit"
    run = np.zeros(terms.residual.size)
    for i, place in enumerate(terms._places):
        run[place] = i
    for_all = terms.basis.T @ (terms.alike * (own[:, None] & own)) @ terms.basis
    around = np.eye(run.size) + FLAT**2 * terms.basis[fitted].T @ terms.basis[fitted]

    def density(covariance: np.ndarray) -> float:
        square = terms.residual @ np.linalg.solve(covariance, terms.residual)
        return -float(square + np.linalg.slogdet(covariance)[1])

    tried = [
        density(around + spread**2 * for_all * (run[:, None] == run))
        for spread in np.geomspace(1e-6, 1.0, 61)
    ]
    assert terms.worth_apart(["speed"], 1.0) == pytest.approx(
        max(tried) - density(around), rel=0.02, abs=0.3
    )
    # The runs follow one law, and say so.
    assert terms.worth(["speed"], 1.0) > terms.worth_apart(["speed"], 1.0)


def test_what_no_run_confirms_is_no_law() -> None:
    """Friction along the way of waves that differ from run to run."""
    runs = drives(count=4)
    frames = [
        measured({"position_dependent_friction": {"a": 0.02, "L": 0.3, "p": 1.6 * i}}, [run])
        for i, run in enumerate(runs)
    ]
    terms = terms_beside(pl.concat(frames))
    assert terms.worth(["place"], 1.0) > 20.0
    assert terms.worth(["place"], 1.0) < terms.worth_apart(["place"], 1.0) - 12.0


def test_one_run_is_foretold_by_none() -> None:
    terms = terms_beside(measured({"quadratic_drag": {"c2": 0.3}}, drives(count=1)))
    assert terms.worth(["speed"], 1.0) > 100.0
    assert terms.foreseen(["speed"], 1.0) == 0.0


def test_what_does_not_come_again_is_not_foreseen() -> None:
    """A push at another time in every run: each bends a law of time, none foretells the next."""
    runs = drives(count=4)
    pushed = [
        replace(run, drive=run.drive + 0.1 * np.sin(5.0 * run.t + 1.7 * i))
        for i, run in enumerate(runs)
    ]
    frame = measured({}, pushed).with_columns(
        drive=pl.Series(np.concatenate([r.drive for r in runs]))
    )
    once = terms_beside(frame)
    again = terms_beside(measured({"friction_drift": {"a": 0.05, "T": 1.0}}, runs))
    assert once.worth(["time"], 1.0) > 100.0
    assert once.foreseen(["time"], 1.0) < 0.0 < again.foreseen(["time"], 1.0)


def fits_of(frame: pl.DataFrame, *names: str, held: tuple[int, ...] = ()) -> tuple[Search, list]:
    """Fits of single effects to measured runs, in the order of their names."""
    records = runs_from_frame(frame)
    scale = scale_of(ROBOT, records)
    problem = Problem(ROBOT, records, 1, held=held, pace=scale.speed)
    nuisances = Nuisances((), (0.0, 0.0, 0.0, 0.0), scale.speed)
    search = Search(problem, nuisances, scale, names, lambda _: None)
    fits = []
    for name in names:
        model = search.model((name,))
        fits += start_fits(nuisances, model, np.zeros((1, len(model.free))))
    fit_all(problem, fits, steps=20)
    return search, fits


def test_another_law_has_to_hold_in_the_runs_kept_from_the_fit() -> None:
    """The same law in all runs, and one run with a push of its own."""
    runs = drives(count=5)
    law = {"quadratic_drag": {"c2": 0.05}}
    frame = measured(law, runs)
    other = replace(runs[2], drive=runs[2].drive + 0.06 * np.sin(5.0 * runs[2].t))
    pushed = [*runs[:2], other, *runs[3:]]
    strange = measured(law, pushed).with_columns(
        drive=pl.Series(np.concatenate([r.drive for r in runs]))
    )
    found = []
    for one in (frame, strange):
        search, (fit,) = fits_of(one, "viscous_friction", held=(2,))
        found.append(carries(search, fit) is not None)
    assert found == [True, False]


def test_what_the_other_runs_cannot_tell_is_no_contradiction() -> None:
    """The run that is kept is faster than any other: what its law is there, they do not know."""
    runs = drives(count=4)
    runs.append(replace(runs[0], label="fast", drive=1.3 * runs[0].drive))
    frame = measured({"quadratic_drag": {"c2": 0.02}}, runs)
    search, (fit,) = fits_of(frame, "viscous_friction", held=(4,))
    assert carries(search, fit) is not None


def test_only_a_shape_has_a_limit_that_is_another_effect() -> None:
    search, _ = fits_of(measured({}, drives(count=2)), "coulomb_error")
    found = {}
    for name in ("drive_lag", "stribeck_friction"):
        model = search.model((name,))
        lowest = np.array([[f.low for f in model.free]])
        (fit,) = start_fits(search.nuisances, model, lowest)
        found[name] = is_limit(fit, name)
    # The shortest lag is next to nothing; a friction that falls at no speed is Coulomb's.
    assert found == {"drive_lag": False, "stribeck_friction": True}


def test_a_run_kept_from_the_fit_may_start_in_motion() -> None:
    runs = drives(count=5)
    whole = measured({"quadratic_drag": {"c2": 0.02}}, runs)
    frame = whole.filter((pl.col("run") != runs[4].label) | (pl.col("t") > 0.55))
    search, (fit,) = fits_of(frame, "viscous_friction", held=(4,))
    found = []
    for starting in ((), (4,)):
        search.problem.starting = starting
        found.append(carries(search, fit) is not None)
    assert found == [False, True]


def test_a_law_far_off_by_its_own_formula_is_found_behind_others() -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives())
    others = ("sensor_drift", "sensor_delay", "drive_lag", "drive_delay", "friction_drift")
    search, level = fits_of(
        frame, *others, "supply_sag", "position_dependent_friction", "viscous_friction"
    )
    found = carried_by(search, level)
    assert found is not None
    assert found[1].model.names == ("viscous_friction",)


@pytest.mark.slow
def test_an_effect_that_only_bends_another_ones_law_is_not_named() -> None:
    lag = {"drive_lag": {"T": 0.03}, "drive_delay": {"T": 5e-5}}
    found = diagnose(measured(lag, drives()), ROBOT)
    assert found.effects == ["drive_lag"], found
    assert found.law_mismatch
    # As large as the lag itself it is a cause of its own.
    both = {"drive_lag": {"T": 0.03}, "drive_delay": {"T": 0.03}}
    assert len(diagnose(measured(both, drives()), ROBOT).effects) == 2


@pytest.mark.slow
def test_nothing_is_named_where_one_force_along_the_way_would_do() -> None:
    # A stiffer line is no other law of friction either: what it leaves is told instead.
    found = diagnose(tethered(drives(both=False, samples=150), 0.08, slack=0.2), ROBOT)
    assert found.status == "unexplained", found
    assert found.report["verdict"]["unlisted"]["variable"] == "terrain"
    assert "so would one force along the way" in found.summary


def test_what_only_the_run_that_was_kept_shows_is_found() -> None:
    # The stronger of two runs, which is kept, just reaches the limit; no start of a fit lies there.
    frame = measured({"drive_saturation": {"F_max": 1.118}}, drives(count=2))
    found = diagnose(frame, ROBOT)
    assert found.effects == ["drive_saturation"], found
    assert found.gap["held_out"] == []
    assert any("show a gap that the others do not" in warning for warning in found.warnings)
