"""How well parameters are known: under noise, and beside a force of every run's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis_rest import rig
from diagnosis_search import fit_of, search_of
from locosweep.diagnosis.estimate.spread_between_runs import covariance_between_runs


def deviations(hidden: float, count: int = 5) -> tuple[float, float, float]:
    """Deviation of a drag under white noise and between runs, and by how much it is off."""
    search = search_of(
        rig({"viscous_friction": {"c": 0.15}}, hidden=hidden, count=count), "viscous_friction"
    )
    fit = fit_of(search, "viscous_friction")
    between = replace(fit, covariance=covariance_between_runs(search.problem, fit))
    return float(fit.stds[0]), float(between.stds[0]), float(fit.parameters[0]) - 0.15


def test_under_noise_the_deviation_stays_about_as_it_is() -> None:
    white, between, _ = deviations(0.0)
    assert white <= between < 2.5 * white


def test_a_force_of_every_runs_own_makes_it_wider() -> None:
    white, between, off = deviations(0.02)
    assert between > 5.0 * white
    assert 5.0 * white < abs(off) < 3.0 * between


def test_one_run_makes_it_wider_too() -> None:
    white, between, _ = deviations(0.003, 1)
    assert between > 5.0 * white


def test_without_a_covariance_there_is_none() -> None:
    search = search_of(rig({}, hidden=0.0), "viscous_friction")
    bare = replace(fit_of(search, "viscous_friction"), covariance=np.zeros((0, 0)))
    assert covariance_between_runs(search.problem, bare).size == 0
