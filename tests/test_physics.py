"""Derived numbers as a user meets them: sweeps over axes, reductions and statuses."""

from __future__ import annotations

import numpy as np
import pytest

import locosweep as ls

PAPER = {"mu_static": 0.5, "mu_coulomb": 0.3}
SLOPES = list(range(0, 21, 2))


@pytest.mark.parametrize(
    ("weight", "optimum", "best"),
    [
        (
            1.0,
            [3.200, 3.440, 3.720, 4.052, 4.451, 4.943, 5.566, 6.383, 7.503, 9.139, 11.762],
            [3, 4, 4, 4, 5, 5, 6, 6, 8, 9, 12],
        ),
        (
            0.0,
            [3.200, 3.340, 3.480, 3.620, 3.762, 3.905, 4.050, 4.197, 4.347, 4.500, 4.656],
            [3, 3, 4, 4, 4, 4, 4, 4, 4, 5, 5],
        ),
    ],
)
def test_variants_of_figure_2(weight: float, optimum: list[float], best: list[int]) -> None:
    given = {**PAPER, "slope_deg": SLOPES, "anchor_weight": weight}
    result = ls.sweep(["optimal_segments", "best_segments"], **given)
    np.testing.assert_allclose(result["optimal_segments"], optimum, atol=0.5001e-3)
    np.testing.assert_array_equal(result["best_segments"], best)
    reduced = ls.sweep(
        "mean_velocity", segments=range(2, 30), over="segments", reduce="argmax", **given
    )
    np.testing.assert_array_equal(reduced.values, best)


def test_speed_over_segments() -> None:
    v = ls.sweep("mean_velocity", segments=range(2, 9), **PAPER).values
    shown = [70.0357, 87.3499, 85.7759, 81.6750, 77.4274, 73.5222, 70.0357]
    np.testing.assert_allclose(1e3 * v, shown, atol=0.5001e-4)
    assert v[0] == pytest.approx(v[-1], rel=1e-12)


def test_finite_grids_show_spikes_but_nothing_negative() -> None:
    # Figure 4 with both coefficients equal: the diagonal of a square grid.
    mu = np.arange(1, 101) / 100
    slopes = [0.0, 5.0, 10.0, 15.0, 20.0]
    result = ls.sweep("optimal_segments", mu_static=mu, mu_coulomb=mu, slope_deg=slopes)
    equal = np.diagonal(result.values).T
    assert np.nanmax(equal) == pytest.approx(526.6, abs=0.0501)
    assert np.nanmin(equal) >= 4.0
    code = np.diagonal(result.status).T
    slides = mu[:, None] <= np.tan(np.radians(slopes))
    np.testing.assert_array_equal(code == ls.Status.SLIDES_BACK, slides)
    np.testing.assert_array_equal(np.isnan(equal), slides)


def test_slope_limit_is_where_feasibility_ends() -> None:
    limits = ls.sweep("slope_limit_deg", segments=[2, 3, 4, 5, 8], **PAPER).values
    np.testing.assert_allclose(limits, [5.711, 13.134, 16.699, 18.778, 21.801], atol=0.5001e-3)
    slopes = np.linspace(0, 30, 3001)
    last = ls.sweep(
        "feasible",
        segments=[2, 3, 4, 5, 8],
        slope_deg=slopes,
        over="slope_deg",
        reduce="mean",
        **PAPER,
    ).values
    np.testing.assert_allclose(last * 30, limits, atol=0.02)
    still = ls.sweep(
        "mean_velocity",
        segments=[2, 3, 4, 5, 8],
        slope_deg=slopes,
        over="slope_deg",
        reduce="last_feasible",
        **PAPER,
    ).values
    assert np.all((still <= limits) & (still > limits - 0.0101))


def test_actuator_limit_wants_few_segments() -> None:
    v = ls.sweep("mean_velocity", segments=[2, 3, 4], drive_limit=0.85, **PAPER).values
    np.testing.assert_allclose(1e3 * v, [21.996, 14.664, 10.998], atol=0.5001e-3)


def test_forces_exist_on_every_slope_and_with_every_limit() -> None:
    names = ["anchor_capacity", "anchor_reserve", "propulsive_force"]
    for extra in ({}, {"drive_limit": 50.0}, {"viscous": 0.1}, {"anchors_ahead": 1}):
        result = ls.sweep(names, segments=4, slope_deg=[-5.0, 0.0, 5.0], **PAPER, **extra)
        for name in names:
            assert np.isfinite(result[name]).all(), (name, extra)
        angle = np.radians([-5.0, 0.0, 5.0])
        hold = 0.5 * np.cos(angle) - np.sin(angle)
        expected = 3 * 0.271 * 9.81 * hold
        np.testing.assert_allclose(result["anchor_capacity"], expected, rtol=1e-14)
        drag = 0.3 * np.cos(angle) + np.sin(angle)
        np.testing.assert_allclose(result["anchor_reserve"], 3 * hold / drag, rtol=1e-13)


def test_universal_curve() -> None:
    x = np.array([0.75, 1.0, 1.25, 1.5, 2.0, 3.0])
    # mu_S = mu_C: r* = 4, so that whole counts lie on x.
    v = ls.sweep("mean_velocity", mu_static=0.4, mu_coulomb=0.4, segments=4 * x).values
    shown = [0.942809, 1.0, 0.979796, 0.942809, 0.866025, 0.745356]
    np.testing.assert_allclose(v / v[1], shown, atol=0.5001e-6)


def test_bands_of_uncertain_friction() -> None:
    # Below half the optimum nothing moves: the chance to move is a share of mu.
    mu = np.linspace(0.1, 0.5, 401)
    chance = ls.sweep(
        "feasible", mu_static=mu, mu_coulomb=0.3, segments=3, over="mu_static", reduce="mean"
    )
    assert float(chance.values) == pytest.approx(np.mean(2 * mu > 0.3), abs=1 / 401)
    low = ls.sweep(
        "mean_velocity",
        mu_static=mu,
        mu_coulomb=0.3,
        segments=range(4, 9),
        over="mu_static",
        reduce="quantile",
        q=0.1,
    )
    assert low.values.argmax() > 0, "under uncertainty a larger count is the safer choice"
