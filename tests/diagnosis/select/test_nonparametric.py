"""Nonparametric corrections against densities of dense Gaussian processes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from locosweep.diagnosis.effects.scale import scale_of
from locosweep.diagnosis.estimate.least_squares import Nuisances, fit_all, start_fits
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.select.nonparametric import NonparametricCorrection
from locosweep.diagnosis.select.search import Search
from locosweep.files.runs import runs_from_frame
from test_diagnosis import ROBOT, drives, measured

FLAT = 1e4
"""Deviation of a fitted parameter's size: it may be anything."""


def terms_beside(frame: pl.DataFrame, *names: str) -> NonparametricCorrection:
    """Terms beside the fit of some effects to measured runs."""
    records = runs_from_frame(frame)
    scale = scale_of(ROBOT, records)
    problem = Problem(ROBOT, records, 1, speed_scale=scale.speed)
    nuisances = Nuisances((), (0.0, 0.0, 0.0, 0.0), scale.speed)
    search = Search(problem, nuisances, scale, names)
    fit = search.none
    if names:
        model = search.model(names)
        starts = start_fits(nuisances, model, np.zeros((1, len(model.free))))
        (fit,) = fit_all(problem, starts, steps=20)
    return NonparametricCorrection(problem, fit)


def log_density(
    terms: NonparametricCorrection, variables: list[str], spread: float, places: np.ndarray | slice
) -> float:
    """Of residuals at some places, the sizes of terms and of fitted values integrated out."""
    own = np.isin(terms.names, variables)
    sizes = spread**2 * terms.covariance * (own[:, None] & own)
    sizes += FLAT**2 * np.diag(terms.names == "fit")
    basis = terms.unit_rows(np.arange(terms.names.size))[:, places]
    residual = terms.residual[places]
    covariance = np.eye(residual.size) + basis.T @ sizes @ basis
    square = residual @ np.linalg.solve(covariance, residual)
    return -0.5 * float(square + np.linalg.slogdet(covariance)[1])


@pytest.mark.slow
@pytest.mark.parametrize("names", [(), ("coulomb_error",)])
def test_worth_is_the_ratio_of_marginal_likelihoods(names: tuple[str, ...]) -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=2, samples=50))
    terms = terms_beside(frame, *names)
    without = log_density(terms, [], 0.0, slice(None))
    for variable in ("speed", "drive", "place"):
        # The likeliest deviation, looked for without the decomposition that is tested.
        tried = [
            log_density(terms, [variable], spread, slice(None))
            for spread in np.geomspace(1e-6, 1.0, 61)
        ]
        assert terms.log_bayes_factor([variable], 1.0) == pytest.approx(
            2.0 * (max(tried) - without), rel=0.02, abs=0.3
        )


def test_sizes_are_means_given_the_residuals_and_their_deviations() -> None:
    """Of the likeliest process in one variable, an effect's own parameter left as it is."""
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=2, samples=60))
    terms = terms_beside(frame, "viscous_friction")
    _, root = terms._covariance_root(["speed"], 1.0)
    own = terms.names == "speed"
    rows = terms.unit_rows(np.flatnonzero(own))
    prior = root @ root.T
    covariance = np.eye(terms.residual.size) + rows.T @ prior @ rows
    gains = np.linalg.solve(covariance, rows.T @ prior).T
    spread = np.sqrt(np.diag(prior - gains @ rows.T @ prior))
    sizes, deviations = terms.sizes_beside("speed", 1.0, "viscous_friction")
    norms = terms._norm[own]
    np.testing.assert_allclose(sizes * norms, gains @ terms.residual, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(deviations * norms, spread, rtol=1e-6)


def test_a_parameter_at_its_bound_makes_no_room_for_a_correction() -> None:
    """The head is faster than nominal: no drag, which is none below 0, helps."""
    frame = measured({"drive_gain_error": {"e": 0.02}}, drives(count=3, samples=60))
    at_bound, without = terms_beside(frame, "quadratic_drag"), terms_beside(frame)
    assert "fit" not in at_bound.names
    factors = [terms.log_bayes_factor(["speed"], 1.0) for terms in (at_bound, without)]
    assert factors[0] == pytest.approx(factors[1], rel=1e-7)
    assert factors[0] > 100.0


def test_runs_are_foretold_by_the_density_given_the_others() -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=3, samples=60))
    terms = terms_beside(frame)
    rows, root = terms._covariance_root(["speed"], 1.0)
    deviation = float(root[0, 0] / np.sqrt(terms.covariance[rows[0], rows[0]]))
    gain = 0.0
    for place in terms._samples:
        others = np.setdiff1d(np.arange(terms.residual.size), place)
        for sign, variables in ((1.0, ["speed"]), (-1.0, [])):
            whole = log_density(terms, variables, deviation, slice(None))
            gain += sign * 2.0 * (whole - log_density(terms, variables, deviation, others))
    assert terms.predictive_gain(["speed"], 1.0) == pytest.approx(gain, rel=1e-3)


