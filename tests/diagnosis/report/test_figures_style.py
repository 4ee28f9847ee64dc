"""Units and labels of pictures."""

import numpy as np
import pytest

from locosweep.diagnosis.report.figures_style import Channel, label


@pytest.mark.parametrize(
    ("largest", "unit"), [(0.4, "m"), (0.04, "mm"), (5e-6, "µm"), (0.0, "m"), (np.nan, "m")]
)
def test_units_read_well(largest, unit):
    factor, found_unit = Channel("x", "m").scale(largest)
    assert found_unit == unit
    assert {"m": 1.0, "mm": 1e3, "µm": 1e6}[unit] == pytest.approx(factor)


def test_labels():
    assert label("$5") == r"\$5"
    assert label("a\nb\u202e") == "a□b□"
    assert len(label("x" * 100)) == 24
