"""The verdict as a sentence."""

from __future__ import annotations

from typing import Any

import pytest

from locosweep.diagnosis.report.sentences import no_gap, summary


def report(status: str, *classes: list[str], **more: Any) -> dict[str, Any]:
    verdict = {"status": status, "probability": 0.93, "equivalent": list(classes),
               "law_mismatch": False}  # fmt: skip
    gap = {"channel": "x", "unit": "m", "before": 2e-3, "after": 1.1e-5, "noise_floor": 1e-5,
           "shrink": 0.9945}  # fmt: skip
    gap |= more.pop("gap", {})
    return {"verdict": verdict | more.pop("verdict", {}), "gap": gap, "candidates": [], **more}


def test_no_gap() -> None:
    text = summary(report("none"))
    assert "no gap beyond the noise" in text
    assert text.endswith("(93% sure).")


def test_a_cause_comes_with_its_numbers() -> None:
    text = summary(report("explained", ["drive_lag"]))
    assert text.startswith("The gap comes from drive lag: ")
    for part in ("error in x", "99.5%", "1.1e-05 m", "noise 1e-05"):
        assert part in text


def test_several_causes_and_classes() -> None:
    pair = summary(report("ambiguous", ["viscous_friction", "back_emf"], ["drive_lag"]))
    assert "from (viscous friction or back emf) and drive lag" in pair
    assert "cannot tell" in pair
    assert ": with them the error" in pair
    alone = summary(report("ambiguous", ["viscous_friction", "back_emf"]))
    assert "from viscous friction or back emf" in alone
    assert ": with it the error" in alone


def test_an_improvement_that_is_not_known_is_not_told() -> None:
    text = summary(report("explained", ["drive_lag"], gap={"shrink": None}))
    assert "%" not in text.replace("93%", "")


def test_another_law() -> None:
    text = summary(report("explained", ["drive_lag"], verdict={"law_mismatch": True}))
    assert "may come from drive lag" in text


def test_validation_data_without_a_gap() -> None:
    assert no_gap("windows").startswith("the windows kept from the fit show no gap")


class TestUnexplained:
    def test_the_size_is_told_in_units_of_the_noise(self) -> None:
        assert "gap in x is 200 times the noise" in summary(report("unexplained"))

    def test_runs_without_noise_have_no_size_in_units_of_it(self) -> None:
        text = summary(report("unexplained", gap={"noise_floor": 0.0}))
        assert "size of the gap in x is not known" in text

    def test_a_size_that_validation_data_do_not_show(self) -> None:
        text = summary(report("unexplained", gap={"before": None}))
        assert "the size of the gap in x is not known" in text

    def test_the_nearest_candidate(self) -> None:
        rows = [{"effects": [], "shrink": 0.0}, {"effects": ["drive_lag"], "shrink": 0.4}]
        assert "drive lag" in summary(report("unexplained", candidates=rows))

    def test_a_set_that_one_force_along_the_way_replaces(self) -> None:
        text = summary(report("unexplained", verdict={"unlisted": {"effects": ["drive_lag"]}}))
        assert "drive lag would do" in text

    @pytest.mark.parametrize(("others", "said"), [(2, " or, as well, "), (4, "or 2 more")])
    def test_effects_that_come_near(self, others: int, said: str) -> None:
        names = ["payload_mass", "back_emf", "drive_lag", "supply_sag"][:others]
        near = {"effects": ["quadratic_drag", "slope_error"], "shrink_without_worst": 0.61,
                "as_near": [[name] for name in names]}  # fmt: skip
        rows = [{"effects": ["quadratic_drag", "slope_error"], "shrink": 0.52}]
        text = summary(report("unexplained", verdict={"nearest": near}, candidates=rows))
        assert "quadratic drag with slope error" in text
        assert "52% smaller (61% without" in text
        assert said in text

    def test_nothing_near(self) -> None:
        assert "none" in summary(report("unexplained", verdict={"nearest": None}))
