"""What pictures and results refuse, in one line that says what is allowed."""

import itertools

import matplotlib.pyplot as plt
import numpy as np
import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.errors import InputError
from locosweep.plot.caption import better_when_larger
from locosweep.plot.numbers import log_axis

SURFACE = {"mu_coulomb": 0.3}


@pytest.fixture(scope="module")
def cube():
    return ls.sweep("mean_velocity", mu_static=[0.4, 0.5, 0.6], segments=[3, 4, 5],
                    slope_deg=[0, 5, 10], **SURFACE)  # fmt: skip


@pytest.mark.parametrize(
    "levels", [-1, 101, 10**9, 2.5, np.inf, True, "x", "7", [None], [np.nan], [[1.0]], object()]
)
def test_levels_that_are_no_contours(cube, levels):
    with pytest.raises(InputError, match="levels is"):
        cube.plot.heatmap(slope_deg=0, levels=levels)


@pytest.mark.parametrize("levels", [None, 0, 5, [], [0.08, 0.09], np.array([0.08])])
def test_levels_that_are(cube, levels):
    cube.plot.heatmap(slope_deg=0, levels=levels)


def test_axes_that_are_none(cube):
    for given in (3, plt.subplots(1, 2)[1]):
        with pytest.raises(InputError, match="allowed is one Axes"):
            cube.plot.heatmap(slope_deg=0, ax=given)
    with pytest.raises(InputError, match="unknown axis '3'"):
        cube.plot.heatmap(3, slope_deg=0)
    point = cube.sel(slope_deg=0, segments=3, mu_static=0.5)
    with pytest.raises(InputError, match="unknown axis 'segments': there is none"):
        point.plot.curves("segments")


def test_no_values_of_an_axis_are_refused(cube):
    with pytest.raises(InputError, match="slope_deg is empty: allowed is a value or more, 0"):
        cube.sel(slope_deg=[])


@pytest.mark.parametrize("limit", ["8", 8e6, -1, 0, True])
def test_limits_of_a_page(cube, limit):
    with pytest.raises(InputError, match=r"limit is .*: allowed is a whole number"):
        cube.explore(limit=limit)


def test_the_place_of_a_best_value_is_no_best_value():
    r = ls.sweep("mean_velocity", mu_static=[0.4, 0.5], segments=[3, 4],
                 slope_deg=np.linspace(-10, 20, 31), over="slope_deg",
                 reduce=["argmax", "argmin", "last_feasible", "max", "min"], **SURFACE)  # fmt: skip
    marked = {o.reduce: better_when_larger(o) for o in r.outputs}
    assert marked == {"argmax": False, "argmin": False, "last_feasible": False,
                      "max": True, "min": True}  # fmt: skip
    ax = r.plot.heatmap(value="mean_velocity_argmax")
    assert not [line for line in ax.lines if line.get_marker() == "*"]


def test_a_name_without_ending(cube, tmp_path, capsys):
    with pytest.raises(InputError, match="picture: a picture needs an ending: allowed are"):
        ls.plot.save_figure(cube.plot.heatmap(slope_deg=0), tmp_path / "picture")
    with pytest.raises(InputError, match="a page needs an ending"):
        cube.explore().save(tmp_path / "page")
    assert main(["heatmap", "mean_velocity", "--x", "segments=3:5", "--y", "mu_static=0.4,0.5",
                 "--set", "mu_coulomb=0.3", "--out", str(tmp_path / "map")]) == 2  # fmt: skip
    assert "has no ending: allowed are .png" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("low", "high", "shown"),
    [(1.8, 87.0, ["3", "10", "30"]), (20.0, 70.0, ["20", "50"]), (0.02, 700.0, None),
     (41.0, 57.0, ["48"])],
)  # fmt: skip
def test_a_logarithmic_axis_has_ticks_that_can_be_read(low, high, shown):
    figure, ax = plt.subplots(figsize=(3, 2))
    ax.set(xscale="log", xlim=(low, high))
    log_axis(ax.xaxis)
    figure.canvas.draw()
    inside = [t for t in ax.xaxis.get_ticklabels() if low <= t.get_position()[0] <= high]
    texts = [t.get_text() for t in inside]
    assert len(texts) <= 7
    assert texts
    if shown is not None:
        assert set(shown) <= set(texts)
    boxes = [t.get_window_extent() for t in inside]
    assert all(a.x1 < b.x0 for a, b in itertools.pairwise(boxes))
