"""Numbers and units of a report."""

import re

import pytest

import locosweep as ls
from locosweep.diagnosis.report.units import rotary_unit, rounded, scale, sized
from locosweep.files.robot import is_rotary


@pytest.mark.parametrize(
    ("unit", "turning"),
    [("N", "N m"), ("kg", "kg m^2"), ("m", "rad"), ("m/s", "rad/s"), ("N/m", "N m/rad"),
     ("N s^2/m^2", "N m s^2/rad^2"), ("s", "s"), ("1", "1"), ("ohm", "ohm"), ("N m", "N m"),
     ("deg", "deg"), ("rad", "rad")],
)  # fmt: skip
def test_units_of_rigs_that_turn(unit, turning):
    assert rotary_unit(unit) == turning


def test_every_parameter_of_an_effect_has_a_unit_on_both_rigs():
    for effect in ls.effects():
        for parameter in effect.parameters:
            turning = rotary_unit(parameter.unit)
            assert "kg" not in turning.replace("kg m^2", "")
            assert not re.search(r"/m\b|^m\b", turning)


def test_a_bench_says_that_it_turns():
    assert is_rotary(ls.Robot({}, {"bench.kind": "rotary"}))
    assert not is_rotary(ls.Robot({}, {}))


@pytest.mark.parametrize(
    ("unit", "found"),
    [("N", "µN"), ("N/m", "µN/m"), ("N s/m", "µN s/m"), ("1", "1"), ("kg", "kg"), ("m²", "m²"),
     ("kg m²", "kg m²"), ("1/m", "1/m"), ("deg", "deg")],
)  # fmt: skip
def test_a_prefix_stands_only_where_it_is_read_as_one(unit, found):
    factor, small = scale(5e-6, unit)
    assert (factor, small) == (1e6 if found.startswith("µ") else 1.0, found)


def test_sizes_of_sentences():
    assert sized(0.6067, "m") == "0.61 m"
    assert sized(5.04e-6, "m") == "5 µm"
    assert sized(0.25, "1") == "0.25"


@pytest.mark.parametrize(
    ("value", "half", "text"),
    [(0.8499980573, 4.9e-6, "0.849998"), (-0.0231, 0.004, "-0.023"), (123.4, 7.0, "123"),
     (7506.48, 5.9, "7506"), (0.0, 1.0, "0"), (0.25, None, "0.25"), (0.25, float("inf"), "0.25"),
     (2.3456e-7, 3e-9, "2.35e-07"), (1234567.0, 2e4, "1.23e+06"), (0.02, 0.4, "0.0")],
)  # fmt: skip
def test_digits_end_where_the_interval_begins(value, half, text):
    assert rounded(value, half) == text
