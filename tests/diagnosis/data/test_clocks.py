"""Runs on the ticks of their clocks, and what is said about that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from locosweep.diagnosis.data.clocks import Finding, in_words, on_their_clocks, packets_spread
from locosweep.diagnosis.data.inputs import read_runs
from locosweep.errors import DataFileError
from locosweep.files.runs import Run

T = 0.01 * np.arange(400)
DRIVE = np.where(np.sin(7.0 * T) > 0.0, 1.0, -1.0)
RNG = np.random.default_rng(5)


def run(label: str, t: np.ndarray = T, speed: float = 4.0) -> Run:
    """A run read at even times, whatever its stamps."""
    x = 0.1 * np.sin(speed * T) + RNG.normal(0.0, 1e-6, T.size)
    return Run(label, t, DRIVE, {"x": x})


def test_an_even_run_stays_as_it_is() -> None:
    own = run("0")
    (found,), findings = on_their_clocks([own])
    assert found is own
    assert findings == []


def test_jitter_is_taken_out_of_all_runs_if_those_that_move_show_it() -> None:
    stamps = T + 0.002 * RNG.uniform(-1.0, 1.0, T.size)
    runs = [run("a", stamps), run("b", stamps, speed=0.0)]
    found, findings = on_their_clocks(runs)
    for one in found:
        assert one.t == pytest.approx(T, abs=3e-4)
    assert [(f.run, f.column, f.kind, f.samples, f.masked) for f in findings] == [
        ("a", "t", "clock", 400, False),
        ("b", "t", "clock", 400, False),
    ]
    assert on_their_clocks(runs[1:]) == (runs[1:], [])


def test_rows_that_were_taken_beside_the_ticks_stay() -> None:
    stamps = T + 0.002 * RNG.uniform(-1.0, 1.0, T.size)
    beside = replace(run("0", stamps), channels={"x": 0.1 * np.sin(4.0 * stamps)})
    assert on_their_clocks([beside]) == ([beside], [])


def test_rows_that_miss_are_found_gap_by_gap() -> None:
    kept = np.delete(np.arange(T.size), [50, 51, 200])
    own = run("0")
    part = Run("0", T[kept], DRIVE[kept], {"x": own.channels["x"][kept]})
    (found,), findings = on_their_clocks([part])
    assert found.t == pytest.approx(T)
    assert [(f.t0, f.t1, f.samples, f.masked) for f in findings] == [
        (T[49], T[52], 2, True),
        (T[199], T[201], 1, True),
    ]


def test_packets_are_spread_as_a_file_is_read_and_one_repeated_stamp_is_refused() -> None:
    stamps = np.repeat(T[::5], 5)
    frame = pl.DataFrame({"t": stamps, "drive": DRIVE, "x": run("0").channels["x"]})
    (found,), notices, _ = read_runs(frame, {}, {})
    assert np.diff(found.t) == pytest.approx(0.01, rel=0.01)
    assert notices == [
        "run 0: 320 rows came in packets with one time stamp: they are spread evenly"
    ]
    once = T.copy()
    once[7] = once[6]
    with pytest.raises(DataFileError, match=r"row 8, column t: 0\.06 s after 0\.06 s"):
        read_runs(frame.with_columns(t=pl.Series(once)), {}, {})
    findings: list[Finding] = []
    assert packets_spread(findings)("0", T) is T
    assert findings == []


def test_a_sentence_counts_samples_and_names_some_runs() -> None:
    def found(run: str, what: str) -> Finding:
        return Finding(run, 0.0, 1.0, "t", "clock", 2, masked=False, what=what)

    assert in_words([found("0", "jump"), found("0", "jump"), found("1", "miss")]) == [
        "run 0: 4 jump",
        "run 1: 2 miss",
    ]
    assert in_words([found(str(k), "jump") for k in range(9)]) == [
        "runs 0, 1, 2, 3, 4 and 4 others: 18 jump"
    ]
    assert in_words([]) == []
