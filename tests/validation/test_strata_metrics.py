"""Figures and tables of strata."""

from __future__ import annotations

from dataclasses import replace

import pytest

from locosweep.validation.bad_readings import BadJudged
from locosweep.validation.judge import Judged, judge
from locosweep.validation.strata_metrics import bad_figures, stratum_figures, upper_bound
from locosweep.validation.strata_tables import bad_text, stratum_json, stratum_text

OUTSIDE = Judged("out", "outside", "tether", d=30.0, d_name=20.0, status="unexplained", right=True)
WRONG = replace(
    OUTSIDE, status="partial", named=True, said="drive_lag", right=False, family="dust_ridge"
)
OVER = Judged(
    "back", "background", "drive_lag", status="partial", named=True, right=True, times=12.0,
    claimed=0.8, fresh=0.78, interval=(0.7, 0.9),
)  # fmt: skip


def test_upper_bounds_are_exact() -> None:
    # No error in n: the bound b solves (1 - b)^n = 0.05.
    assert upper_bound(0, 100) == pytest.approx(1.0 - 0.05**0.01, rel=1e-9)


def test_wrong_names_outside_the_list_are_certified() -> None:
    clean = {f.name: f for f in stratum_figures("outside", [OUTSIDE] * 59)}
    assert clean["a wrong name"].met
    one = {f.name: f for f in stratum_figures("outside", [*[OUTSIDE] * 59, WRONG])}
    # One of 60 may be few enough; 60 cases do not tell.
    assert one["a wrong name"].met is None
    many = {f.name: f for f in stratum_figures("outside", [*[OUTSIDE] * 59, *[WRONG] * 9])}
    assert many["a wrong name"].met is False
    assert one["a wrong name, families that the mixture lacks"].value == 1.0


def test_a_gap_that_nobody_sees_is_no_success() -> None:
    blind = replace(OUTSIDE, status="none", right=False)
    found = {f.name: f for f in stratum_figures("outside", [OUTSIDE, blind])}
    assert (
        found[
            "no wrong name: `unexplained`, what copies the cause, or the fault of the readings"
        ].value
        == 0.5
    )
    assert found["no gap seen, and no fault of the readings"].value == 0.5


def test_a_cause_outside_the_list_is_said_to_look_like_its_own_variable() -> None:
    truth = {"case": "a", "kind": "outside", "plan": {"mode": "both"}, "channels": ["x"], "d": 30.0,
             "effects": [], "accepted": [], "outside": {"name": "tether"}}  # fmt: skip

    def looks(variable: str | None, status: str = "unexplained") -> bool | None:
        verdict = {"status": status, "effects": [], "equivalent": [], "probability": 0.9,
                   "unlisted": variable and {"variable": variable}}  # fmt: skip
        report = {"verdict": verdict, "where": {"windows": []},
                  "gap": {"channel": None, "shrink_ci": None}}  # fmt: skip
        return judge(truth, report).looks_right

    assert looks("place") is True
    assert looks("time") is False
    assert looks(None) is False
    assert looks("place", "none") is None
    truth["outside"] = {"name": "reading_slips"}
    assert looks("place") is None


def test_friction_along_a_way_that_is_gone_once_may_be_a_force_by_place() -> None:
    truth = {"case": "a", "kind": "outside", "plan": {"mode": "forward"}, "channels": ["x"],
             "d": 30.0, "effects": [], "accepted": [], "outside": {"name": "magnet"}}  # fmt: skip

    def right(name: str, variable: str | None) -> bool:
        verdict = {"status": "ambiguous", "effects": [name], "equivalent": [[name]],
                   "probability": 0.9, "unlisted": variable and {"variable": variable}}  # fmt: skip
        report = {"verdict": verdict, "where": {"windows": [], "site": "friction"},
                  "candidates": [],
                  "gap": {"channel": None, "shrink_ci": None, "shrink": None}}  # fmt: skip
        return judge(truth, report).right

    assert right("position_dependent_friction", "place")
    assert not right("position_dependent_friction", None)
    assert not right("viscous_friction", "place")
    truth["outside"] = {"name": "gusts"}
    assert not right("position_dependent_friction", "place")


