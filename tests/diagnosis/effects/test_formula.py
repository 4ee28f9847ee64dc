"""Formulas of the registry: vocabulary, order of operations, refusals."""

import math

import numpy as np
import pytest

from locosweep.diagnosis.effects.formula import number, numbers

SIZES = {"force": 3.0, "speed": 0.7, "mass": 0.2, "level": 0.1}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("force / speed / speed", 3.0 / 0.7 / 0.7),
        ("force / (speed * speed)", 3.0 / (0.7 * 0.7)),
        ("-(1 - 0.001) * level / mass", -(1.0 - 0.001) * 0.1 / 0.2),
        ("max(force, 4) - min(force, 4)", 1.0),
        ("critical(force, mass)", 2.0 * math.sqrt(3.0 * 0.2)),
        ("mass * (2 * pi * 5) ** 2", 0.2 * (2.0 * math.pi * 5.0) ** 2),
        ("degrees(1)", float(np.degrees(1.0))),
        ("-inf", -math.inf),
    ],
)
def test_a_number_has_the_bits_of_the_same_python(text, value):
    assert number(text, SIZES) == value


def test_lists_count_element_by_element():
    np.testing.assert_array_equal(numbers("speed * [1, 2]", SIZES), [0.7, 1.4])
    np.testing.assert_array_equal(numbers("max(mass, [0.1, 0.5])", SIZES), [0.2, 0.5])
    np.testing.assert_array_equal(numbers("both([1, 2])", SIZES), [-1.0, -2.0, 1.0, 2.0])
    np.testing.assert_array_equal(numbers("geomspace(1, 4, 3)", SIZES), [1.0, 2.0, 4.0])
    np.testing.assert_array_equal(numbers("mass <= [0.1, 0.2]", SIZES), [False, True])


def test_one_number_is_a_list_of_one():
    assert numbers("force", SIZES).shape == (1,)


@pytest.mark.parametrize(
    "text",
    ["force.real", "open('x')", "force if mass else 1", "'text'", "force % 2", "min(force, k=1)",
     "[x for x in [1]]", "lambda: 1", "a < b < c"],
)  # fmt: skip
def test_what_is_not_in_the_vocabulary_is_refused(text):
    with pytest.raises(ValueError, match="not in the vocabulary"):
        number(text, SIZES)


def test_an_unknown_size_is_named():
    with pytest.raises(KeyError, match="weight"):
        number("force / weight", SIZES)
