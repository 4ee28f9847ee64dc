"""Predictions of kept runs: what they may err by, and what refutes them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import search_of
from diagnosis_small import driven, measured
from locosweep.diagnosis.estimate.least_squares import fit_all, start_fits
from locosweep.diagnosis.select.prediction import misses, over_deviations


def test_errors_over_their_deviations_are_white() -> None:
    unsure = np.random.default_rng(3).normal(size=(3, 12)) * np.array([[9.0], [1.0], [0.01]])
    root = np.array([over_deviations(one, unsure) for one in np.eye(12)])
    covariance = np.eye(12) + unsure.T @ unsure
    assert root @ covariance @ root.T == pytest.approx(np.eye(12), abs=1e-9)
    assert over_deviations(np.ones(12), np.zeros((0, 12))) == pytest.approx(np.ones(12))


@pytest.mark.parametrize("more", [None, "load_dependent_friction"])
def test_a_kept_run_with_a_cause_of_its_own_refutes_a_fit(more: str | None) -> None:
    """It makes a small part of the gap: the cause that was found does the most."""
    law: dict[str, dict[str, float]] = {"viscous_friction": {"c": 0.03}}
    runs = measured(law)
    if more:
        runs[-1] = measured(law | {more: {"mu_l": 2e-4}})[-1]
    search = search_of(runs, "viscous_friction", held=(len(runs) - 1,))
    (fit,) = fit_all(
        search.problem,
        start_fits(search.nuisances, search.model(("viscous_friction",)), np.array([[0.02]])),
    )
    left, gap = (search.unseen_chi2(one) for one in (fit, search.none))
    assert left < 0.05 * gap
    assert misses(search, fit) == bool(more)


def test_what_the_fitted_runs_do_not_know_is_no_contradiction() -> None:
    """Slow runs say little of a drag that the fast one, which is kept, hangs on."""
    runs = driven()
    slow = [replace(run, drive=0.8 * run.drive) for run in runs[:2]]
    fast = replace(runs[2], drive=1.1 * runs[2].drive)
    frames = measured({"quadratic_drag": {"c2": 0.02}}, [*slow, fast])
    search = search_of(frames, "quadratic_drag", held=(2,))
    model = search.model(("quadratic_drag",))
    (fit,) = fit_all(search.problem, start_fits(search.nuisances, model, np.array([[0.01]])))
    wrong = replace(fit, theta=fit.theta + np.sqrt(fit.covariance[0]))
    assert search.unseen_chi2(wrong) > 10.0 * runs[0].t.size
    assert not misses(search, fit)
    assert not misses(search, wrong)
    sure = replace(wrong, covariance=1e-6 * fit.covariance)
    assert misses(search, sure)
