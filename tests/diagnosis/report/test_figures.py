"""All pictures of a diagnosis together."""

import numpy as np

from diagnosis_case import made
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


def test_labels_of_files_are_drawn_as_they_are(hostile):
    for figure in pictures(hostile).values():
        figure.draw_without_rendering()


def test_missing_samples_leave_gaps(tmp_path):
    one = made(tmp_path)
    for trace in one.traces:
        trace.measured["x"][::3] = np.nan
    for figure in pictures(one).values():
        figure.draw_without_rendering()
