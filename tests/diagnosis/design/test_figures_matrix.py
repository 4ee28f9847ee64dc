"""The picture of distances: labels, numbers, frames of pairs too near."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from locosweep.diagnosis.design.distinguish import Distinction
from locosweep.diagnosis.design.figures_matrix import matrix


@pytest.fixture
def distinction():
    distances = np.array([[0.0, 1.0, 9.0], [2.0, 0.0, 10.0], [8.0, 10.0, 0.0]])
    names = ("slope_error", "coulomb_error", "drive_lag")
    return Distinction(names, distances, 10.0, {n: [{}] for n in names}, {}, {"x": 1e-4})


def test_both_axes_name_every_effect(distinction):
    ax = matrix(distinction, ax=Figure().subplots())
    for axis in (ax.xaxis, ax.yaxis):
        labels = [label.get_text() for label in axis.get_ticklabels()]
        assert [name for name in labels if name] == ["slope error", "coulomb error", "drive lag"]


def test_it_draws_where_it_is_told(distinction):
    ax = Figure().subplots()
    assert matrix(distinction, ax=ax) is ax


def test_rivals_are_those_nearer_than_three_deviations(distinction):
    assert distinction.rivals("slope_error") == ["coulomb_error"]
    assert distinction.rivals("drive_lag") == []
