"""Pictures of causes show the numbers of the report."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from locosweep.diagnosis.report.figures_cause import candidates, horizons, leading, parameters

if TYPE_CHECKING:
    from locosweep.diagnosis import Diagnosis


@pytest.fixture
def own(found: Diagnosis) -> Diagnosis:
    """A diagnosis whose report a test may change."""
    return replace(found, report=copy.deepcopy(found.report))


class TestCandidates:
    def test_bars_are_probabilities_and_dots_the_improvement(self, own: Diagnosis) -> None:
        figure = candidates(own)
        assert figure is not None
        left, right = figure.axes
        assert [bar.get_width() for bar in left.patches] == [0.97, 0.01, 0.01]
        names = [text.get_text() for text in left.get_yticklabels()]
        assert names == ["lubricant buildup", "viscous friction", "drive lag"]
        interval, *dots = right.lines
        assert list(interval.get_xdata()) == own.gap["shrink_ci"]
        assert [line.get_xdata()[0] for line in dots] == [row["shrink"] for row in own.candidates]

    def test_an_improvement_that_is_not_known(self, own: Diagnosis) -> None:
        own.report["candidates"][1]["shrink"] = None
        figure = candidates(own)
        assert figure is not None
        assert "unknown" in [text.get_text() for text in figure.axes[1].texts]

    def test_weights_say_what_they_are_given(self, own: Diagnosis) -> None:
        for status, given in (
            ("explained", "leaves only noise"),
            ("partial", "nobody has explained"),
        ):
            own.report["verdict"]["status"] = status
            figure = candidates(own)
            assert figure is not None
            assert given in figure.axes[0].get_xlabel()

    def test_none_without_candidates(self, own: Diagnosis) -> None:
        own.report["candidates"] = []
        assert candidates(own) is None


def test_the_leading_candidate_is_the_set_that_the_verdict_names(own: Diagnosis) -> None:
    rows = [{"effects": ["a"]}, {"effects": ["a", "b"]}]
    own.report["candidates"] = rows
    own.report["verdict"]["effects"] = ["b", "a"]
    assert leading(own) is rows[1]
    own.report["verdict"]["effects"] = []
    assert leading(own) is None


class TestParameters:
    def test_the_value_stands_in_its_interval(self, own: Diagnosis) -> None:
        figure = parameters(own)
        assert figure is not None
        (ax,) = figure.axes
        # 0.6 N/m with a deviation of 1 %: 1.96 deviations are 0.01176.
        assert ax.get_title(loc="right") == "0.600 ± 0.012 N/m"
        (ends,) = ax.collections[0].get_segments()
        np.testing.assert_allclose(ends[:, 0], [0.6 - 0.01176, 0.6 + 0.01176])

    def test_a_narrow_interval_is_shown_about_its_value(self, own: Diagnosis) -> None:
        own.report["candidates"][0]["parameters"]["lubricant_buildup"]["k_b"]["std"] = 1e-6
        figure = parameters(own)
        assert figure is not None
        (ax,) = figure.axes
        assert ax.get_xlabel().endswith(" − 0.6 N/m [µN/m]")
        (ends,) = ax.collections[0].get_segments()
        np.testing.assert_allclose(ends[:, 0], [-1.96, 1.96])
        assert ax.get_title(loc="right") == "0.6000000 ± 2e-06 N/m"
        figure.canvas.draw()
        assert not ax.xaxis.get_offset_text().get_text()

    def test_an_unknown_deviation_is_said(self, own: Diagnosis) -> None:
        own.report["candidates"][0]["parameters"]["lubricant_buildup"]["k_b"]["std"] = None
        figure = parameters(own)
        assert figure is not None
        assert figure.axes[0].get_title(loc="right") == "0.6, interval unknown N/m"

    def test_none_without_effects(self, own: Diagnosis) -> None:
        own.report["verdict"]["effects"] = []
        assert parameters(own) is None


class TestHorizons:
    def test_a_line_for_the_nominal_model_and_after_each_cause(self, own: Diagnosis) -> None:
        own.report["verdict"]["effects"] = ["drive_saturation", "lubricant_buildup"]
        errors = {"nominal model": [1e-3, 2e-2], "drive_saturation": [5e-4, 1e-3],
                  "lubricant_buildup": [5e-6, 5e-6]}  # fmt: skip
        details = own.details | {"free_runs": {"seconds": [0.1, 1.0], "errors": errors,
                                           "restarted": False}}  # fmt: skip
        figure = horizons(replace(own, details=details))
        assert figure is not None
        (ax,) = figure.axes
        assert [line.get_label() for line in ax.lines] == [
            "nominal model", "with drive saturation", "… and lubricant buildup", "noise floor"
        ]  # fmt: skip
        for line, known in zip(ax.lines, errors.values(), strict=False):
            np.testing.assert_allclose(line.get_ydata(), np.multiply(1e3, known))

    def test_errors_over_the_length_of_free_runs(self, own: Diagnosis) -> None:
        figure = horizons(own)
        assert figure is not None
        (ax,) = figure.axes
        before, after, floor = ax.lines
        rows = own.gap["horizons"]
        factor = before.get_ydata()[0] / rows[0]["before"]
        assert factor == pytest.approx(1e3 if "[mm]" in ax.get_ylabel() else 1.0)
        np.testing.assert_allclose(before.get_xdata(), [0.1, 0.5, 2.0])
        np.testing.assert_allclose(after.get_ydata(), [factor * row["after"] for row in rows])
        assert floor.get_ydata()[0] == pytest.approx(factor * own.gap["noise_floor"])

    def test_none_where_no_error_is_known(self, own: Diagnosis) -> None:
        own.report["gap"]["horizons"] = [{"seconds": 0.1, "before": None, "after": None}]
        assert horizons(own) is None