def test_what_others_foretell_is_their_mean_over_its_deviation_given_the_others() -> None:
    frame = measured({"quadratic_drag": {"c2": 0.05}}, drives(count=3, samples=60))
    terms = terms_beside(frame, "coulomb_error")
    rows, root = terms._covariance_root(["speed"], 1.0)
    deviation = float(root[0, 0] / np.sqrt(terms.covariance[rows[0], rows[0]]))
    own = np.isin(terms.names, ["speed"])
    sizes = deviation**2 * terms.covariance * (own[:, None] & own)
    sizes += FLAT**2 * np.diag(terms.names == "fit")
    basis = terms.unit_rows(np.arange(own.size))
    covariance = np.eye(terms.residual.size) + basis.T @ sizes @ basis
    left = terms.prediction_errors(["speed"], 1.0)
    for place, found in zip(terms._samples, left, strict=True):
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
    basis = terms.unit_rows(np.arange(own.size))
    run = np.zeros(terms.residual.size)
    for i, place in enumerate(terms._samples):
        run[place] = i
    for_all = basis.T @ (terms.covariance * (own[:, None] & own)) @ basis
    around = np.eye(run.size) + FLAT**2 * basis[fitted].T @ basis[fitted]

    def density(covariance: np.ndarray) -> float:
        square = terms.residual @ np.linalg.solve(covariance, terms.residual)
        return -float(square + np.linalg.slogdet(covariance)[1])

    tried = [
        density(around + spread**2 * for_all * (run[:, None] == run))
        for spread in np.geomspace(1e-6, 1.0, 61)
    ]
    assert terms.log_bayes_factor_by_run(["speed"], 1.0) == pytest.approx(
        max(tried) - density(around), rel=0.02, abs=0.3
    )
    # The runs follow one law, and say so.
    assert terms.log_bayes_factor(["speed"], 1.0) > terms.log_bayes_factor_by_run(["speed"], 1.0)


def test_what_no_run_confirms_is_no_law() -> None:
    """Friction along the way of waves that differ from run to run."""
    runs = drives(count=4)
    frames = [
        measured({"position_dependent_friction": {"a": 0.02, "L": 0.3, "p": 1.6 * i}}, [run])
        for i, run in enumerate(runs)
    ]
    terms = terms_beside(pl.concat(frames))
    assert terms.log_bayes_factor(["place"], 1.0) > 20.0
    assert (
        terms.log_bayes_factor(["place"], 1.0)
        < terms.log_bayes_factor_by_run(["place"], 1.0) - 12.0
    )


def test_one_run_is_foretold_by_none() -> None:
    terms = terms_beside(measured({"quadratic_drag": {"c2": 0.3}}, drives(count=1)))
    assert terms.log_bayes_factor(["speed"], 1.0) > 100.0
    assert terms.predictive_gain(["speed"], 1.0) == 0.0


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
    assert once.log_bayes_factor(["time"], 1.0) > 100.0
    assert once.predictive_gain(["time"], 1.0) < 0.0 < again.predictive_gain(["time"], 1.0)
