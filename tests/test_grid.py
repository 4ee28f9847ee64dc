"""Grids against hostile values: refused with a message, or taken exactly."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import locosweep as ls
from locosweep import registry

ANY = st.one_of(
    st.floats(),
    st.sampled_from(
        [0.0, -0.0, 5e-324, -5e-324, 1e-30, 1e308, -1e308, math.inf, -math.inf, math.nan]
    ),
    st.integers(-(2**70), 2**70),
)
RECORDS = st.sampled_from(registry.parameters())


def allowed(record, value):
    low, high = record.range
    if not low <= value <= high:
        return False
    if value != 0 and not math.isinf(value) and not 1e-30 <= abs(value) <= 1e30:
        return False
    return not record.integer or float(value).is_integer()


@given(RECORDS, ANY)
def test_a_number_is_taken_exactly_or_refused(record, value):
    if allowed(record, value):
        fixed = ls.Grid(**{record.name: value}).fixed[record.name]
        assert fixed == float(value)
        return
    with pytest.raises(ls.InputError, match=record.name):
        ls.Grid(**{record.name: value})


@example(registry.parameter("drive_limit"), [2**64])
@given(RECORDS, st.lists(ANY, max_size=5))
def test_an_axis_is_taken_exactly_or_refused(record, values):
    try:
        array = np.array(values, float)
    except OverflowError:
        array = np.array([math.nan])
        values = array
    if len(array) and all(allowed(record, v) for v in array):
        axis = ls.Grid(**{record.name: values}).axes[record.name]
        assert axis.tobytes() == array.tobytes()
        return
    with pytest.raises(ls.InputError, match=record.name):
        ls.Grid(**{record.name: values})


def test_numbers_of_any_kind_are_taken_alone_and_in_lists():
    for value in (2**64, Fraction(1, 4), np.float32(0.5), np.int8(3)):
        assert ls.Grid(drive_limit=value).fixed["drive_limit"] == float(value)
        assert ls.Grid(drive_limit=[1, value]).axes["drive_limit"].tolist() == [1.0, float(value)]


@pytest.mark.parametrize("value", [10**400, [1, 10**400], [2**64, True], [2**64, "3"], [1, None]])
def test_what_is_no_number_or_too_large_is_refused_in_one_line(value):
    with pytest.raises(ls.InputError, match=r"^drive_limit [^\n]*$"):
        ls.Grid(drive_limit=value)


def test_a_wrong_value_is_named_with_its_place():
    with pytest.raises(ls.InputError, match=r"segments\[2\] is -1.*whole number from 1"):
        ls.Grid(segments=[2, 3, -1])


@pytest.mark.parametrize("name", ["mu_sttaic", "Mass", "", "mu_static ", "with space", "mü"])
def test_unknown_names(name):
    with pytest.raises(ls.InputError, match="unknown parameter"):
        ls.Grid(**{name: 1.0})


def test_the_nearest_name_is_suggested():
    with pytest.raises(ls.InputError, match="did you mean 'mu_static'"):
        ls.Grid(mu_sttaic=0.5)


WHOLE = np.array([2, 3, 5, 8])


@pytest.mark.parametrize(
    "values",
    [
        [2, 3, 5, 8], (2, 3, 5, 8), WHOLE, WHOLE.astype(np.int8), WHOLE.astype(np.uint64),
        WHOLE.astype(np.float16), WHOLE.astype(np.float32), WHOLE.astype(np.longdouble),
        WHOLE.astype(">f8"), WHOLE.astype(">i2"), np.repeat(WHOLE, 3)[::3].astype(float),
        WHOLE[::-1].astype(float)[::-1], np.asfortranarray(np.stack([WHOLE, WHOLE]).T)[:, 0],
    ],
    ids=lambda v: f"{type(v).__name__}-{getattr(v, 'dtype', '')}",
)  # fmt: skip
def test_kinds_of_arrays(values):
    axis = ls.Grid(segments=values).axes["segments"]
    assert axis.dtype == np.float64
    assert axis.flags.c_contiguous
    assert axis.tolist() == [2.0, 3.0, 5.0, 8.0]


def test_a_range_is_an_axis():
    assert ls.Grid(segments=range(2, 5)).axes["segments"].tolist() == [2.0, 3.0, 4.0]


@pytest.mark.parametrize("number", [3, 3.0, np.int8(3), np.float16(3), np.uint64(3), np.array(3)])
def test_kinds_of_numbers(number):
    assert ls.Grid(segments=number).fixed == {"segments": 3.0}


@pytest.mark.parametrize(
    "value",
    [
        True, np.True_, None, "0.5", b"1", "", 1j, [True, False], ["a"], [None], [1j], {}, {"a": 1},
        np.array([1, "x"], object), np.array([1.0], object), [[1.0, 2.0]], np.ones((2, 2)),
        np.ones((0, 3)), [1.0, [2.0, 3.0]], [], np.array([]), range(0), object(),
        np.ma.masked_array([1.0, 2.0], [False, True]), np.datetime64("2020-01-01"),
        np.array(["2020-01-01"], "M8[D]"), np.array([(1.0,)], [("a", float)]),
    ],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
def test_what_is_no_number_is_refused(value):
    with pytest.raises(ls.InputError, match="mass"):
        ls.Grid(mass=value)


def test_the_caller_keeps_its_array():
    mine = np.array([1.0, 2.0])
    mine.flags.writeable = False
    grid = ls.Grid(mass=mine)
    assert not np.shares_memory(mine, grid.axes["mass"])
    other = np.array([1.0, 2.0])
    grid = ls.Grid(mass=other)
    other[0] = 5.0
    assert grid.axes["mass"].tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        grid.axes["mass"][0] = 5.0


@given(
    hnp.arrays(
        np.float64,
        hnp.array_shapes(max_dims=1, max_side=6),
        elements=st.sampled_from([0.0, -0.0]) | st.floats(1e-30, 9),
    )
)
def test_order_repeats_and_signs_of_zero_are_kept(values):
    assert ls.Grid(mu_static=values).axes["mu_static"].tobytes() == values.tobytes()


def test_shape_and_size():
    grid = ls.Grid(mass=[1, 2, 3], segments=4, stroke=[1.0])
    assert (grid.shape, grid.size) == ((3, 1), 3)
    assert (ls.Grid().shape, ls.Grid().size) == ((), 1)
    assert repr(grid) == "Grid(mass[3], stroke[1], segments=4)"


def test_size_that_overflows():
    axis = np.ones(2**16)
    names = ["mass", "stroke", "gravity", "mu_static", "mu_coulomb"]
    try:
        grid = ls.Grid(**dict.fromkeys(names, axis))
    except ls.InputError as error:
        assert "64 bits" in str(error)  # noqa: PT017
    else:
        assert grid.size == 2**80


def test_a_name_in_both_places():
    with pytest.raises(ls.InputError, match="mass is given twice"):
        ls.sweep("resistance", ls.Grid(mass=1.0, mu_coulomb=0.3), mass=2.0)


class Length:
    """The part of a Pint quantity that grids use."""

    def __init__(self, magnitude, unit):
        self.magnitude = magnitude
        self.unit = unit

    def to(self, unit):
        factor = {("mm", "m"): 1e-3, ("m", "m"): 1.0}[self.unit, unit]
        return Length(np.multiply(self.magnitude, factor), unit)


def test_quantities_with_units_are_converted():
    assert ls.Grid(stroke=Length(20.0, "mm")).fixed["stroke"] == 0.02
    assert ls.Grid(stroke=Length([10.0, 20.0], "mm")).axes["stroke"].tolist() == [0.01, 0.02]


class TestRobot:
    ROBOT = ls.Robot({"mu_static": 0.5, "mu_coulomb": 0.3, "segments": 4.0, "drive_limit": 0.85})

    def test_fixes_what_is_not_given(self):
        grid = ls.Grid(robot=self.ROBOT, segments=range(2, 9), drive_limit=1.0)
        assert grid.fixed == {"mu_static": 0.5, "mu_coulomb": 0.3, "drive_limit": 1.0}
        assert list(grid.axes) == ["segments"]

    def test_goes_with_a_sweep_and_a_simulation(self):
        plain = ls.sweep("mean_velocity", **self.ROBOT.parameters)
        assert ls.sweep("mean_velocity", robot=self.ROBOT).values == plain.values
        grid = ls.Grid(segments=[3, 4])
        both = ls.sweep("mean_velocity", grid, robot=self.ROBOT)
        assert both.values[1] == plain.values
        run = ls.simulate(law="coulomb", drive_force=2.0, robot=self.ROBOT)
        assert run.fixed["mu_coulomb"] == 0.3

    def test_a_grid_takes_one(self):
        """The values of the first would win over those of the second, unsaid."""
        other = ls.Robot({**self.ROBOT.parameters, "mu_coulomb": 0.2})
        grid = ls.Grid(robot=self.ROBOT)
        with pytest.raises(ls.InputError, match="robot is given twice"):
            ls.sweep("mean_velocity", grid, robot=other)
        with pytest.raises(ls.InputError, match="robot is given twice"):
            grid.with_fixed({"moving": 1}).with_fixed({"robot": other})

    def test_is_a_robot(self):
        with pytest.raises(ls.InputError, match=r"robot is 'r.toml': allowed is what .*load_robot"):
            ls.sweep("mean_velocity", robot="r.toml")
