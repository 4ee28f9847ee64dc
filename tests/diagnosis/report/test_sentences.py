"""The verdict as a sentence."""

from __future__ import annotations

from typing import Any, ClassVar

from locosweep.diagnosis.report.sentences import advice, found_law, no_gap, shortfall, summary


def report(status: str, *classes: list[str], **more: Any) -> dict[str, Any]:
    verdict = {"status": status, "probability": 0.93, "equivalent": list(classes),
               "law_mismatch": False, "unlisted": None,
               "laws": []}  # fmt: skip
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
    for part in ("error in x", "from 2 mm to 11 µm", "noise 10 µm"):
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


class TestAdvice:
    """What to do, from the parameters of the causes."""

    LIMIT: ClassVar = {"F_max": {"value": 0.8499981, "std": 2.5e-6, "unit": "N"}}
    BUILDUP: ClassVar = {"k_b": {"value": 12.0004, "std": 0.9, "unit": "N/m"}}

    def found(self, status: str = "explained", **more: Any) -> str:
        names = ["drive_saturation", "lubricant_buildup"]
        row = {"effects": names[::-1], "shrink": 0.9,
               "parameters": {names[0]: self.LIMIT, names[1]: self.BUILDUP}}  # fmt: skip
        verdict = {"effects": names} | more
        return advice(report(status, *([n] for n in names), verdict=verdict, candidates=[row]))

    def test_values_stand_in_words_and_are_rounded(self) -> None:
        for status in ("explained", "partial"):
            assert self.found(status) == (
                "What to do: give the model drive saturation (largest drive force 0.85 N) and "
                "lubricant buildup (resistance per distance swept since the last rest or turn "
                "12 N/m)."
            )

    def test_nothing_is_advised_where_nothing_is_settled(self) -> None:
        for status in ("ambiguous", "unexplained", "none"):
            assert self.found(status) == ""
        assert self.found(law_mismatch=True) == ""
        assert self.found(equivalent=[["drive_saturation", "back_emf"]]) == ""


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

    def test_a_force_that_is_in_no_list(self) -> None:
        unlisted = {"family": "force by place, both ways alike", "like": "a tether",
                    "outdoes": True, "formula": "-3 N/m of x", "share": 0.83}  # fmt: skip
        rows = [{"effects": ["drive_lag"], "shrink": 0.4}]
        text = summary(report("unexplained", verdict={"unlisted": unlisted}, candidates=rows))
        assert "as well as a force by place, both ways alike, as of a tether, does" in text
        assert "[-3 N/m of x; takes away 83% of the error]" in text
        # A single effect may come down to the noise as well.
        assert "nearest comes drive lag (" in text
        assert shortfall({"unlisted": unlisted}) == "does less than a force in no list"
        like = unlisted | {"outdoes": False}
        text = summary(report("unexplained", verdict={"unlisted": like}))
        assert (
            "it looks most like a force by place, both ways alike, as of a tether [-3 N/m" in text
        )
        for other in (None, like):
            assert shortfall({"unlisted": other}) == "leaves more than noise"

    def test_a_law_that_replays_refute_is_told_as_such(self) -> None:
        law = {"formula": "2 N beyond x = 3 mm", "share": -0.4}
        assert found_law(law).endswith(
            "; only to first order: replayed, it makes the error larger]"
        )
        assert found_law(law | {"share": 0.01}) == " [2 N beyond x = 3 mm]"

    def test_a_law_as_it_was_found(self) -> None:
        law = {"formula": "2 N beyond x = 3 mm", "share": None}
        text = summary(report("explained", verdict={"law_mismatch": True, "laws": [law]}))
        assert "by another law than the usual formula [2 N beyond x = 3 mm]" in text


class TestPartial:
    def verdict(self, **more: Any) -> dict[str, Any]:
        rows = [{"effects": ["drive_lag"], "share": 0.81},
                {"effects": ["payload_mass", "drive_gain_error"], "share": 0.12}]  # fmt: skip
        left = {"share": 0.07, "rmse": 1.1e-3, "shape": [{"formula": "friction by the load"}]}
        return {"effects": ["drive_lag", "payload_mass"], "contributions": rows,
                "remaining": left | more}  # fmt: skip

    def test_causes_come_with_their_shares_and_values(self) -> None:
        entry = {"T": {"value": 0.012, "std": 1e-3, "unit": "s"}}
        row = {"effects": ["payload_mass", "drive_lag"], "parameters": {"drive_lag": entry}}
        text = summary(report("partial", verdict=self.verdict(), candidates=[row]))
        assert text.startswith("Drive lag (T = 0.012 s) makes 81% of the gap in x, ")
        assert "payload mass or drive gain error 12%" in text
        assert "7% (1.1 mm) nobody has explained: most like friction by the load" in text

    def test_without_values_or_a_known_rest(self) -> None:
        text = summary(report("partial", verdict=self.verdict(share=None, shape=[])))
        assert text.startswith("Drive lag makes 81%")
        assert "nobody" not in text