def test_a_fault_of_the_readings_that_is_found_is_no_gap() -> None:
    frozen = replace(OUTSIDE, status="none", family="reading_freezes", as_reading=True)
    missed = replace(frozen, as_reading=False, right=False)
    found = {f.name: f for f in stratum_figures("outside", [OUTSIDE, frozen, missed])}
    assert found["no gap seen, and no fault of the readings"].value == pytest.approx(1 / 3)
    assert found["frozen or slipped readings: found as such, no cause named"].value == 0.5
    assert [c.detected for c in (OUTSIDE, frozen, missed)] == [True, True, False]


def test_causes_over_a_background_are_split_by_size() -> None:
    weak = replace(OVER, times=5.0, right=False)
    found = {f.name: f for f in stratum_figures("background", [OVER, weak])}
    assert found["first cause right, 10 to 30 times the background"].value == 1.0
    assert found["first cause right, 3 to 10 times"].value == 0.0
    bias = found["bias of the claimed reduction (claimed less that on fresh runs), mean"]
    assert bias.value == pytest.approx(0.02)
    assert bias.met


def test_over_a_background_a_claim_is_held_against_the_true_effect_too() -> None:
    one = replace(OVER, reached=(0.85, 0.6))
    found = {
        f.name: f for f in stratum_figures("background", [one, OVER, replace(one, right=False)])
    }
    itself = found["reduction by the true effect itself, less that on fresh runs, mean"]
    assert (itself.value, itself.count) == (pytest.approx(0.25), 1)
    claim = found["claimed reduction less that by the true effect on the measured runs, mean"]
    assert claim.value == pytest.approx(-0.05)


def test_the_first_cause_is_judged_over_a_background() -> None:
    truth = {
        "case": "b", "kind": "background", "plan": {"mode": "both"}, "d": 300.0,
        "channels": ["x"], "accepted": [["drive_lag"]], "mismatch": False,
        "background": {"name": "coloured_push", "d": 30.0},
        "reached": {"runs": {"x": 0.9}, "check": {"x": 0.7}},
        "effects": [
            {"name": "drive_lag", "form": "law", "parameters": {}, "accepted": ["drive_lag"],
             "d_name": 100.0, "distances": {}}
        ],
    }  # fmt: skip

    def judged(*names: str) -> Judged:
        share = {"share": 0.5, "share_ci": [0.4, 0.6]}
        verdict = {
            "contributions": [{"effects": [n], **share} for n in names],
            "status": "partial", "effects": [*names], "equivalent": [[n] for n in names],
            "probability": 0.8,
        }  # fmt: skip
        report = {
            "verdict": verdict, "gap": {"channel": "x", "shrink": 0.5, "shrink_ci": [0.4, 0.6]},
            "where": {"site": "drive", "windows": []}, "candidates": [],
        }  # fmt: skip
        return judge(truth, report, fresh=0.55)

    one, two = judged("drive_lag"), judged("drive_lag", "viscous_friction")
    assert one.right
    assert two.right
    assert one.reached == (0.9, 0.7)
    assert not judged("viscous_friction", "drive_lag").right
    found = {f.name: f for f in stratum_figures("background", [one, two])}
    # Shares of two causes have no interval together.
    bias = "bias of the stated share of one cause, `partial` (stated less that on fresh runs), mean"
    assert (found[bias].value, found[bias].count) == (pytest.approx(-0.05), 1)
    assert found["reduction on fresh runs inside the stated interval"].value == 1.0
    assert judge(truth, None, error="none").times == pytest.approx(10.0)


def test_bad_readings_are_judged_by_false_causes() -> None:
    good = BadJudged(
        "bad_0000", "spikes", "0.1", "none", True, ("spike",), "none", "none", 0.9, True, False, 1.0
    )
    bad = replace(good, case="bad_0001", false_cause=True, said="drive_lag", found=False)
    found = {f.name: f for f in bad_figures([good, bad])}
    assert found["a confident false cause"].value == 0.5
    text = bad_text([good, bad])
    assert "bad_0001" in text
    assert "bad_0000" not in text


def test_tables_name_what_was_wrong() -> None:
    text = stratum_text("outside", [OUTSIDE, WRONG])
    assert "dust_ridge" in text.split("wrong verdicts:")[1]
    figures = stratum_figures("outside", [OUTSIDE, WRONG])
    assert stratum_json("outside", [OUTSIDE], figures, {"seed": 1})["stratum"] == "outside"
