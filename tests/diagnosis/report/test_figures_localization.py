"""Pictures of where the gap lies."""

import copy
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from locosweep.diagnosis.report.figures_localization import (
    _REGIME_COLOURS,
    _joined,
    force_view,
    origin_strips,
    shares,
    window_strips,
)


def test_windows_that_touch_are_one():
    windows = [{"run": "a", "t0": 1.0, "t1": 2.0, "share": 0.2},
               {"run": "b", "t0": 2.0, "t1": 3.0, "share": 0.1},
               {"run": "a", "t0": 2.0, "t1": 3.0, "share": 0.3},
               {"run": "a", "t0": 4.0, "t1": 5.0, "share": 0.1}]  # fmt: skip
    assert _joined(windows) == [("a", 1.0, 3.0, 0.5), ("a", 4.0, 5.0, 0.1),
                                ("b", 2.0, 3.0, 0.1)]  # fmt: skip


def test_bars_are_the_shares_of_the_report(found):
    left, middle, right = shares(found).axes
    assert [bar.get_width() for bar in left.patches] == [1.0, 0.0]
    assert [bar.get_width() for bar in middle.patches] == [0.9, 0.1]
    names = [text.get_text() for text in middle.get_yticklabels()]
    assert names == ["sliding forward", "at rest"]
    # One line a run from its error after to that before, on a logarithmic axis.
    assert right.get_xscale() == "log"
    first = right.lines[0].get_xdata()
    row = found.where["runs"][0]
    assert first[0] / first[1] == pytest.approx(row["before"] / row["after"])


def test_numbers_below_errors_of_many_sizes_do_not_meet(found):
    own = replace(found, report=copy.deepcopy(found.report))
    for row in own.where["runs"]:
        row["before"], row["after"] = 0.6, 5e-6
    drawn = shares(own)
    drawn.canvas.draw()
    labels = [text for text in drawn.axes[2].get_xticklabels() if text.get_text()]
    boxes = sorted((text.get_window_extent() for text in labels), key=lambda box: box.x0)
    assert len(boxes) >= 2
    assert all(a.x1 < b.x0 for a, b in pairwise(boxes))
    assert not any("e-" in text.get_text() for text in labels)


def test_strips_are_the_residual_and_boxes_the_windows(found):
    ax = window_strips(found, Figure().subplots())
    boxes = [patch for patch in ax.patches if isinstance(patch, Rectangle)]
    rows = found.where["windows"]
    ends = {(box.get_x(), box.get_width()) for box in boxes}
    assert ends == {(row["t0"], row["t1"] - row["t0"]) for row in rows}
    trace = found.traces[0]
    left = trace.measured["x"] - trace.nominal["x"]
    factor = 1e3 if "[mm]" in ax.get_figure().axes[1].get_ylabel() else 1.0
    drawn = ax.collections[0].get_array()
    # Bins of time have nearly equal counts of samples.
    assert np.sqrt(np.mean(drawn**2)) == pytest.approx(factor * np.sqrt(np.mean(left**2)), rel=0.02)


def test_kinds_of_motion_are_strips_over_the_whole_run(found):
    ax = origin_strips(found, Figure().subplots())
    trace = found.traces[0]
    (strip,) = [s for s in ax.collections if s.get_paths()[0].get_extents().y0 == -0.4]
    bars = [path.get_extents() for path in strip.get_paths()]
    assert len(bars) == 1 + np.count_nonzero(np.diff(trace.regime))
    changes = np.flatnonzero(np.diff(trace.regime, prepend=-1))
    colours = [to_rgba(_REGIME_COLOURS[kind]) for kind in trace.regime[changes]]
    assert [tuple(colour) for colour in strip.get_facecolors()] == colours
    width = sum(bar.width for bar in bars)
    assert width == pytest.approx(trace.t[-1] - trace.t[0])


class TestForceView:
    def test_dots_are_the_table(self, found):
        figure = force_view(found)
        assert len(figure.axes) == 6
        assert not figure.axes[5].get_visible()
        drawn = figure.axes[0].lines[1]
        centres, force, _ = found.details["force_view"]["v"]
        factor = 1e3 if "[mN]" in figure.axes[0].get_ylabel() else 1.0
        np.testing.assert_allclose(drawn.get_xdata(), centres)
        np.testing.assert_allclose(drawn.get_ydata(), factor * force)

    def test_none_without_a_table(self, found):
        assert force_view(replace(found, details={})) is None
        empty = {"force_view": {"v": ([], [], [])}}
        assert force_view(replace(found, details=empty)) is None
