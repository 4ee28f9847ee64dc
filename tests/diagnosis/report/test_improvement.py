"""The interval of a stated shrink holds what fresh runs do."""

from types import SimpleNamespace

import numpy as np
import pytest

from locosweep.diagnosis.report import improvement as shrink
from locosweep.diagnosis.report.improvement import _interval


def world(generator, runs):
    """Mean squares of runs before and after, of one population that the generator draws."""
    floor, fall = generator.normal(-14.0, 1.0), generator.normal(0.5, 0.7)
    after = np.exp(floor + 0.3 * generator.normal(size=runs))
    before = after * np.exp(np.exp(fall + 0.6 * generator.normal(size=runs)))
    return before, after


def inside(runs, worlds=400):
    """Share of populations whose next run falls into the interval of the runs before it."""
    generator = np.random.default_rng(7)
    hits = []
    for _ in range(worlds):
        before, after = world(generator, runs + 1)
        errors = [np.full(64, b) for b in before[:-1]], [np.full(64, a) for a in after[:-1]]
        problem = SimpleNamespace(runs=[None] * runs, held=[runs - 1])
        stated = 1.0 - np.sqrt(after[-2] / before[-2])
        low, high = _interval(problem, errors, stated, seed=1)
        assert low <= stated <= high <= 1.0
        hits.append(low <= 1.0 - np.sqrt(after[-1] / before[-1]) <= high)
    return np.mean(hits)


@pytest.mark.parametrize("runs", [4, 6, 8])
def test_the_interval_holds_the_next_run_in_nine_of_ten_cases(runs):
    assert 0.86 <= inside(runs) <= 0.95


def test_runs_as_they_are_hold_it_less_often(monkeypatch):
    monkeypatch.setattr(shrink, "_like", lambda runs, *_: runs[:1])
    assert inside(4) < 0.75


def test_one_run_is_cut_into_blocks():
    generator = np.random.default_rng(3)
    before, after = generator.random(400) + 1.0, 0.25 * (generator.random(400) + 1.0)
    problem = SimpleNamespace(runs=[None], held=[])
    low, high = _interval(problem, ([before], [after]), 0.5, seed=1)
    assert 0.4 < low <= 0.5 <= high < 0.6
    assert high - low > 0.001


def test_runs_that_show_nothing_keep_zero_inside():
    generator = np.random.default_rng(5)
    before, after = world(generator, 6)
    before[:2] = after[:2]
    errors = [np.full(64, b) for b in before], [np.full(64, a) for a in after]
    problem = SimpleNamespace(runs=[None] * 6, held=[5])
    low, _ = _interval(problem, errors, 1.0 - np.sqrt(after[5] / before[5]), seed=1)
    assert low == 0.0
