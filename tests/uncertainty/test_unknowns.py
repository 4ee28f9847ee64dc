"""Distributions of parameters: their forms, their range, and points drawn from them."""

import numpy as np
import pytest
from scipy import stats

from locosweep.errors import InputError
from locosweep.uncertainty.unknowns import points, power_of_two, sequence, unknowns


def drawn(form, name="slope_deg", count=4096):
    found = unknowns({name: form})
    return points(found, sequence(1, count, 0), {})[name.partition("/")[0]]


@pytest.mark.parametrize(
    ("form", "law"),
    [
        ("2:6", stats.uniform(2, 4)),
        ((2, 6), stats.uniform(2, 4)),
        ("normal:5:2", stats.norm(5, 2)),
        ("lognormal:5:1.3", stats.lognorm(np.log(1.3), scale=5)),
        ("triangular:0:2:8", stats.triang(0.25, 0, 8)),
        (stats.gamma(3.0), stats.gamma(3.0)),
    ],
)
def test_points_follow_their_distribution(form, law):
    values = drawn(form)
    for q in (0.05, 0.3, 0.5, 0.8, 0.95):
        assert np.quantile(values, q) == pytest.approx(law.ppf(q), rel=5e-3, abs=5e-3)


def test_a_distribution_is_truncated_to_the_range_of_its_parameter():
    # Friction is not negative: a third of this normal distribution lies below 0.
    values = drawn("normal:0.1:0.2", "mu_coulomb")
    assert values.min() >= 0.0
    expected = stats.truncnorm(-0.5, np.inf, 0.1, 0.2)
    assert np.median(values) == pytest.approx(expected.median(), rel=2e-3)


def test_measured_values_are_equally_likely():
    values = drawn([0.3, 0.2, 0.25, 0.35], "mu_coulomb")
    found, counts = np.unique(values, return_counts=True)
    assert found.tolist() == [0.2, 0.25, 0.3, 0.35]
    assert set(counts) == {1024}


def test_bounds_of_a_whole_number_include_both_ends():
    found, counts = np.unique(drawn("3:6", "segments"), return_counts=True)
    assert found.tolist() == [3, 4, 5, 6]
    assert np.ptp(counts) <= 1


def test_a_ratio_multiplies_the_other_parameter_whether_fixed_or_unknown():
    found = unknowns({"mu_coulomb/mu_static": "0.5:0.9"})
    chances = sequence(1, 64, 0)
    fixed = points(found, chances, {"mu_static": 0.5})["mu_coulomb"]
    np.testing.assert_allclose(fixed, 0.5 * (0.5 + 0.4 * chances[:, 0]), rtol=1e-12)
    found = unknowns({"mu_coulomb/mu_static": "0.5:0.9", "mu_static": "0.4:0.6"})
    both = points(found, sequence(2, 64, 0), {})
    ratio = both["mu_coulomb"] / both["mu_static"]
    assert 0.5 <= ratio.min() < ratio.max() <= 0.9


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "unknown is empty"),
        ({"mu": "0:1"}, "parameter 'mu'"),
        ({"mu_static/mu": "0:1"}, "parameter 'mu'"),
        ({"mu_static": "0.6:0.4"}, "allowed is LOW < HIGH"),
        ({"mu_static": "0.4"}, "allowed are LOW:HIGH"),
        ({"mu_static": "nan:1"}, "allowed are LOW:HIGH"),
        ({"mu_static": (0.4, np.inf)}, "both finite"),
        ({"segments": "2.5:6"}, "allowed are whole numbers"),
        ({"mu_static": "normal:0.4"}, "allowed are LOW:HIGH"),
        ({"mu_static": "normal:0.4:0"}, "a deviation above 0"),
        ({"mu_static": "lognormal:0.4:0.9"}, "a factor above 1"),
        ({"mu_static": "lognormal:-1:2"}, "a median above 0"),
        ({"mu_static": "triangular:0:2:1"}, "LOW <= MODE <= HIGH"),
        ({"mu_static": [[0.1, 0.2]]}, "allowed are"),
        ({"mu_static": [0.1, np.nan, 0.2]}, "several finite values"),
        ({"mu_static": "-3:-1"}, "no value in the parameter's range"),
        ({"mu_static": "0:1", "mu_static/mu_coulomb": "0:1"}, "mu_static twice"),
        ({"mu_coulomb/mu_static": "0:1", "mu_static/mass": "0:1"}, "a share of another share"),
    ],
)
def test_what_is_no_distribution_is_refused_by_name(given, said):
    with pytest.raises(InputError, match=said):
        unknowns(given)


def test_a_ratio_to_what_has_no_value_is_refused():
    found = unknowns({"mu_coulomb/mu_static": "0.5:0.9"})
    with pytest.raises(InputError, match="mu_static, which has no value"):
        points(found, sequence(1, 4, 0), {})


@pytest.mark.parametrize("value", [1, 1000, 3.0, True, 2**21])
def test_numbers_of_points_are_powers_of_two(value):
    with pytest.raises(InputError, match="power of two"):
        power_of_two("samples", value)
