"""The force that no effect stands for: its likelihood by another route, its size, its runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from diagnosis_small import NOISE, ROBOT, driven, measured, problem
from locosweep.diagnosis.estimate.least_squares import Fit, Model, Nuisances, point_of
from locosweep.diagnosis.estimate.rest import RestForce
from locosweep.files.runs import Run


def pushed(size: float, count: int = 4, noise: float = NOISE):
    """Runs in which a force acts that their drive column does not tell of."""
    runs = driven(count)
    random = np.random.default_rng(3)
    knots = np.linspace(0.0, 2.0, 9)
    hidden = [np.interp(run.t, knots, size * random.standard_normal(9)) for run in runs]
    real = [replace(run, drive=run.drive + f) for run, f in zip(runs, hidden, strict=True)]
    return [
        replace(run, drive=told.drive)
        for run, told in zip(measured({}, real, noise=noise), runs, strict=True)
    ]  # fmt: skip


def nothing() -> Fit:
    return Fit(Model((), ()), Nuisances(), np.zeros(0))


def test_its_size_is_that_of_the_hidden_force() -> None:
    (found,) = RestForce(problem(pushed(0.05))).beside([nothing()])
    assert 0.015 < found.size < 0.15


def test_there_is_none_where_only_noise_is_left() -> None:
    (found,) = RestForce(problem(measured({}))).beside([nothing()])
    assert found.size < 1e-3
    assert max(found.noise) < 1.3


def test_its_bayes_factor_is_small_under_noise_and_large_under_a_push() -> None:
    quiet, loud = (
        RestForce(problem(runs)).log_bayes_factor(nothing())
        for runs in (measured({}), pushed(0.05))
    )
    # Sizes and times are chosen from the same readings: that much noise alone gains.
    assert 0.0 <= quiet < 8.0
    assert loud > 1000.0


def test_noise_above_the_stated_one_is_no_merit_of_the_force() -> None:
    own = problem(measured({}, noise=1.3 * NOISE))
    force = RestForce(own)
    (rest,) = force.beside([nothing()])
    assert min(rest.noise) > 1.4
    # A hundred would be gained by the noise alone.
    assert -20.0 < force.log_bayes_factor(nothing()) < 20.0


@pytest.mark.parametrize("noise", [NOISE, 3.0 * NOISE])
def test_its_deviance_is_that_of_a_normal_distribution(noise: float) -> None:
    """The covariance of all readings of a run, written out, gives the same likelihood.

    Written out from the rows that fits beside the rest use, so that both mean the same rest.
    """
    own = problem(pushed(0.05, 2, noise))
    force = RestForce(own)
    (rest,) = force.beside([nothing()])
    # A factor above 1 shows whether both scale the force and the starts with it.
    assert max(rest.noise) > 5.0
    beside = force.beside_one(rest)
    deviance = 0.0
    e = own.measured["x"] - own.replay([point_of(own, nothing())])["x"][0]
    for r in range(2):
        at = slice(own.starts_at[r], own.starts_at[r + 1])
        rows = np.array([dict(s)[0][at] for s in [*beside.start_shifts, *beside.rest]])
        covariance = np.eye(rows.shape[1]) + rows.T @ rows
        density = multivariate_normal(np.zeros(rows.shape[1]), covariance, allow_singular=True)
        deviance -= 2.0 * density.logpdf(e[at] * beside.weights["x"][at])
        deviance += rows.shape[1] * np.log(rest.noise[r])
        starts = np.array([dict(s)[0][at] for s in own.start_shifts])
        # What does not depend on the rest is left out.
        deviance -= np.linalg.slogdet(np.eye(len(starts)) + starts @ starts.T)[1]
        deviance -= rows.shape[1] * np.log(2.0 * np.pi)
    assert rest.deviance == pytest.approx(deviance, rel=1e-6)


def test_errors_of_a_model_are_the_same_beside_a_rest() -> None:
    # Off from the second reading on: a start that is less sure would take part of it away.
    runs = measured({}, driven(2))
    for run in runs:
        run.channels["x"][10:] += 8.0 * NOISE
    own = problem(runs)
    force = RestForce(own)
    rest = replace(force.beside([nothing()])[0], noise=(100.0, 100.0))
    point = point_of(own, nothing())
    plain, beside = (one.position_errors([point], [0, 1]) for one in (own, force.beside_one(rest)))
    assert np.allclose(plain, beside, rtol=1e-6, atol=1e-3 * NOISE)


def test_a_run_that_no_model_follows_counts_for_less() -> None:
    runs = measured({})
    random = np.random.default_rng(1)
    runs[1].channels["x"][:] += 30.0 * NOISE * random.standard_normal(runs[1].t.size)
    own = problem(runs)
    force = RestForce(own)
    (rest,) = force.beside([nothing()])
    assert 500.0 < rest.noise[1] < 1500.0
    assert max(rest.noise[0], rest.noise[2]) < 1.5
    weights = np.split(force.beside_one(rest).weights["x"], own.starts_at[1:-1])
    assert weights[1].max() < 0.06 * weights[0].max()


def test_a_force_far_above_the_noise_takes_no_more_than_there_is() -> None:
    # Behind a hole in the readings the head is anywhere: the gap is millions of deviations.
    t = np.arange(0.0, 30.0, 0.02)
    drive = np.where(np.sin(1.4 * np.pi * t) > 0.0, 1.2, -1.1)
    drive[:5] = 0.0
    (run,) = measured({"coulomb_error": {"d_mu": 0.015}}, [Run("0", t, drive)], noise=0.0)
    run.channels["x"][200:1300] = np.nan
    own = problem([run], replace(ROBOT, other={"sensor.position_noise": 1e-6}))
    force = RestForce(own)
    (rest,) = force.beside([nothing()])
    e = (own.measured["x"] - own.replay([point_of(own, nothing())])["x"][0]) * own.weights["x"]
    assert rest.deviance > 0.0
    assert force.log_bayes_factor(nothing()) < np.nansum(np.square(e))
