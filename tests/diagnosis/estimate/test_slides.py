"""First-order response of a motion to small forces, and of residuals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis_small import measured, problem
from locosweep.diagnosis.estimate.least_squares import Fit, Model, Nuisances
from locosweep.diagnosis.estimate.motion import motion_of
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.estimate.slides import Slides, corrected, corrections
from locosweep.errors import InputError


def sliding(damping: float = 0.0, samples: int = 400) -> tuple[np.ndarray, Slides]:
    """Times and a motion of 0.5 kg at 1 m/s."""
    t = np.linspace(0.0, 2.0, samples)
    return t, Slides.of_run(t, np.ones(samples), 0.5, damping)


def test_a_constant_force_accelerates_a_sliding_head() -> None:
    t, motion = sliding()
    dx, dv = motion.response(np.full((1, t.size), 0.1))
    np.testing.assert_allclose(dv[0], 0.2 * t, atol=1e-9)
    np.testing.assert_allclose(dx[0], 0.1 * t**2, atol=1e-4)


def test_damping_bounds_the_speed() -> None:
    t, motion = sliding(damping=2.0, samples=4000)
    _, dv = motion.response(np.full((1, t.size), 0.1))
    np.testing.assert_allclose(dv[0], 0.05 * (1.0 - np.exp(-4.0 * t)), atol=2e-4)


def test_gravity_pulls_a_pendulum_back() -> None:
    """An impulse on a head that slides through its lowest place: a swing of the small rest."""
    t, motion = sliding(samples=4001)
    force = np.zeros((1, t.size))
    force[0, 0] = 1.0
    dx, _ = motion._replace(stiffness=np.full(t.size, 8.0)).response(force)
    rate = np.sqrt(8.0 / 0.5)
    swing = float(t[1]) / 0.5 / rate * np.sin(rate * (t - 0.5 * t[1]))
    np.testing.assert_allclose(dx[0][1:], swing[1:], atol=2e-3 * float(np.abs(swing).max()))


def test_a_head_at_rest_does_not_respond() -> None:
    t, motion = sliding()
    dx, dv = motion._replace(v=np.zeros(t.size)).response(np.full((2, t.size), 0.1))
    assert not dx.any()
    assert not dv.any()


def test_a_run_begins_anew_behind_the_last_sample_of_another() -> None:
    """Two runs of uneven steps, side by side and one after another."""
    t = np.cumsum(np.random.default_rng(0).uniform(0.001, 0.01, 200))
    v = np.where(np.arange(t.size) % 50 < 40, 1.0, 0.0)
    one = Slides.of_run(t, v, 0.5, 3.0)
    arrays = ("v", "step", "last", "keeps", "stiffness")
    both = one._replace(**{key: np.tile(getattr(one, key), 2) for key in arrays})
    force = np.sin(40.0 * t)[None]
    alone, joined = one.response(force), both.response(np.tile(force, 2))
    for apart, together in zip(alone, joined, strict=True):
        assert apart.any()
        np.testing.assert_array_equal(np.tile(apart, 2), together)


def test_corrections_are_what_the_same_changes_of_readings_make_of_residuals() -> None:
    """More terms than are worked out side by side; threads change no bit."""
    own = replace(problem(measured({}, channels=("x", "force", "v"))), held=(1,))
    motion = motion_of(own, Fit(Model((), ()), Nuisances(), np.zeros(0)))
    terms = np.random.default_rng(0).normal(size=(11, motion.t.size))
    residuals = own.residuals([own.plain()])[0]
    for slides in (motion.slides, None):
        found = np.full((11, residuals.size + 2), 7.0)
        corrections(own, [terms[:4], terms[4:]], slides, found)
        assert (found[:, residuals.size :] == 7.0).all()
        moved = (terms, 0.0 * terms) if slides is None else slides.response(terms)
        for row, dx, dv in zip(found, *moved, strict=True):
            expected = with_readings_moved(own, dx, dv) - residuals
            np.testing.assert_allclose(row[:-2], expected, atol=1e-9 * np.abs(expected).max())
        changed = np.zeros(residuals.size, dtype=bool)
        changed[np.r_[tuple(corrected(own))]] = True
        assert not found[:, :-2][:, ~changed].any()
        both = np.zeros_like(found)
        corrections(replace(own, threads=2), [terms], slides, both)
        np.testing.assert_array_equal(both[:, :-2], found[:, :-2])


def test_tables_that_do_not_fit_get_one_clear_line() -> None:
    own = problem(measured({}))
    samples, width = own.samples_of(own.fitted), own.residuals([own.plain()]).shape[1]
    terms, to = np.zeros((2, samples)), np.zeros((2, width))
    wrong = [(terms, np.zeros((3, width))), (terms[:, 1:], to), (terms, to[:, 1:])]
    for given, rows in wrong:
        with pytest.raises(InputError, match="as many rows"):
            corrections(own, [given], None, rows)
    by_columns = np.asfortranarray(terms)
    for given, rows in ((by_columns, to), (terms, np.asfortranarray(to))):
        with pytest.raises(InputError, match="row by row"):
            corrections(own, [given], None, rows)
    corrections(own, [], None, to[:0])


def with_readings_moved(own: Problem, dx: np.ndarray, dv: np.ndarray) -> np.ndarray:
    """Return the residuals of the nominal model where readings of the fitted runs differ."""
    lengths = own.lengths[own.fitted]
    runs = list(own.runs)
    changes = (np.split(d, lengths.cumsum()[:-1]) for d in (dx, dv))
    for r, *change in zip(own.fitted, *changes, strict=True):
        channels = runs[r].channels
        read = {c: channels[c] + d for c, d in zip(("x", "v"), change, strict=True)}
        runs[r] = replace(runs[r], channels={**channels, **read})
    known = {"known": own.noise, "known_shifts": own.start_shifts, "initial": own.starts}
    changed = replace(own, runs=runs, **known)
    return changed.residuals([changed.plain()])[0]
