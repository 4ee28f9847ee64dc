"""What a diagnosis is given: times count from the start of each run."""

from __future__ import annotations

import numpy as np
import polars as pl
import pytest

from locosweep.diagnosis.data.inputs import read_runs

STAMP = 1.764e9
"""Seconds of a clock on the wall, as a middleware writes them."""


@pytest.mark.parametrize("start", [0.0, STAMP, -3.0])
def test_times_count_from_the_start_of_each_run(start: float) -> None:
    t = np.arange(100) * 0.125
    frame = pl.DataFrame({
        "run": ["a"] * 100 + ["b"] * 100,
        "t": np.concatenate([start + t, start + 50.0 + t]),
        "drive": np.ones(200),
        "x": np.arange(200.0),
    })  # fmt: skip
    runs, notices, _ = read_runs(frame, {}, {})
    said = "runs: t is Unix time: times count from the start of each run"
    assert notices == ([said] if start == STAMP else [])
    for run in runs:
        np.testing.assert_array_equal(run.t, t)
