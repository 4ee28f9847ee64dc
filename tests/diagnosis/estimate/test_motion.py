"""Terms along a motion, and its first-order response to small forces beside replays."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from diagnosis_search import search_for, search_of
from locosweep.diagnosis.effects.catalogue import FURTHER
from locosweep.diagnosis.estimate.least_squares import Fit, Model, Nuisances
from locosweep.diagnosis.estimate.motion import (
    ALL,
    Motion,
    _keeps,
    motion_of,
    terms_of,
)
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.files.robot import Robot
from locosweep.files.runs import Run


def sliding(damping: float = 0.0, samples: int = 400) -> Motion:
    t = np.linspace(0.0, 2.0, samples)
    ones = np.ones(samples)
    return Motion(
        t=t, x=t, v=ones, force=ones, drive=ones, run=np.zeros(samples, dtype=np.intp),
        swept=t, turned=t, mass=0.5, damping=damping, keeps=ones, stiffness=0.0 * t,
    )  # fmt: skip


def test_a_head_that_turns_keeps_the_ratio_of_its_accelerations() -> None:
    """A short push before the turns, against a replay with it: the head turns without a rest."""
    t = np.linspace(0.0, 1.0, 401)
    square = 2.0 * np.sign(np.sin(2.0 * np.pi * 2.0 * t + 0.3))
    push = 1e-3 * ((t >= 0.1) & (t < 0.11))
    moved = []
    for drive in (square, square + push):
        search = search_of([Run("0", t, drive, {"x": np.zeros(t.size)})])
        moved.append(motion_of(search.problem, search.none))
    plain, pushed = moved
    assert np.count_nonzero(np.diff(np.sign(plain.v))) >= 3
    assert np.count_nonzero((plain.keeps > 0.0) & (plain.keeps < 1.0)) >= 3
    dx, dv = plain.slides.response(push[None, :])
    late = t > 0.9
    np.testing.assert_allclose(dv[0][late], (pushed.v - plain.v)[late], rtol=0.05, atol=1e-9)
    np.testing.assert_allclose(dx[0][late], (pushed.x - plain.x)[late], rtol=0.05, atol=1e-9)


def test_a_push_of_a_pendulum_is_that_of_a_replay() -> None:
    """It swings to and fro between rests and turns."""
    robot = Robot(
        {"mass": 0.01},
        {"bench.kind": "rotary", "surface.coulomb_force": 0.02, "bench.gravity_torque": 0.4},
    )
    t = np.linspace(0.0, 2.0, 801)
    drive = 0.2 * np.sign(np.sin(2.0 * np.pi * 0.8 * t + 0.3))
    push = 1e-6 * ((t >= 0.1) & (t < 0.11))
    moved = []
    for one in (drive, drive + push):
        own = Problem(robot, [Run("0", t, one, {"x": np.zeros(t.size)})], 1, speed_scale=1.0)
        nuisances = Nuisances((), (0.0, 0.0, 0.0, 0.0), 1.0)
        moved.append(motion_of(own, Fit(Model((), ()), nuisances, np.zeros(0))))
    plain, pushed = moved
    change = pushed.x - plain.x
    assert np.count_nonzero(plain.keeps[t > 0.11] < 1.0) >= 1
    dx, _ = plain.slides.response(push[None, :])
    assert np.linalg.norm(dx[0] - change) < 0.05 * np.linalg.norm(change)


def test_terms_of_a_position_add_up_to_friction() -> None:
    """Knots of equal value are Coulomb friction: one, with the sign of the speed."""
    search = search_for({})
    m = motion_of(search.problem, search.none)
    (terms,), is_force = terms_of("place", m)
    assert is_force
    np.testing.assert_allclose(terms.sum(axis=0), np.sign(m.v), atol=1e-12)


def test_a_speed_that_dies_away_has_terms_without_a_warning() -> None:
    """Knots then lie so near to each other that a quotient overflows."""
    m = sliding(samples=401)
    v = np.exp(-np.interp(m.t, m.t[[0, 200, 400]], [0.0, 700.0, 740.0]))
    v[:50] = -1.0
    groups, _ = terms_of("speed", Motion(**{**vars(m), "v": v}))
    np.testing.assert_allclose(groups[0].sum(axis=0), v > 0.0)


def test_a_change_that_is_late_lacks_its_impulse() -> None:
    """A step up by 1 N at 0.5 s and down by 2 N at 1 s, each late by a law of its own."""
    m = sliding(samples=401)
    drive = np.where(m.t < 0.5, 0.2, np.where(m.t < 1.0, 1.2, -0.8))
    terms, is_force = terms_of("change", Motion(**{**vars(m), "drive": drive}))
    assert is_force
    assert len(terms) == 2
    late = np.array([[3e-4], [1e-4]])
    dx, dv = m.slides.response(late * np.vstack(terms))
    impulses = np.array([[-1.0], [2.0]]) * late
    since = m.t - np.array([[0.5], [1.0]])
    np.testing.assert_allclose(dv, impulses / m.mass * (since > 1e-9), atol=1e-12)
    step = float(m.t[1])
    expected = impulses / m.mass * np.maximum(since - 0.5 * step, 0.0) * (since > 1e-9)
    np.testing.assert_allclose(dx, expected, atol=1e-12)


@pytest.mark.parametrize("variable", [*ALL, *FURTHER.values()])
def test_every_variable_has_terms_of_the_motion_s_length(variable: str) -> None:
    search = search_for({})
    m = motion_of(search.problem, search.none)
    groups, is_force = terms_of(variable, m)
    assert groups
    assert all(rows.shape[1] == m.t.size for rows in groups)
    assert is_force == (variable not in ("reading", "clock", "late"))


def test_swept_distance_starts_anew_where_the_head_turns() -> None:
    search = search_for({})
    m = motion_of(search.problem, search.none)
    assert not m.swept[m.v <= 0.0].any()
    assert m.swept.max() > 0.0
    assert (m.swept >= 0.0).all()


def test_ways_since_a_rest_or_a_turn_are_those_of_a_walk_along_the_samples() -> None:
    """Slides both ways, rests and turns; each run begins anew."""
    own = search_for({}).problem
    m = motion_of(own, Fit(Model((), ()), Nuisances(), np.zeros(0)))
    swept, turned = np.zeros_like(m.x), np.zeros_like(m.x)
    for i in range(1, m.x.size):
        if m.run[i] != m.run[i - 1]:
            continue
        step = m.x[i] - m.x[i - 1]
        swept[i] = swept[i - 1] + step if m.v[i] > 0.0 else 0.0
        turned[i] = turned[i - 1] + step if m.v[i] * m.v[i - 1] > 0.0 else 0.0
    assert (m.v == 0.0).any()
    assert swept.any()
    assert turned.min() < 0.0 < turned.max()
    np.testing.assert_allclose(m.swept, swept, atol=1e-12)
    np.testing.assert_allclose(m.turned, turned, atol=1e-12)


def test_an_error_by_the_way_since_the_start_is_in_the_terms_of_a_reading() -> None:
    """As of a bent scale, in runs that begin in different places and mostly rest."""
    ramp = np.clip(np.linspace(-4.0, 5.0, 500), 0.0, 1.0)
    moved = np.concatenate([ramp, -0.8 * ramp])
    m = replace(
        sliding(samples=moved.size),
        x=moved + np.repeat([0.0, 0.5], ramp.size),
        v=np.gradient(moved) * (np.abs(np.gradient(moved)) > 1e-9),
        run=np.repeat([0, 1], ramp.size),
    )
    groups, _ = terms_of("reading", m)
    error = moved * np.abs(moved)
    terms = np.vstack(groups).T
    left = error - terms @ np.linalg.lstsq(terms, error, rcond=None)[0]
    assert np.sqrt(np.mean(left**2)) < 1e-2 * np.sqrt(np.mean(error**2))


def test_a_turn_from_next_to_no_speed_keeps_all_without_a_warning() -> None:
    runs = SimpleNamespace(runs=[SimpleNamespace(since_start=np.array([0.0, 0.01]))], fitted=[0])
    v, x, number = np.array([1e-318, -1.0]), np.array([0.0, -0.005]), np.zeros(2, dtype=np.intp)
    with np.errstate(over="raise"):
        assert _keeps(runs, number, v, x).tolist() == [1.0, 1.0]
