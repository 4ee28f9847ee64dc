"""Formulas of one variable: the form that made a law is found, with its numbers."""

from __future__ import annotations

import numpy as np
import pytest

from locosweep.diagnosis.select.law_forms import shortest

U = np.linspace(-0.1, 0.5, 41)
GRAM = 1e4 * np.eye(U.size)
"""Heights are known to 0.01 each."""

LAWS = {
    "constant": (np.full(U.size, 0.7), (), (0.7,)),
    "line": (-3.0 * U + 0.2, (), (-3.0, 0.2)),
    "above": (-3.0 * np.maximum(U - 0.21, 0.0), (0.21,), (-3.0,)),
    "below": (5.0 * np.minimum(U - 0.1, 0.0), (0.1,), (5.0,)),
    "outside": (
        -4.0 * (np.maximum(U - 0.4, 0.0) + np.minimum(U - 0.05, 0.0)),
        (0.05, 0.4),
        (-4.0,),
    ),
    "step": (0.3 * (U > 0.2075), (0.2075,), (0.3,)),
    "rise": (0.15 * (1.0 + np.tanh((U - 0.2) / 0.05)), (0.2, 0.05), (0.3,)),
    "bump": (0.8 * np.exp(-0.5 * ((U - 0.2) / 0.05) ** 2), (0.2, 0.05), (0.8,)),
    "pair": (
        0.5 * (U - 0.3) / 0.08 * np.exp(0.5 - 0.5 * ((U - 0.3) / 0.08) ** 2),
        (0.3, 0.08),
        (0.5,),
    ),
    "wave": (
        0.4 * np.sin(2 * np.pi * U / 0.17) + 0.3 * np.cos(2 * np.pi * U / 0.17),
        (0.17,),
        (0.4, 0.3),
    ),
    "fading": (np.exp(-(U + 0.1) / 0.07), (0.07,), (1.0,)),
    "power": ((np.sign(U) * np.abs(U / 0.5) ** 2.0), (2.0,), (1.0,)),
}


@pytest.mark.parametrize("name", LAWS)
def test_the_form_that_made_a_law_is_the_shortest(name: str) -> None:
    law, shape, sizes = LAWS[name]
    law = law + np.random.default_rng(1).normal(0.0, 0.01, U.size)
    found = shortest(U, GRAM, GRAM @ law)
    assert found is not None
    assert found.form.columns.__name__ == f"_{name}"
    # A knot's distance is 15 mm: a step lies somewhere between two.
    assert np.allclose(np.sort(found.shape), np.sort(shape), rtol=0.05, atol=0.008)
    assert found.sizes.size == len(sizes)
    assert np.allclose(found.sizes, sizes, atol=5.0 * found.deviations.max() + 0.01)
    assert np.sqrt(np.mean((found.at(U) - law) ** 2)) < 0.02
    assert np.all(found.deviations > 0.0)


@pytest.mark.parametrize(("name", "may"), [("step", True), ("rise", False), ("line", False)])
def test_only_what_a_step_describes_may_jump(name: str, may: bool) -> None:
    law = LAWS[name][0] + np.random.default_rng(1).normal(0.0, 0.01, U.size)
    found = shortest(U, GRAM, GRAM @ law)
    assert found is not None
    assert found.may_jump == may


def test_a_constant_beside_a_form_is_told_apart_from_it() -> None:
    law = 0.5 + 0.8 * np.exp(-0.5 * ((U - 0.2) / 0.05) ** 2)
    found = shortest(U, GRAM, GRAM @ law)
    assert found is not None
    assert found.constant
    assert np.allclose(found.sizes, (0.8, 0.5), atol=0.01)


def test_noise_has_no_formula() -> None:
    heights = np.random.default_rng(2).normal(0.0, 0.01, U.size)
    assert shortest(U, GRAM, GRAM @ heights) is None


def test_what_no_reading_sees_has_no_size() -> None:
    """Heights of one half only: a line there says nothing of a bump in the other."""
    gram = np.where(np.arange(U.size) < 20, 1e4, 0.0) * np.eye(U.size)
    found = shortest(U, gram, gram @ (2.0 * U))
    assert found is not None
    assert np.allclose(found.at(U)[:20], (2.0 * U)[:20], atol=0.02)
