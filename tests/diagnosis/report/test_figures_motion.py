"""Curves of runs are the data that they stand for."""

import numpy as np
from matplotlib.figure import Figure

from diagnosis_case import made
from locosweep.diagnosis.report.figures import pictures
from locosweep.diagnosis.report.figures_motion import channel_over_time, residual_over_time


def test_curves_are_the_data(found):
    trace = found.traces[0]
    ax = channel_over_time(found, trace, "x", Figure().subplots())
    assert [line.get_label() for line in ax.lines] == ["measured", "nominal model",
                                                       "augmented model"]  # fmt: skip
    unit = 1e3 if "[mm]" in ax.get_ylabel() else 1.0
    np.testing.assert_allclose(ax.lines[0].get_ydata(), unit * trace.measured["x"])
    np.testing.assert_allclose(ax.lines[1].get_ydata(), unit * trace.nominal["x"])
    after = residual_over_time(found, trace, Figure().subplots(), after=True)
    assert "[µm]" in after.get_ylabel()
    left = 1e6 * (trace.measured["x"] - trace.augmented["x"])
    np.testing.assert_allclose(after.lines[0].get_ydata(), left)


def test_without_effects_no_augmented_model_is_shown(tmp_path):
    one = made(tmp_path, effects={})
    ax = channel_over_time(one, one.traces[0], "x", Figure().subplots())
    assert "augmented model" not in [line.get_label() for line in ax.lines]
    assert "parameters.png" not in pictures(one)


def test_only_what_is_measured(tmp_path):
    one = made(tmp_path, channels=("x",))
    labels = [ax.get_ylabel() for ax in pictures(one)["runs_large.png"].axes]
    assert not any("drive force" in text for text in labels)


def test_a_rotary_bench_turns(tmp_path):
    one = made(tmp_path)
    one.nominal.other["bench.kind"] = "rotary"
    labels = [ax.get_ylabel() for ax in pictures(one)["runs_large.png"].axes]
    assert any(text.endswith("rad]") for text in labels)
    assert any(text.endswith("rad/s]") for text in labels)
    assert any(text.endswith("N m]") for text in labels)
