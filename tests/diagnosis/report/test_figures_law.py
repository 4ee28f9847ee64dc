"""The picture of a law that the formulas lack."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from locosweep.diagnosis.report.figures_law import law

if TYPE_CHECKING:
    from locosweep.diagnosis import Diagnosis

AT = np.linspace(0.0, 0.05, 11)


def row(parity: str = "even", **changes: Any) -> dict[str, Any]:
    """A law of 1 mN, read as a force by place."""
    value = 1e-3 * np.ones(AT.size)
    curve = {
        "at": AT.tolist(),
        "at_unit": "m",
        "value": value.tolist(),
        "std": (0.1 * value).tolist(),
        "by_formula": value.tolist(),
        "unit": "N",
    }
    return {
        "outdoes": True,
        "family": "force by place",
        "like": "a wall",
        "variable": "place",
        "parity": parity,
        "formula": "1 mN, the same everywhere",
        "share": None,
        "curve": curve | changes,
    }


@pytest.fixture
def own(found: Diagnosis) -> Diagnosis:
    """A diagnosis without a law, whose report a test may change."""
    made = replace(found, report=copy.deepcopy(found.report))
    made.report["verdict"]["laws"] = []
    return made


def test_none_where_no_law_was_found(own: Diagnosis) -> None:
    assert law(own) is None
    own.report["verdict"]["unlisted"] = row() | {"curve": None}
    assert law(own) is None


def test_curve_band_and_formula_stand_in_units_that_read_well(own: Diagnosis) -> None:
    own.report["verdict"]["unlisted"] = row()
    figure = law(own)
    assert figure is not None
    (ax,) = figure.axes
    assert ax.get_xlabel() == "place [mm]"
    assert ax.get_ylabel() == "force [mN]"
    assert "1 mN, the same everywhere" in ax.get_title(loc="left")
    curve, formula, _ = ax.lines
    for line in (curve, formula):
        assert np.allclose(line.get_xdata(), 1e3 * AT)
        assert np.allclose(line.get_ydata(), 1.0)
    (band,) = ax.collections
    low, high = band.get_datalim(ax.transData).intervaly
    assert np.isclose(high - low, 2 * 1.96 * 0.1)


def test_each_law_has_axes_of_its_own(own: Diagnosis) -> None:
    own.report["verdict"]["laws"] = [{"effect": "quadratic_drag", **row("odd", by_formula=None)}]
    own.report["verdict"]["unlisted"] = row()
    figure = law(own)
    assert figure is not None
    first, second = figure.axes
    assert first.get_title(loc="left").startswith("law of quadratic drag")
    assert first.get_ylabel() == "resistance [mN]"
    assert len(first.lines) == 2
    assert len(second.lines) == 3
