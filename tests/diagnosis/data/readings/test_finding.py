"""Findings as rows of the report and as sentences."""

from __future__ import annotations

import numpy as np

from locosweep.diagnosis.data.readings.finding import Finding, sentences, stretches_of


def spike(t0: float, t1: float, samples: int, run: str = "3") -> Finding:
    return Finding(run, t0, t1, "x", "spike", samples, masked=True)


def test_a_row_has_the_keys_of_the_contract() -> None:
    assert Finding("3", 1.2, 1.4, "x", "frozen", 40, masked=True).row() == {
        "run": "3", "t0": 1.2, "t1": 1.4, "column": "x", "kind": "frozen", "samples": 40,
        "masked": True,
    }  # fmt: skip
    assert Finding("", 0.0, 1.0, "x", "unit", 9, False, likely="mm").row()["likely"] == "mm"


def test_a_sentence_gathers_what_is_alike() -> None:
    said = sentences([spike(0.2, 0.2, 1), spike(1.25, 1.26, 2), spike(0.5, 0.5, 1, "4")])
    assert said == [
        "run 3: 3 readings of x between 0.2 and 1.26 s lie far off their neighbours: left out",
        "run 4: a reading of x at 0.5 s lies far off its neighbours: left out",
    ]
    frozen = Finding("3", 1.2, 1.4, "x", "frozen", 40, masked=True)
    assert sentences([frozen]) == ["run 3: 40 readings of x between 1.2 and 1.4 s are frozen: "
                                   "left out"]  # fmt: skip


def test_other_kinds_say_it_themselves() -> None:
    assert sentences([Finding("3", 1.0, 1.1, "x", "slip", 9, True, "it slipped")]) == [
        "run 3: it slipped"
    ]
    assert sentences([Finding("", 0.0, 1.0, "x", "unit", 9, False, "in mm")]) == ["in mm"]


def test_stretches_end_where_a_gap_is_longer() -> None:
    bad = np.array([1, 1, 0, 1, 0, 0, 0, 1], dtype=bool)
    assert stretches_of(bad) == [(0, 1), (3, 3), (7, 7)]
    assert stretches_of(bad, 2) == [(0, 3), (7, 7)]
    assert stretches_of(np.zeros(4, dtype=bool)) == []
