"""The stratum with bad readings: how faults are put in, and how verdicts on them are judged."""

from __future__ import annotations

from typing import Any

import numpy as np
import polars as pl
import pytest

from locosweep.files.robot import load_robot
from locosweep.files.runs import load_runs
from locosweep.validation.bad_readings import FAULTS, judge_bad, kind_of, spoil, write_bad
from locosweep.validation.case_files import runs_file
from locosweep.validation.cases import draw_case

T = np.arange(500) * 0.01
NOISE = 1e-5


def frame() -> pl.DataFrame:
    rng = np.random.default_rng(0)
    parts = [
        pl.DataFrame({
            "run": [f"r{k}"] * T.size, "t": T, "drive": np.cos(T + k),
            "x": 0.1 * np.sin(T + k) + rng.normal(0.0, NOISE, T.size),
        })
        for k in range(4)
    ]  # fmt: skip
    return pl.concat(parts)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_where_it_is_said_to_be(fault: str) -> None:
    clean = frame()
    rng = np.random.default_rng(5)
    found = spoil(clean, fault, rng, deviation=NOISE, rotary=False)
    assert found.frame["t"].equals(clean["t"])
    assert found.places
    changed = np.zeros(clean.height, dtype=bool)
    for name in ("x", "drive"):
        size = np.abs(found.frame[name].to_numpy() - clean[name].to_numpy())
        changed |= size > NOISE
    inside = np.zeros(clean.height, dtype=bool)
    labels, t = clean["run"].to_numpy(), clean["t"].to_numpy()
    for run, first, last in found.places:
        inside |= (labels == run) & (t >= first) & (t <= last)
    assert not (changed & ~inside).any()
    assert found.samples == inside.sum()
    if fault not in ("unit", "sign", "swapped", "noise"):
        assert changed[inside].all()


def test_the_kind_of_a_case_is_known_before_it_is_drawn() -> None:
    index = next(i for i in range(20) if kind_of(7, i) == "none")
    assert draw_case(7, index).kind == "none"


def test_a_case_with_a_fault_is_a_case_like_others(tmp_path) -> None:
    # A case without a gap: others take their time to draw.
    seed = next(s for s in range(99) if kind_of(s, 0) == "none")
    name = write_bad(tmp_path, seed, 0)
    runs, notices = load_runs(runs_file(tmp_path / name))
    load_robot(tmp_path / name / "nominal.toml")
    assert notices == []
    assert len(runs) >= 3
    truth = (tmp_path / "sealed" / name / "truth.json").read_text()
    assert '"name": "spikes"' in truth


def truth(fault: str = "frozen", form: str = "", effect: str | None = None) -> dict[str, Any]:
    return {
        "case": "bad_0001",
        "effects": [{"name": effect}] if effect else [],
        "accepted": [[effect], ["payload_mass"]] if effect else [],
        "fault": {"name": fault, "form": form, "places": [["r1", 1.0, 2.0]], "samples": 100},
    }


def report(status: str, *names: str, probability: float = 0.9, **more: Any) -> dict[str, Any]:
    verdict = {
        "status": status, "effects": list(names[:1]), "equivalent": [list(names)] if names else [],
        "probability": probability,
    }  # fmt: skip
    return {"verdict": verdict, "warnings": [], "readings": [], **more}


def row(kind: str, t0: float, t1: float, run: str = "r1", column: str = "x") -> dict[str, Any]:
    return {"run": run, "t0": t0, "t1": t1, "column": column, "kind": kind}


class TestJudge:
    @pytest.mark.parametrize(
        ("finding", "found"),
        [(row("frozen", 1.5, 3.0), True), (row("frozen", 2.5, 3.0), False),
         (row("frozen", 1.5, 3.0, run="r2"), False), (row("spike", 1.5, 3.0), False),
         (row("frozen", 1.5, 3.0, column="drive"), False)],
    )  # fmt: skip
    def test_a_finding_has_kind_run_time_and_column(self, finding, found) -> None:
        assert judge_bad(truth(), report("none", readings=[finding])).found is found

    def test_noise_is_found_by_a_warning(self) -> None:
        said = ["x: all readings show noise of 3, 20 times the stated one"]
        assert judge_bad(truth("noise"), report("none", warnings=said)).found
        assert not judge_bad(truth("noise"), report("none")).found

    def test_a_unit_of_the_drive_is_found_in_its_column(self) -> None:
        rows = [row("unit", 0.0, 9.0, column="drive")]
        assert judge_bad(truth("unit", "drive mN"), report("none", readings=rows)).found
        assert not judge_bad(truth("unit", "x mm"), report("none", readings=rows)).found

    def test_a_cause_that_is_not_there_is_false_if_it_is_sure(self) -> None:
        wrong = judge_bad(truth(), report("explained", "drive_lag"))
        assert (wrong.false_cause, wrong.right) == (True, False)
        unsure = judge_bad(truth(), report("explained", "drive_lag", probability=0.5))
        assert not unsure.false_cause
        partial = judge_bad(truth(effect="drive_lag"), report("partial", "viscous_friction"))
        assert partial.false_cause

    def test_the_true_cause_or_nothing_is_not_false(self) -> None:
        for verdict in (report("none"), report("unexplained")):
            assert not judge_bad(truth(effect="drive_lag"), verdict).false_cause
        assert judge_bad(truth(), report("none")).right
        right = judge_bad(truth(effect="drive_lag"), report("ambiguous", "x", "payload_mass"))
        assert (right.right, right.false_cause) == (True, False)

    def test_no_report_is_an_error(self) -> None:
        found = judge_bad(truth(), None, error="LinAlgError")
        assert (found.status, found.error, found.right) == ("error", "LinAlgError", False)
