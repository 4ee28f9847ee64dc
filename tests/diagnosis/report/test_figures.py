"""All pictures of a diagnosis together."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from diagnosis_case import made
from locosweep.diagnosis.report import figures
from locosweep.diagnosis.report.figures import pictures


def test_axes_have_words_and_units(found):
    for name, figure in pictures(found).items():
        for ax in figure.axes:
            if not ax.get_visible() or not ax.xaxis.get_visible():
                continue
            text = ax.get_xlabel() + ax.get_ylabel()
            assert text, name
        labels = " ".join(ax.get_xlabel() + ax.get_ylabel() for ax in figure.axes)
        assert "[" in labels, name


OF_RUNS = ("runs_large.png", "runs_small.png", "where_in_time.png", "shares.png")
"""Pictures that show runs with their names."""


@pytest.mark.whole
def test_labels_of_files_are_drawn_as_they_are(hostile):
    drawn = pictures(hostile)
    for name in OF_RUNS:
        drawn[name].draw_without_rendering()


@pytest.mark.whole
def test_missing_samples_leave_gaps(tmp_path):
    one = made(tmp_path)
    for trace in one.traces:
        trace.measured["x"][::3] = np.nan
    drawn = pictures(one)
    for name in OF_RUNS:
        drawn[name].draw_without_rendering()


def test_a_picture_without_data_is_left_out(found, monkeypatch):
    made = Figure()
    monkeypatch.setattr(figures, "FILES", {"a.png": lambda _: made, "b.png": lambda _: None})
    assert pictures(found) == {"a.png": made}
